"""The factored memory's decision, compiled: all intersections at once."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dmil.compilation import kernel
from dmil.controllers.lane_groups import NOWHERE, LaneGroups
from dmil.memory.factored import FactoredTable, learn_part, surely

IntArray = npt.NDArray[np.int32]
ByteArray = npt.NDArray[np.int8]
FloatArray = npt.NDArray[np.float64]
Single = npt.NDArray[np.float32]

RED, KEPT, SWITCHED, PARTLY = range(4)
"""Columns of the table: how a lane is treated in a decision interval."""

QUEUES, ARRIVALS, RATES = 12, 4, 6
"""Bins of a row: {0…8, 9–10, 11–14, 15+}, {0, 1, 2, 3+}, and between the edges of RATE_EDGES."""
ROWS = QUEUES * ARRIVALS * RATES
RATE_EDGES_VEH = (0.15, 0.4, 0.8, 1.5, 3.0)
NOT_LEARNED_FROM_VEH = 20.0
"""Longest queue that is learned from: beyond, the prior's line goes on with the last residual."""
SMALLEST_RATE_VEH = 0.05
"""Added to the rate of every lane group when inflow is divided: no group gets none for ever."""
TIE = 1e-9


class Weights(NamedTuple):
    """Numbers of `FactoredSettings` and of signal timing for the kernel."""

    vehicle: float
    expected: float
    wave: float
    after_switch: float
    discount: float
    trust: float
    trust_veh: float
    evidence: float
    rate_step: float
    use_approaching: bool
    use_rates: bool
    learns: bool


class ShortTerm(NamedTuple):
    """What every intersection remembers of the last decision and of arrivals, per lane group.

    Attributes
    ----------
    rate_veh: (groups,) float32
        Arrivals per decision interval and lane, a moving average.
    rated: (groups,) float32
        How many intervals it comes from.
    queue_veh, expected_veh: (groups,) float32
        Per lane, at the last decision.
    row: (groups,) int16
        Row of the table, then.
    treatment: (groups,) int8
        How it was treated since.
    """

    rate_veh: Single
    rated: Single
    queue_veh: Single
    expected_veh: Single
    row: npt.NDArray[np.int16]
    treatment: ByteArray


class Seen(NamedTuple):
    """The observation, and what was asked for last.

    Attributes
    ----------
    queue_veh, approaching_veh: (slots,) int32
    waiting_veh: (slots,) float64
    shown, asked: (intersections,) int32
        Phase shown now; phase asked for at the last decision.
    first: bool
        Whether there was none.
    """

    queue_veh: IntArray
    approaching_veh: IntArray
    waiting_veh: FloatArray
    shown: IntArray
    asked: IntArray
    first: bool


class Scratch(NamedTuple):
    """Working space: (groups,) but where it says otherwise.

    Attributes
    ----------
    queue_veh, expected_veh, waiting_veh: float64
        Per lane.
    row: int32
    shown, treatment: int8
        Treatment by the phase that is shown now: red, kept or partly; by the one that is chosen.
    link_rate_veh, inflow_veh, green: (links,) float64
    lookups: (2,) int64
        Entries asked for that had been learned, and that had not.
    """

    queue_veh: FloatArray
    expected_veh: FloatArray
    waiting_veh: FloatArray
    row: IntArray
    shown: ByteArray
    treatment: ByteArray
    link_rate_veh: FloatArray
    inflow_veh: FloatArray
    green: FloatArray
    lookups: npt.NDArray[np.int64]


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

    Parameters
    ----------
    groups, weights, table, short, seen, scratch
        See there; table, short-term memory and scratch change in place.
    phases: (intersections,) int32
        Filled with the choice.
    """
    _look(groups, weights, short, seen, scratch)
    for g in range(groups.lanes.shape[0]):
        scratch.row[g] = _row(weights, short, scratch, g)
    _choose(groups, weights, table, seen, scratch, False, phases)
    if weights.expected > 0.0 or weights.wave > 0.0:
        _announce(groups, short, seen, scratch, phases)
        _expect(groups, weights, short, scratch)
        _choose(groups, weights, table, seen, scratch, True, phases)
    _remember(groups, weights, table, short, seen, scratch, phases)


@kernel
def _look(
    groups: LaneGroups, weights: Weights, short: ShortTerm, seen: Seen, scratch: Scratch
) -> None:
    """Add up what is seen of every group, per lane, and keep count of who arrives."""
    for i in range(seen.shown.shape[0]):
        first, last = groups.group_offset[i], groups.group_offset[i + 1]
        for g in range(first, last):
            scratch.shown[g] = RED
        if seen.shown[i] >= 0:
            phase = groups.phase_offset[i] + seen.shown[i]
            for place in range(groups.served_offset[phase], groups.served_offset[phase + 1]):
                treated = PARTLY if groups.partly[place] else KEPT
                scratch.shown[groups.served[place]] = treated
        for g in range(first, last):
            queue, approaching, waiting = 0.0, 0.0, 0.0
            for place in range(groups.slot_offset[g], groups.slot_offset[g + 1]):
                slot = groups.slots[place]
                queue += seen.queue_veh[slot]
                approaching += seen.approaching_veh[slot]
                waiting += seen.waiting_veh[slot]
            lanes = groups.lanes[g]
            before = float(short.queue_veh[g])
            scratch.queue_veh[g] = queue / lanes
            scratch.expected_veh[g] = approaching / lanes if weights.use_approaching else 0.0
            scratch.waiting_veh[g] = waiting / lanes
            if seen.first:
                continue
            joined = -1.0
            treated = short.treatment[g]
            if weights.use_approaching and groups.unseen[groups.link[g]] == 0.0:
                joined = float(short.expected_veh[g])
            elif treated == RED:
                joined = max(0.0, queue / lanes - before)
            elif treated != PARTLY and queue > 0.0:
                share = 1.0 if treated == KEPT else weights.after_switch
                joined = max(0.0, queue / lanes - before + share * groups.lane_veh[g])
            if joined >= 0.0:
                short.rated[g] += np.float32(1.0)
                step = max(weights.rate_step, 1.0 / (1.0 + short.rated[g]))
                short.rate_veh[g] += np.float32(step * (joined - short.rate_veh[g]))
    for link in range(groups.unseen.shape[0]):
        scratch.link_rate_veh[link] = 0.0
        scratch.inflow_veh[link] = 0.0
        scratch.green[link] = 0.0
    for g in range(groups.lanes.shape[0]):
        link = groups.link[g]
        arriving = groups.lanes[g] * (short.rate_veh[g] + SMALLEST_RATE_VEH)
        scratch.link_rate_veh[link] += arriving
        if not groups.is_fed[link]:
            unseen = groups.unseen[link]
            scratch.expected_veh[g] += weights.expected * unseen * short.rate_veh[g]


@kernel
def _row(weights: Weights, short: ShortTerm, scratch: Scratch, g: int) -> int:
    """Return the row of a group: queue, expected arrivals, arrival rate."""
    queue = int(scratch.queue_veh[g] + 0.5)
    if queue > 8:
        queue = 9 if queue <= 10 else (10 if queue <= 14 else 11)
    arrivals = min(int(scratch.expected_veh[g] + 0.5), ARRIVALS - 1)
    rate = 0
    if weights.use_rates:
        for edge in RATE_EDGES_VEH:
            if short.rate_veh[g] > edge:
                rate += 1
    return (queue * ARRIVALS + arrivals) * RATES + rate


@kernel
def _gain(weights: Weights, waiting_veh: float, treatment: int) -> float:
    """Return what green gains over red by the prior, for a lane: who need not wait any more."""
    if treatment == RED:
        return 0.0
    part = 1.0 if treatment == KEPT else weights.after_switch
    if treatment == PARTLY:
        part *= 0.5
    return weights.vehicle * part * waiting_veh


@kernel
def _advantage(
    weights: Weights,
    table: FactoredTable,
    scratch: Scratch,
    g: int,
    treatment: int,
) -> float:
    """Return what green gains over red, no further from the prior than is trusted."""
    row = scratch.row[g]
    waiting = scratch.queue_veh[g] + scratch.expected_veh[g]
    believed = _gain(weights, waiting, treatment)
    learned = surely(table, row, treatment, RED, weights.evidence)
    most = weights.trust * believed + weights.trust_veh
    return believed + min(max(learned, -most), most)


@kernel
def _choose(
    groups: LaneGroups,
    weights: Weights,
    table: FactoredTable,
    seen: Seen,
    scratch: Scratch,
    announced: bool,
    phases: IntArray,
) -> None:
    """Choose for every intersection the phase with the highest sum of advantages."""
    for i in range(phases.shape[0]):
        shown = seen.shown[i]
        best, highest = 0, -np.inf
        for phase in range(groups.phase_offset[i], groups.phase_offset[i + 1]):
            total = 0.0
            for place in range(groups.served_offset[phase], groups.served_offset[phase + 1]):
                g = groups.served[place]
                treatment = _treatment(groups, weights, scratch, place)
                gain = _advantage(weights, table, scratch, g, treatment)
                if announced and scratch.queue_veh[g] + scratch.expected_veh[g] > 0.0:
                    gain += weights.vehicle * weights.wave * _green_ahead(groups, scratch, g)
                total += groups.lanes[g] * gain
            local = phase - groups.phase_offset[i]
            # Of equally good phases the one shown stays.
            if total > highest + TIE or (local == shown and total > highest - TIE):
                best, highest = local, total
        phases[i] = best


@kernel
def _green_ahead(groups: LaneGroups, scratch: Scratch, g: int) -> float:
    """Return how much of what a group leads to will be green when its vehicles get there."""
    first, last = groups.slot_offset[g], groups.slot_offset[g + 1]
    green = 0.0
    for place in range(first, last):
        link = groups.ahead[groups.slots[place]]
        if link != NOWHERE:
            green += float(groups.unseen[link] * scratch.green[link])
    return green / float(last - first)


@kernel
def _announce(
    groups: LaneGroups, short: ShortTerm, seen: Seen, scratch: Scratch, phases: IntArray
) -> None:
    """Note on every link how much of its end will be green and who will come in time."""
    for i in range(phases.shape[0]):
        phase = groups.phase_offset[i] + phases[i]
        for place in range(groups.served_offset[phase], groups.served_offset[phase + 1]):
            link = groups.link[groups.served[place]]
            scratch.green[link] += (0.5 if groups.partly[place] else 1.0) / groups.links_groups[
                link
            ]
        for place in range(groups.flow_offset[phase], groups.flow_offset[phase + 1]):
            slot = groups.flows[place]
            link = groups.ahead[slot]
            if link == NOWHERE or groups.unseen[link] == 0.0:
                continue
            ready = float(seen.queue_veh[slot] + seen.approaching_veh[slot])
            in_time = groups.capacity_veh[slot] * groups.unseen[link]
            scratch.inflow_veh[link] += min(ready, in_time)


@kernel
def _expect(groups: LaneGroups, weights: Weights, short: ShortTerm, scratch: Scratch) -> None:
    """Divide the inflow of a link among its groups, as their arrivals have been so far."""
    for g in range(groups.lanes.shape[0]):
        link = groups.link[g]
        if scratch.inflow_veh[link] > 0.0:
            share = (short.rate_veh[g] + SMALLEST_RATE_VEH) / scratch.link_rate_veh[link]
            scratch.expected_veh[g] += weights.expected * scratch.inflow_veh[link] * share
            scratch.row[g] = _row(weights, short, scratch, g)


@kernel
def _remember(
    groups: LaneGroups,
    weights: Weights,
    table: FactoredTable,
    short: ShortTerm,
    seen: Seen,
    scratch: Scratch,
    phases: IntArray,
) -> None:
    """Learn from the interval that ended, and keep what the next one will be judged by."""
    for i in range(phases.shape[0]):
        first, last = groups.group_offset[i], groups.group_offset[i + 1]
        for g in range(first, last):
            scratch.treatment[g] = RED
        phase = groups.phase_offset[i] + phases[i]
        for place in range(groups.served_offset[phase], groups.served_offset[phase + 1]):
            g = groups.served[place]
            scratch.treatment[g] = _treatment(groups, weights, scratch, place)
        # Who was overruled was treated otherwise than his entry says.
        overruled = seen.first or seen.shown[i] != seen.asked[i]
        for g in range(first, last):
            row, treatment = scratch.row[g], scratch.treatment[g]
            learned = table.times[row, treatment] > 0
            scratch.lookups[0 if learned else 1] += 1
            short_queue = short.queue_veh[g] <= NOT_LEARNED_FROM_VEH
            if weights.learns and not overruled and short_queue:
                before = _value(
                    weights,
                    table,
                    short.row[g],
                    short.treatment[g],
                    short.queue_veh[g] + short.expected_veh[g],
                )
                waiting_veh = scratch.queue_veh[g] + scratch.expected_veh[g]
                after = _value(weights, table, row, treatment, waiting_veh)
                error = weights.discount * after - scratch.waiting_veh[g] - before
                learn_part(table, short.row[g], short.treatment[g], error)
            short.row[g] = row
            short.treatment[g] = treatment
            short.queue_veh[g] = scratch.queue_veh[g]
            short.expected_veh[g] = scratch.expected_veh[g]


@kernel
def _treatment(groups: LaneGroups, weights: Weights, scratch: Scratch, place: int) -> int:
    """Return how a phase would treat a group that it serves."""
    if groups.partly[place]:
        return PARTLY
    if scratch.shown[groups.served[place]] == KEPT or weights.after_switch == 1.0:
        return KEPT
    return SWITCHED


@kernel
def _value(
    weights: Weights,
    table: FactoredTable,
    row: int,
    treatment: int,
    waiting_veh: float,
) -> float:
    """Return what a lane is worth: minus who will wait by the prior, and what was learned."""
    gain = _gain(weights, waiting_veh, treatment)
    return gain - weights.vehicle * waiting_veh + float(table.residual[row, treatment])
