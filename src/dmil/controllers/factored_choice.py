"""The factored memory's decision, compiled: all intersections at once."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from dmil.compilation import kernel
from dmil.controllers.lane_groups import NOWHERE, LaneGroups
from dmil.controllers.lane_sight import (
    announce,
    count_arrivals,
    expect_announced,
    expect_by_rate,
    forget_overruled,
    green_part,
    look,
    note_shown,
    note_treatment,
    served_wholly,
)
from dmil.controllers.lane_state import (
    ARRIVALS,
    PARTLY,
    QUEUE_BIN,
    QUEUES,
    RED,
    IntArray,
    Scratch,
    Seen,
    ShortTerm,
    Single,
)
from dmil.memory.factored import FactoredTable, learn_part, surely

RATE_EDGES_VEH = (0.15, 0.4, 0.8, 1.5, 3.0)
"""Arrival rates between these have a row of their own."""
RATES = len(RATE_EDGES_VEH) + 1
ROWS = QUEUES * ARRIVALS * RATES
NOT_LEARNED_FROM_VEH = 20.0
"""Longest queue that is learned from: beyond, the prior's line goes on with the last residual."""
TIE = 1e-5
"""Sums of 32-bit numbers that ought to be equal differ by less."""


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


@kernel
def decide(
    groups: LaneGroups,
    weights: Weights,
    table: FactoredTable,
    short: ShortTerm,
    seen: Seen,
    scratch: Scratch,
    sure: Single,
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
    sure: (rows, columns) float32
        Filled with what is sure of what was learned: how much more a treatment is than red.
    phases: (intersections,) int32
        Filled with the choice.
    """
    for row in range(sure.shape[0]):
        for treatment in range(1, sure.shape[1]):
            sure[row, treatment] = surely(table, row, treatment, RED, weights.evidence)
    note_shown(groups, seen, scratch)
    look(groups, weights.use_approaching, seen, scratch)
    if not seen.first:
        forget_overruled(groups, seen, short)
        count_arrivals(
            groups, weights.use_approaching, weights.after_switch, weights.rate_step, short, scratch
        )
    expect_by_rate(groups, weights.expected, short, scratch)
    _weigh(groups, weights, short, scratch, sure)
    _choose(groups, weights, seen, scratch, sure, phases)
    if weights.expected > 0.0 or weights.wave > 0.0:
        announce(groups, weights.use_approaching, seen, scratch, phases)
        expect_announced(groups, weights.expected, short, scratch)
        _weigh(groups, weights, short, scratch, sure)
        _add_wave(groups, weights, scratch)
        _choose(groups, weights, seen, scratch, sure, phases)
    note_treatment(groups, weights.after_switch, scratch, phases)
    _learn(groups, weights, table, short, seen, scratch)


@kernel
def _weigh(
    groups: LaneGroups, weights: Weights, short: ShortTerm, scratch: Scratch, sure: Single
) -> None:
    """Find the rows of all groups, and what each gains from green."""
    for g in range(groups.lanes.shape[0]):
        queue_veh, expected_veh = scratch.queue_veh[g], scratch.expected_veh[g]
        row = _row(queue_veh, expected_veh, short.rate_veh[g] if weights.use_rates else 0.0)
        treatment = served_wholly(scratch.shown[g], weights.after_switch)
        scratch.row[g] = row
        scratch.wave[g] = 0.0
        scratch.gain[g] = groups.lanes[g] * _advantage(
            weights, queue_veh + expected_veh, sure[row, treatment], treatment
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
def _advantage(weights: Weights, waiting_veh: float, learned: float, treatment: int) -> float:
    """Return what green gains over red on a lane, no further from the prior than is trusted."""
    part = green_part(treatment, weights.after_switch)
    believed = weights.vehicle * waiting_veh * part
    most = weights.trust * believed + weights.trust_veh
    return believed + min(max(learned, -most), most)


@kernel
def _choose(
    groups: LaneGroups,
    weights: Weights,
    seen: Seen,
    scratch: Scratch,
    sure: Single,
    phases: IntArray,
) -> None:
    """Choose for every intersection the phase with the highest sum of gains."""
    for i in range(phases.shape[0]):
        shown, best, highest = seen.shown[i], 0, -np.inf
        first = groups.phase_offset[i]
        for phase in range(first, groups.phase_offset[i + 1]):
            # Of equally good phases the one shown stays, else the first is taken.
            total = 2.0 * TIE if phase - first == shown else 0.0
            for place in range(groups.served_offset[phase], groups.served_offset[phase + 1]):
                g = groups.served[place]
                gain = float(scratch.gain[g])
                if groups.partly[place]:
                    waiting_veh = scratch.queue_veh[g] + scratch.expected_veh[g]
                    learned = sure[scratch.row[g], PARTLY]
                    gain = groups.lanes[g] * _advantage(weights, waiting_veh, learned, PARTLY)
                    gain += scratch.wave[g]
                total += gain
            if total > highest + TIE:
                best, highest = phase - first, total
        phases[i] = best


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
            scratch.wave[g] = groups.lanes[g] * worth
            scratch.gain[g] += scratch.wave[g]


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
    left = 1.0 - green_part(treatment, weights.after_switch)
    return residual - weights.vehicle * waiting_veh * left
