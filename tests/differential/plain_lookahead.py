"""Model memory in plain Python: all pairs of phases tried, one lane group at a time."""

from functools import cache

import numpy as np

from tests.differential.plain_factored import (
    KEPT,
    PARTLY,
    QUEUE_BINS,
    RED,
    SINGLE,
    SWITCHED,
    PlainFactored,
)

SAME = 1e-4
DEFAULTS = {
    "depth": 2,
    "plan": 0.7,
    "terminal": 2.0,
    "curvature": 0.2,
    "discount": 0.9,
    "approaching": True,
    "expected": 0.3,
    "later": 0.5,
    "rounds": 3,
    "wave": 1.0,
    "learning": True,
    "trust": 5.0,
    "queue_trust": 0.3,
    "rate_step": 0.02,
    "yields": False,
    "age": 0.0,
    "waves": "everywhere",
    "outside": False,
    "recall": False,
    "censored": False,
}


class PlainLookahead(PlainFactored):
    """The whole decision; `table` maps (row, treatment) to two residuals and how often learned."""

    def __init__(self, options=None):
        self.options = {**DEFAULTS, **(options or {})}
        self.table = {}

    def decide(self, seen):
        self.look_at_all(seen)
        for group in self.all_groups():
            if group.link not in self.fed:
                more = self.options["expected"] * self.unseen(group.link) * float(group.rate)
                group.expected += SINGLE(more)
            group.known = group.expected
        phases = self.choose(seen.phase, {})
        for _ in range(self.options["rounds"]):
            inflow = self.announced_inflow(phases, seen)
            for group in self.all_groups():
                share = self.arriving(group) / sum(
                    self.arriving(other) for other in self.on_link(group.link)
                )
                more = self.options["expected"] * inflow.get(group.link, 0.0) * share
                group.expected = group.known + SINGLE(more / group.count)
            phases = self.choose(seen.phase, self.announced_green(phases))
        self.learn(phases, seen)
        self.asked = phases
        return phases

    def choose(self, shown, green):
        phases, self.costs = [], {}
        for i, node in enumerate(self.network.intersections):
            costs = [
                self.least_cost(i, node, now, green) - self.options["terminal"] * self.owed(i, now)
                for now in node.phases
            ]
            best = [p for p, cost in enumerate(costs) if cost < min(costs) + SAME]
            phases.append(shown[i] if shown[i] in best else best[0])
        return np.array(phases)

    def least_cost(self, i, node, now, green):
        vehicles = self.moves.vehicles(i, self.seen, self.groups)
        owed = self.moves.owed_in(i, now, self.before(i), vehicles)
        if i in self.moves.apart:
            cost = self.least_cost_apart(i, node, now, green)
        else:
            cost = min(self.pair_cost(node, now, then, green) for then in node.phases)
        return cost - self.options["terminal"] * owed

    def least_cost_apart(self, i, node, now, green):
        """Return the least cost of a pair of phases where movements are told apart."""
        o, vehicles = self.options, self.moves.vehicles(i, self.seen, self.groups)
        plan = o["plan"] if o["depth"] == 2 else 0.0
        going = self.moves.going(i, now, self.before(i), vehicles)
        cost, following, ends = 0.0, dict(vehicles), {}
        for group in self.groups[node.id]:
            treatment = self.treatment(group, now)
            served, c = self.treat(i, group, now)
            waits, end = self.foresee(
                float(group.queue), float(group.expected), treatment, served * c
            )
            if treatment != RED:
                waits -= (1 if treatment == PARTLY else served) * self.wave(group, green)
            cost += group.count * (waits + o["discount"] * (1 - plan) * self.left(end))
            held = sum(vehicles[j] for j in group.members if not going[j])
            weight = {j: vehicles[j] * (1.5 - going[j]) + 0.05 for j in group.members if going[j]}
            left = max(0.0, end * group.count - held)
            comes = o["later"] * float(group.rate) * group.count
            share = self.moves.shares(i, group)
            ends[group] = end
            for j in group.members:
                stays = left * weight[j] / sum(weight.values()) if j in weight else vehicles[j]
                following[j] = stays + comes * share[j]
        if plan == 0:
            return cost
        then = min(self.cost_then(i, node, now, then, following, ends) for then in node.phases)
        return cost + o["discount"] * plan * then

    def cost_then(self, i, node, now, then, vehicles, ends):
        total = 0.0
        for group in self.groups[node.id]:
            before, covers = self.treatment(group, now), self.coverage(group, then)
            kept = before in (KEPT, SWITCHED) and (now == then or not group.stops)
            switches = covers == KEPT and not kept and self.after_switch < 1
            served, green = self.moves.treat(i, group, then, now, vehicles)
            arrivals = self.options["later"] * float(group.rate)
            treatment = SWITCHED if switches else covers
            waits, last = self.foresee(ends[group], arrivals, treatment, served * green)
            total += group.count * (waits + self.options["discount"] * self.left(last))
        return total

    def wave(self, group, green):
        if group.waiting == 0:
            return 0.0
        ahead = [self.ahead(group.node.movements[j].to_link) for j in group.members]
        found = sum(self.waved(link) * green.get(link, 0) for link in ahead if link)
        return self.options["wave"] * found / len(ahead)

    def pair_cost(self, node, now, then, green):
        total = 0.0
        for group in self.groups[node.id]:
            case = group, self.coverage(group, now), self.coverage(group, then)
            if case not in self.costs:
                self.costs[case] = group.count * self.cost(group, now, then, green)
            total += self.costs[case]
        return total

    def cost(self, group, now, then, green):
        o, covered = self.options, self.coverage(group, now)
        cost, queue = self.foresee(
            float(group.queue), float(group.expected), self.treatment(group, now)
        )
        if covered != RED:
            cost -= self.wave(group, green)
        stays = self.left(queue)
        if o["depth"] == 1:
            return cost + o["discount"] * stays
        treatment = self.coverage(group, then)
        if treatment == KEPT and covered != KEPT and self.after_switch < 1:
            treatment = SWITCHED
        next_cost, last = self.foresee(queue, o["later"] * float(group.rate), treatment)
        goes = next_cost + o["discount"] * self.left(last)
        return cost + o["discount"] * ((1 - o["plan"]) * stays + o["plan"] * goes)

    def left(self, queue):
        return self.options["terminal"] * queue + self.options["curvature"] * queue**2

    def foresee(self, queue, arrivals, treatment, part=None):
        cost, end = self.lane_model(queue, arrivals, treatment, part)
        residuals = self.table.get((self.bins(queue, arrivals), treatment))
        if residuals:
            times = residuals[2]
            trusted = times / (times + self.options["trust"])
            cost += trusted * float(residuals[0])
            end += self.options["queue_trust"] * trusted * float(residuals[1])
        return max(0.0, cost), max(0.0, end)

    def lane_model(self, queue, arrivals, treatment, part=None):
        if part is None or treatment in (RED, PARTLY):
            return fluid(queue, arrivals, self.flow_veh, treatment, self.after_switch)
        return fluid(queue, arrivals, self.flow_veh, SWITCHED, part)

    def bins(self, queue, arrivals):
        place = sum(int(queue + 0.5) >= least for least in QUEUE_BINS) - 1
        return 4 * place + min(3, int(arrivals + 0.5))

    def learn(self, phases, seen):
        for i, node in enumerate(self.network.intersections):
            overruled = self.asked is None or seen.phase[i] != self.asked[i]
            for group in self.groups[node.id]:
                if not overruled and self.learns_from(group):
                    self.learn_group(i, group)
                treatment = self.treatment(group, node.phases[phases[i]])
                row = self.bins(float(group.queue), float(group.expected))
                group.last = row, treatment, group.queue, group.expected
                served, green = self.treat(i, group, node.phases[phases[i]])
                group.part = served * green
        self.remember(phases)

    def learn_group(self, i, group):
        _, treatment, queue, expected = group.last
        queue, expected = float(queue), float(expected)
        part = group.part if i in self.moves.apart else None
        model = self.lane_model(queue, expected, treatment, part)
        least, more = (group.waited, float(group.queue)), (0.0, 0.0)
        if self.options["censored"]:
            more = ((expected + float(group.moving)) / 2, float(group.moving))
        errors = [
            min(max(each, low), low + most) - each
            for each, low, most in zip(model, least, more, strict=True)
        ]
        self.correct(self.bins(queue, expected), treatment, errors)

    def correct(self, row, treatment, errors):
        *residuals, times = self.table.get((row, treatment), (SINGLE(0), SINGLE(0), 0))
        step = max(0.005, 1 / (1 + times))
        learned = [
            SINGLE(float(past) + step * (error - float(past)))
            for past, error in zip(residuals, errors, strict=True)
        ]
        self.table[row, treatment] = (*learned, times + 1)


@cache
def fluid(queue, arrivals, flow, treatment, after_switch):
    """Return mean and last queue of a lane: waits out what is red, then leaves evenly."""
    green = {RED: 0.0, KEPT: 1.0, SWITCHED: after_switch, PARTLY: after_switch}[treatment]
    flow = flow / 2 if treatment == PARTLY else flow
    peak = queue + arrivals * (1 - green)
    mean = (1 - green) * (queue + peak) / 2
    if green == 0:
        return mean, peak
    last = peak - (flow - arrivals) * green
    if last >= 0:
        return mean + green * (peak + last) / 2, last
    empty_after = peak / (flow - arrivals)
    return mean + empty_after * peak / 2, 0.0
