"""The factored memory's decision, compiled: all intersections at once."""

from __future__ import annotations

import numpy as np

from dmil.compilation import kernel
from dmil.controllers.factored_state import (
    ARRIVALS,
    KEPT,
    PARTLY,
    QUEUE_BIN,
    RATE_EDGES_VEH,
    RATES,
    RED,
    SWITCHED,
    IntArray,
    Scratch,
    Seen,
    ShortTerm,
    Weights,
)
from dmil.controllers.lane_groups import NOWHERE, LaneGroups
from dmil.memory.factored import FactoredTable, learn_part, surely

NOT_LEARNED_FROM_VEH = 20.0
"""Longest queue that is learned from: beyond, the prior's line goes on with the last residual."""
SMALLEST_RATE_VEH = 0.05
"""Added to the rate of every lane group when inflow is divided: no group gets none for ever."""
TIE = 1e-5
RATED_ENOUGH = 1000.0
"""Intervals after which the moving average forgets at its own pace, whatever the step."""


@kernel
def decide(
    groups: LaneGroups,
    weights: Weights,
    table: FactoredTable,
    short: ShortTerm,
    seen: Seen,
    scratch: Scratch,
    phases: IntArray,
) -> None:
    """Choose all phases and learn from the last choice.

    Every intersection chooses by what it sees and announces that; then, knowing what its neighbours
    mean to do, it chooses for good. Each step is a loop over all groups or intersections; what is
    inside takes numbers only, because calls that pass whole tuples of arrays cost more than work.

    Parameters
    ----------
    groups, weights, table, short, seen, scratch
        See there; table, short-term memory and scratch change in place.
    phases: (intersections,) int32
        Filled with the choice.
    """
    for row in range(scratch.sure.shape[0]):
        for treatment in range(1, scratch.sure.shape[1]):
            scratch.sure[row, treatment] = surely(table, row, treatment, RED, weights.evidence)
    _note_shown(groups, seen, scratch)
    _look(groups, weights, seen, scratch)
    if not seen.first:
        _count_arrivals(groups, weights, short, scratch)
    _expect_by_rate(groups, weights, short, scratch)
    _weigh(groups, weights, short, scratch)
    _choose(groups, weights, seen, scratch, phases)
    if weights.expected > 0.0 or weights.wave > 0.0:
        _announce(groups, seen, scratch, phases)
        _expect_announced(groups, weights, short, scratch)
        _weigh(groups, weights, short, scratch)
        _add_wave(groups, weights, scratch)
        _choose(groups, weights, seen, scratch, phases)
    _note_treatment(groups, weights, scratch, phases)
    _learn(groups, weights, table, short, seen, scratch)


@kernel
def _note_shown(groups: LaneGroups, seen: Seen, scratch: Scratch) -> None:
    """Note how the phases that are shown treat all groups."""
    shown = scratch.shown
    for g in range(shown.shape[0]):
        shown[g] = RED
    for i in range(seen.shown.shape[0]):
        if seen.shown[i] >= 0:
            phase = groups.phase_offset[i] + seen.shown[i]
            for place in range(groups.served_offset[phase], groups.served_offset[phase + 1]):
                shown[groups.served[place]] = PARTLY if groups.partly[place] else KEPT


@kernel
def _look(groups: LaneGroups, weights: Weights, seen: Seen, scratch: Scratch) -> None:
    """Add up what is seen of every group, per lane."""
    for g in range(groups.lanes.shape[0]):
        queue, approaching, waiting = 0.0, 0.0, 0.0
        for place in range(groups.slot_offset[g], groups.slot_offset[g + 1]):
            slot = groups.slots[place]
            queue += seen.queue_veh[slot]
            approaching += seen.approaching_veh[slot]
            waiting += seen.waiting_veh[slot]
        lanes = groups.lanes[g]
        scratch.queue_veh[g] = queue / lanes
        scratch.expected_veh[g] = approaching / lanes if weights.use_approaching else 0.0
        scratch.waiting_veh[g] = waiting / lanes


@kernel
def _count_arrivals(
    groups: LaneGroups, weights: Weights, short: ShortTerm, scratch: Scratch
) -> None:
    """Move arrival rates on by the interval that ended, where one can tell who joined.

    One can where all who join were seen before; on red, where nobody leaves; and on green while a
    queue lasts, which discharges at saturation flow.
    """
    for g in range(groups.lanes.shape[0]):
        treated, queue_veh = short.treatment[g], scratch.queue_veh[g]
        if weights.use_approaching and groups.unseen[groups.link[g]] == 0.0:
            joined_veh = float(short.expected_veh[g])
        elif treated == RED:
            joined_veh = max(0.0, queue_veh - short.queue_veh[g])
        elif treated != PARTLY and queue_veh > 0.0:
            left_veh = _green_part(treated, weights.after_switch) * groups.lane_veh[g]
            joined_veh = max(0.0, queue_veh - short.queue_veh[g] + left_veh)
        else:
            continue
        step = weights.rate_step
        if short.rated[g] < RATED_ENOUGH:
            short.rated[g] += np.float32(1.0)
            step = max(step, 1.0 / (1.0 + short.rated[g]))
        short.rate_veh[g] += np.float32(step * (joined_veh - short.rate_veh[g]))


@kernel
def _expect_by_rate(
    groups: LaneGroups, weights: Weights, short: ShortTerm, scratch: Scratch
) -> None:
    """Expect unseen vehicles where no intersection announces them; add up rates by link."""
    for link in range(groups.unseen.shape[0]):
        scratch.link_rate_veh[link] = 0.0
    for g in range(groups.lanes.shape[0]):
        link, rate_veh = groups.link[g], short.rate_veh[g]
        scratch.link_rate_veh[link] += np.float32(groups.lanes[g] * (rate_veh + SMALLEST_RATE_VEH))
        if not groups.is_fed[link]:
            scratch.expected_veh[g] += np.float32(weights.expected * groups.unseen[link] * rate_veh)


@kernel
def _weigh(groups: LaneGroups, weights: Weights, short: ShortTerm, scratch: Scratch) -> None:
    """Find the rows of all groups, and what each gains from green."""
    for g in range(groups.lanes.shape[0]):
        queue_veh, expected_veh = scratch.queue_veh[g], scratch.expected_veh[g]
        row = _row(queue_veh, expected_veh, short.rate_veh[g] if weights.use_rates else 0.0)
        treatment = _served(scratch.shown[g], weights.after_switch)
        scratch.row[g] = row
        scratch.gain[g] = groups.lanes[g] * _advantage(
            weights, queue_veh + expected_veh, scratch.sure[row, treatment], treatment
        )


@kernel
def _row(queue_veh: float, expected_veh: float, rate_veh: float) -> int:
    """Return the row of a lane: queue, expected arrivals, arrival rate."""
    queue = QUEUE_BIN[min(int(queue_veh + 0.5), QUEUE_BIN.size - 1)]
    arrivals = min(int(expected_veh + 0.5), ARRIVALS - 1)
    rate = 0
    for edge in RATE_EDGES_VEH:
        rate += rate_veh > edge
    return int((queue * ARRIVALS + arrivals) * RATES + rate)


@kernel
def _served(shown: int, after_switch: float) -> int:
    """Return how a group is treated by a phase that serves it wholly."""
    return KEPT if shown == KEPT or after_switch == 1.0 else SWITCHED


@kernel
def _green_part(treatment: int, after_switch: float) -> float:
    """Return the part of an interval of green that a treatment is worth by the prior."""
    if treatment == KEPT:
        return 1.0
    if treatment == RED:
        return 0.0
    return after_switch if treatment == SWITCHED else 0.5 * after_switch


@kernel
def _advantage(weights: Weights, waiting_veh: float, learned: float, treatment: int) -> float:
    """Return what green gains over red on a lane, no further from the prior than is trusted."""
    part = _green_part(treatment, weights.after_switch)
    believed = weights.vehicle * waiting_veh * part
    most = weights.trust * believed + weights.trust_veh
    return believed + min(max(learned, -most), most)


@kernel
def _choose(
    groups: LaneGroups, weights: Weights, seen: Seen, scratch: Scratch, phases: IntArray
) -> None:
    """Choose for every intersection the phase with the highest sum of gains."""
    for i in range(phases.shape[0]):
        shown, best, highest = seen.shown[i], 0, -np.inf
        first = groups.phase_offset[i]
        for phase in range(first, groups.phase_offset[i + 1]):
            # Of equally good phases the one shown stays; sums of 32-bit numbers differ by less.
            total = TIE if phase - first == shown else 0.0
            for place in range(groups.served_offset[phase], groups.served_offset[phase + 1]):
                g = groups.served[place]
                gain = float(scratch.gain[g])
                if groups.partly[place]:
                    waiting_veh = scratch.queue_veh[g] + scratch.expected_veh[g]
                    learned = scratch.sure[scratch.row[g], PARTLY]
                    gain = groups.lanes[g] * _advantage(weights, waiting_veh, learned, PARTLY)
                total += gain
            best = phase - first if total > highest else best
            highest = max(highest, total)
        phases[i] = best


@kernel
def _announce(groups: LaneGroups, seen: Seen, scratch: Scratch, phases: IntArray) -> None:
    """Note on every link how much of its end will be green and who will come in time."""
    for link in range(groups.unseen.shape[0]):
        scratch.inflow_veh[link] = 0.0
        scratch.green[link] = 0.0
    for i in range(phases.shape[0]):
        phase = groups.phase_offset[i] + phases[i]
        for place in range(groups.served_offset[phase], groups.served_offset[phase + 1]):
            link = groups.link[groups.served[place]]
            part = 0.5 if groups.partly[place] else 1.0
            scratch.green[link] += np.float32(part / groups.links_groups[link])
        for place in range(groups.flow_offset[phase], groups.flow_offset[phase + 1]):
            slot = groups.flows[place]
            link = groups.ahead[slot]
            if link != NOWHERE and groups.unseen[link] > 0.0:
                ready_veh = float(seen.queue_veh[slot] + seen.approaching_veh[slot])
                in_time_veh = groups.capacity_veh[slot] * groups.unseen[link]
                scratch.inflow_veh[link] += np.float32(min(ready_veh, in_time_veh))


@kernel
def _expect_announced(
    groups: LaneGroups, weights: Weights, short: ShortTerm, scratch: Scratch
) -> None:
    """Give every group its share of the inflow of its link, as arrivals have been so far."""
    for g in range(groups.lanes.shape[0]):
        link = groups.link[g]
        share = (short.rate_veh[g] + SMALLEST_RATE_VEH) / scratch.link_rate_veh[link]
        scratch.expected_veh[g] += np.float32(weights.expected * scratch.inflow_veh[link] * share)


@kernel
def _add_wave(groups: LaneGroups, weights: Weights, scratch: Scratch) -> None:
    """Let green count more for those who will find green ahead when they get there."""
    for g in range(groups.lanes.shape[0]):
        if scratch.queue_veh[g] + scratch.expected_veh[g] > 0.0:
            first, last = groups.slot_offset[g], groups.slot_offset[g + 1]
            green = 0.0
            for place in range(first, last):
                link = groups.ahead[groups.slots[place]]
                if link != NOWHERE:
                    green += groups.unseen[link] * scratch.green[link]
            worth = weights.vehicle * weights.wave * green / (last - first)
            scratch.gain[g] += np.float32(groups.lanes[g] * worth)


@kernel
def _note_treatment(
    groups: LaneGroups, weights: Weights, scratch: Scratch, phases: IntArray
) -> None:
    """Note how the phases that were chosen treat all groups."""
    treatment = scratch.treatment
    for g in range(treatment.shape[0]):
        treatment[g] = RED
    for i in range(phases.shape[0]):
        phase = groups.phase_offset[i] + phases[i]
        for place in range(groups.served_offset[phase], groups.served_offset[phase + 1]):
            g = groups.served[place]
            wholly = _served(scratch.shown[g], weights.after_switch)
            treatment[g] = PARTLY if groups.partly[place] else wholly


@kernel
def _learn(
    groups: LaneGroups,
    weights: Weights,
    table: FactoredTable,
    short: ShortTerm,
    seen: Seen,
    scratch: Scratch,
) -> None:
    """Learn from the interval that ended, and keep what the next one will be judged by."""
    known = 0
    for i in range(seen.shown.shape[0]):
        # Who was overruled was treated otherwise than his entry says.
        learns = weights.learns and not seen.first and seen.shown[i] == seen.asked[i]
        for g in range(groups.group_offset[i], groups.group_offset[i + 1]):
            row, treatment = scratch.row[g], scratch.treatment[g]
            known += table.times[row, treatment] > 0
            if learns and short.queue_veh[g] <= NOT_LEARNED_FROM_VEH:
                row_before, treated = short.row[g], short.treatment[g]
                waited_veh = short.queue_veh[g] + short.expected_veh[g]
                waiting_veh = scratch.queue_veh[g] + scratch.expected_veh[g]
                before = _value(weights, table.residual[row_before, treated], waited_veh, treated)
                after = _value(weights, table.residual[row, treatment], waiting_veh, treatment)
                error = weights.discount * after - scratch.waiting_veh[g] - before
                learn_part(table, row_before, treated, error)
            short.row[g] = row
            short.treatment[g] = treatment
            short.queue_veh[g] = scratch.queue_veh[g]
            short.expected_veh[g] = scratch.expected_veh[g]
    scratch.lookups[0] += known
    scratch.lookups[1] += groups.lanes.shape[0] - known


@kernel
def _value(weights: Weights, residual: float, waiting_veh: float, treatment: int) -> float:
    """Return what a lane is worth: minus who will wait by the prior, and what was learned."""
    left = 1.0 - _green_part(treatment, weights.after_switch)
    return residual - weights.vehicle * waiting_veh * left
