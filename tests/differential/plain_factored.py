"""Factored dual memory in plain Python: objects and dictionaries, one lane group at a time."""

import math

import numpy as np

from dmil.scenarios import signal_times
from tests.differential.plain_guard import PlainGuard
from tests.differential.plain_lanes import groups_of
from tests.differential.plain_movements import PlainMovements

RED, KEPT, SWITCHED, PARTLY = range(4)
QUEUE_BINS = [*range(9), 9, 11, 15]
SINGLE = np.float32
RATE_EDGES = tuple(SINGLE(edge) for edge in (0.15, 0.4, 0.8, 1.5, 3.0))
TIE, TIE_PART = 2e-4, 4e-7
DEFAULTS = {
    "approaching": True,
    "rates": True,
    "expected": 0.3,
    "wave": 0.7,
    "learning": True,
    "discount": 0.9,
    "vehicle": 2.0,
    "trust": 0.05,
    "trust_veh": 1.0,
    "rate_step": 0.02,
    "yields": False,
    "age": 0.0,
    "waves": "everywhere",
    "outside": False,
    "recall": False,
}
FULL, MOST_OUTSIDE = 0.8, SINGLE(20)


class PlainFactored:
    """The whole decision of all intersections; `table` maps (row, treatment) to its entry."""

    def __init__(self, options=None):
        self.options = {**DEFAULTS, **(options or {})}
        self.table = {}

    def reset(self, context):
        self.network, timing = context.network, context.timing
        self.interval_s = timing.decision_interval_s
        lost_s = timing.clearance_s + timing.startup_lost_s
        self.after_switch = max(0.0, 1 - lost_s / self.interval_s)
        self.flow_veh = context.dynamics.saturation_flow_veh_per_s * self.interval_s
        self.groups = {node.id: groups_of(node) for node in self.network.intersections}
        self.time_s = {link.id: link.free_flow_time_s for link in self.network.links}
        self.signalled = {node.id for node in self.network.intersections}
        self.end = {link.id: link.end for link in self.network.links}
        nodes = [*self.network.intersections, *self.network.junctions]
        self.ways = {link.id: [] for link in self.network.links}
        for movement in (movement for node in nodes for movement in node.movements):
            self.ways[movement.from_link].append(movement.to_link)
        moves = [m for node in self.network.intersections for m in node.movements]
        self.fed = {self.ahead(movement.to_link) for movement in moves}
        dynamics = context.dynamics
        self.fills = self.options["outside"] and dynamics.storage
        self.room_veh = {
            link.id: link.length_m / dynamics.vehicle_space_m for link in self.network.links
        }
        self.guard = PlainGuard(self.network, self.interval_s)
        self.asked = None
        all_stop = signal_times(timing, self.network).all_stop.tolist()
        self.moves = PlainMovements(
            self.network, timing, self.flow_veh, self.after_switch, self.options, all_stop
        )
        self.moves.find_apart(self.groups)
        self.choosers = {node.id for node in self.network.intersections if len(node.phases) > 1}

    def ahead(self, link):
        """Return the link at whose end the next signal stands, None if it is not the only way."""
        passed = []
        while self.end[link] not in self.signalled:
            passed.append(link)
            if len(self.ways[link]) != 1 or self.ways[link][0] in passed:
                return None
            link = self.ways[link][0]
        return link

    def waved(self, link):
        """Return for how much a green ahead counts: as `unseen`, perhaps only at a choice."""
        counts = self.options["waves"] == "everywhere" or self.end[link] in self.choosers
        return self.unseen(link) if counts else 0.0

    def unseen(self, link):
        return max(0.0, 1 - self.time_s[link] / self.interval_s)

    def look_at_all(self, seen):
        """Take in what is seen."""
        self.seen = seen
        self.guard.look(seen)
        for i, node in enumerate(self.network.intersections):
            for group in self.groups[node.id]:
                self.look(group, i, seen)
        self.moves.look(seen, self.asked, self.groups)

    def decide(self, seen):
        self.look_at_all(seen)
        for group in self.all_groups():
            if group.link not in self.fed:
                more = self.options["expected"] * self.unseen(group.link) * float(group.rate)
                group.expected += SINGLE(more)
        phases = self.choose(seen.phase, {})
        if self.options["expected"] or self.options["wave"]:
            inflow = self.announced_inflow(phases, seen)
            for group in self.all_groups():
                share = self.arriving(group) / sum(
                    self.arriving(other) for other in self.on_link(group.link)
                )
                more = self.options["expected"] * inflow.get(group.link, 0.0) * share
                group.expected += SINGLE(more / group.count)
            phases = self.choose(seen.phase, self.announced_green(phases))
        self.learn(phases, seen)
        self.asked = phases
        return phases

    def all_groups(self):
        return [group for groups in self.groups.values() for group in groups]

    def on_link(self, link):
        return [group for group in self.groups[self.end[link]] if group.link == link]

    def arriving(self, group):
        return group.count * (float(group.rate) + 0.05)

    def look(self, group, i, seen):
        def per_lane(counts):
            return SINGLE(float(sum(counts[i, j] for j in group.members)) / group.count)

        group.queue, group.waited = per_lane(seen.queue_veh), float(per_lane(seen.waiting_veh))
        sees = self.options["approaching"]
        group.expected = per_lane(seen.approaching_veh) if sees else SINGLE(0)
        group.moving = group.expected
        shown = group.node.phases[seen.phase[i]] if seen.phase[i] >= 0 else frozenset()
        group.shown, group.shown_phase = self.coverage(group, shown), shown
        group.stops = self.moves.all_stop[i]
        if self.asked is None:
            return
        joined = self.joined(i, group, seen)
        if self.options["recall"]:
            joined = self.fill_in(i, group, seen, joined)
        if self.fills and group.link not in self.fed:
            joined = self.count_outside(i, group, seen, joined)
        if joined is not None:
            group.rated += 1
            step = max(SINGLE(self.options["rate_step"]), SINGLE(1) / SINGLE(1 + group.rated))
            group.rate += step * (joined - group.rate)

    def discharged(self, treated):
        part = {RED: 0.0, KEPT: 1.0, SWITCHED: self.after_switch, PARTLY: self.after_switch / 2}
        return SINGLE(part[treated]) * SINGLE(self.flow_veh)

    def joined(self, i, group, seen):
        """Return who joined in the interval that ended, None if one cannot tell."""
        _, treated, before, foreseen = group.last
        # In 32 bits as the kernel: means of a few counts lie on the edges of rows.
        grown = group.queue - before
        if self.options["approaching"] and self.unseen(group.link) == 0:
            return foreseen
        if seen.phase[i] != self.asked[i]:
            return None
        if treated == RED:
            return max(SINGLE(0), grown)
        if treated != PARTLY and group.queue > 0:
            return max(SINGLE(0), grown + self.discharged(treated))
        return None

    def fill_in(self, i, group, seen, joined):
        """Count from memory where a detector fell silent; return who joined, None if unknown."""
        treated = group.last[1] if seen.phase[i] == self.asked[i] else PARTLY
        queue = group.silence.listen(group, treated, self.discharged(treated))
        if queue is None:
            return joined
        group.queue = queue
        return None

    def count_outside(self, i, group, seen, joined):
        """Add who waits unseen behind a full entry; return who joined, then."""
        _, treated, queue, _ = group.last
        treated = treated if seen.phase[i] == self.asked[i] else PARTLY
        before = group.outside
        full = group.queue + group.moving >= SINGLE(FULL * self.room_veh[group.link])
        if full or before > 0:
            joined = max(SINGLE(0), group.queue - (queue - before) + self.discharged(treated))
        waiting = max(SINGLE(0), before + group.rate - joined) if full else SINGLE(0)
        group.outside = min(waiting, MOST_OUTSIDE)
        group.queue += group.outside
        group.waited += float(before + group.outside) / 2
        return joined

    def coverage(self, group, phase):
        """Return whether a phase serves all of a group, some of it or none."""
        served = phase.intersection(group.members)
        return RED if not served else KEPT if len(served) == len(group.members) else PARTLY

    def treatment(self, group, phase):
        covers = self.coverage(group, phase)
        kept = group.shown == KEPT and (phase == group.shown_phase or not group.stops)
        return SWITCHED if covers == KEPT and not kept and self.after_switch < 1 else covers

    def row(self, group):
        queue = int(float(group.queue) + 0.5)
        queue = sum(queue >= least for least in QUEUE_BINS) - 1
        arrivals = min(3, int(float(group.expected) + 0.5))
        rate = sum(group.rate > edge for edge in RATE_EDGES) if self.options["rates"] else 0
        return 24 * queue + 6 * arrivals + rate

    def part(self, i, group, phase):
        """Return what part of a group's vehicles a phase is worth to."""
        treatment = self.treatment(group, phase)
        if treatment in (KEPT, SWITCHED) and i in self.moves.apart:
            served, green = self.treat(i, group, phase)
            return served * green
        part = {RED: 0, KEPT: 1, SWITCHED: self.after_switch, PARTLY: self.after_switch / 2}
        return part[treatment]

    def before(self, i):
        shown = self.seen.phase[i]
        return self.network.intersections[i].phases[shown] if shown >= 0 else None

    def treat(self, i, group, phase):
        vehicles = self.moves.vehicles(i, self.seen, self.groups)
        return self.moves.treat(i, group, phase, self.before(i), vehicles)

    def entry(self, row, treatment):
        return self.table.get((row, treatment), (SINGLE(0), 0))

    def advantage(self, group, treatment, part):
        green, red = (self.entry(self.row(group), each) for each in (treatment, RED))
        learned = float(green[0]) - float(red[0])
        prior = self.options["vehicle"] * part * group.waiting
        most = self.options["trust"] * prior + self.options["trust_veh"]
        return prior + max(-most, min(most, learned))

    def choose(self, shown, green):
        phases = []
        for i, node in enumerate(self.network.intersections):
            best, highest = 0, -math.inf
            for p, phase in enumerate(node.phases):
                tie = max(TIE, TIE_PART * highest)
                merit = self.merit(i, node, phase, green) + 2 * tie * (p == shown[i])
                merit += self.options["vehicle"] * self.owed(i, phase)
                if merit > highest + tie:
                    best, highest = p, merit
            phases.append(best)
        return np.array(phases)

    def owed(self, i, phase):
        guarded = self.options.get("guard", True)
        return sum(self.guard.owed.get((i, j), 0.0) for j in phase) if guarded else 0.0

    def merit(self, i, node, phase, green):
        vehicles = self.moves.vehicles(i, self.seen, self.groups)
        owed = self.moves.owed_in(i, phase, self.before(i), vehicles)
        total = self.options["vehicle"] * owed
        for group in self.groups[node.id]:
            if phase.intersection(group.members):
                treatment = self.treatment(group, phase)
                gain = self.advantage(group, treatment, self.part(i, group, phase))
                if group.waiting > 0:
                    ahead = [self.ahead(node.movements[j].to_link) for j in group.members]
                    wave = sum(self.waved(link) * green.get(link, 0) for link in ahead if link)
                    if i in self.moves.apart and treatment != PARTLY:
                        wave *= self.treat(i, group, phase)[0]
                    gain += self.options["vehicle"] * self.options["wave"] * wave / len(ahead)
                total += group.count * gain
        return total

    def announced_green(self, phases):
        """Return for every link which part of the groups at its end will have green."""
        green = {}
        for node, phase in zip(self.network.intersections, phases, strict=True):
            for link in {group.link for group in self.groups[node.id]}:
                parts = [
                    {RED: 0.0, KEPT: 1.0, PARTLY: 0.5}[self.coverage(group, node.phases[phase])]
                    for group in self.on_link(link)
                ]
                green[link] = sum(parts) / len(parts)
        return green

    def announced_inflow(self, phases, seen):
        """Return for every link who will get onto it early enough to reach its end."""
        inflow = {}
        for i, node in enumerate(self.network.intersections):
            for j in node.phases[phases[i]] | node.unsignalled:
                link, lanes = self.ahead(node.movements[j].to_link), node.movements[j].lanes
                if link:
                    others = [
                        m for m in node.movements if m.from_link == node.movements[j].from_link
                    ]
                    own = sum(1 / sum(lane in m.lanes for m in others) for lane in lanes)
                    ready = int(seen.queue_veh[i, j])
                    ready += int(seen.approaching_veh[i, j]) * self.options["approaching"]
                    goes = min(float(ready), self.flow_veh * own * self.unseen(link))
                    inflow[link] = inflow.get(link, 0.0) + goes
        return inflow

    def learn(self, phases, seen):
        for i, node in enumerate(self.network.intersections):
            overruled = self.asked is None or seen.phase[i] != self.asked[i]
            for group in self.groups[node.id]:
                row = self.row(group)
                treatment = self.treatment(group, node.phases[phases[i]])
                part = self.part(i, group, node.phases[phases[i]])
                if not overruled and self.learns_from(group):
                    before_row, before_treatment, queue, expected = group.last
                    waiting = float(queue + expected)
                    before = self.value(before_row, before_treatment, waiting, group.part)
                    after = self.value(row, treatment, group.waiting, part)
                    error = self.options["discount"] * after - group.waited - before
                    self.correct(before_row, before_treatment, error)
                group.last = row, treatment, group.queue, group.expected
                group.part = part
        self.remember(phases)

    def learns_from(self, group):
        """Tell whether what a group counted teaches anything."""
        return self.options["learning"] and group.last[2] <= 20 and not group.silence.dead

    def remember(self, phases):
        vehicles = {i: self.moves.vehicles(i, self.seen, self.groups) for i in self.moves.apart}
        self.moves.remember(phases, self.seen.phase, vehicles)

    def value(self, row, treatment, waiting, part):
        left = self.options["vehicle"] * (part - 1) * waiting
        return left + float(self.entry(row, treatment)[0])

    def correct(self, row, treatment, error):
        residual, times = self.entry(row, treatment)
        step = max(0.01, 0.1 / (1 + min(times, 255) / 5) ** 0.6)
        self.table[row, treatment] = residual + SINGLE(step * error), times + 1
