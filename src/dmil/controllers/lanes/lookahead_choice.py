"""Look-ahead over a learned model of lanes, compiled: all intersections at once."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dmil.arrays import ByteArray, IntArray, Single
from dmil.compilation import kernel
from dmil.controllers.lanes.lane_groups import LaneGroups
from dmil.controllers.lanes.lane_inputs import (
    KEPT,
    PARTLY,
    RED,
    Inputs,
    LaneScratch,
    ShortTerm,
    aggregate,
    announce,
    count_arrivals,
    expect_announced,
    expect_by_rate,
    find_waves,
    forget_rejected,
    note_shown,
    note_treatment,
    served_wholly,
    state_bin,
)
from dmil.memory.residuals import (
    ResidualTable,
    believed,
    count_outcome,
    has_numbers_only,
    learn_outcome,
)

COST, NEXT = range(2)
"""Outcomes of an interval: mean vehicles waiting in it, vehicles queued at its end."""
OUTCOMES = 2
UNSERVED, WHOLLY, IN_PART = range(3)
"""What a phase does to a group; with what was before it makes a treatment."""
NOT_LEARNED_FROM_VEH = 20.0
"""Longest queue that is learned from: beyond, the lane model needs no help."""
SAME = 1e-4
"""Costs that differ by less are the same: queues and arrivals are 32-bit numbers."""


class LookaheadParams(NamedTuple):
    """Numbers for the kernel: see `LookaheadSettings`, and `LaneMemory` for ``after_switch``.

    ``plan`` is 0 where it looks one decision ahead only.
    """

    discount: float
    terminal: float
    curvature: float
    plan: float
    rounds: int
    expected: float
    later: float
    wave: float
    trust: float
    queue_trust: float
    rate_step: float
    after_switch: float
    approaching: bool
    learning: bool


class Plans(NamedTuple):
    """Working space of the look-ahead.

    Attributes
    ----------
    cost: (groups, effects, effects) float64
        Predicted cost of a group for what the phases of this and the next decision do to it; there
        are three effects where phases serve groups in part, else two.
    effect: (groups,) uint8
        What the phase that is looked at does.
    known_veh: (groups,) float32
        Expected vehicles without those that are announced.
    """

    cost: npt.NDArray[np.float64]
    effect: ByteArray
    known_veh: Single


@kernel
def decide(
    groups: LaneGroups,
    params: LookaheadParams,
    table: ResidualTable,
    short: ShortTerm,
    inputs: Inputs,
    scratch: LaneScratch,
    plans: Plans,
    phases: IntArray,
) -> bool:
    """Choose all phases and learn from the last choice.

    Every intersection chooses by what it sees and announces that; then, knowing what its neighbours
    mean to do, it chooses again, some rounds long.

    See `LaneWork` for what it takes and returns; table and short-term memory are changed in place.
    """
    note_shown(groups, inputs, scratch)
    aggregate(groups, params.approaching, inputs, scratch)
    if not inputs.first:
        forget_rejected(groups, inputs, short)
        count_arrivals(
            groups, params.approaching, params.after_switch, params.rate_step, short, scratch
        )
    expect_by_rate(groups, params.expected, short, scratch)
    for g in range(groups.lanes.shape[0]):
        plans.known_veh[g] = scratch.expected_veh[g]
        scratch.wave[g] = 0.0
    _predict(groups, params, table, short, scratch, plans)
    _choose(groups, params.terminal, inputs, plans, phases)
    for _ in range(params.rounds):
        announce(groups, params.approaching, inputs, scratch, phases)
        for g in range(groups.lanes.shape[0]):
            scratch.expected_veh[g] = plans.known_veh[g]
        expect_announced(groups, params.expected, short, scratch)
        find_waves(groups, params.wave, scratch)
        _predict(groups, params, table, short, scratch, plans)
        _choose(groups, params.terminal, inputs, plans, phases)
    note_treatment(groups, params.after_switch, scratch, phases)
    _learn(groups, params, table, short, inputs, scratch)
    return has_numbers_only(table)


@kernel
def lane_model(
    queue_veh: float, arrivals_veh: float, flow_veh: float, treatment: int, after_switch: float
) -> tuple[float, float]:
    """Return mean vehicles waiting in an interval and vehicles queued at its end (ours).

    A fluid: arrivals come evenly, a queue leaves evenly while there is green. Clearance comes
    first; a lane that is served in part moves at half its flow.

    Parameters
    ----------
    queue_veh, arrivals_veh: float
        At the beginning and in the interval, per lane.
    flow_veh: float
        Vehicles that the lane discharges in an interval of green.
    treatment, after_switch
        How it is treated; part of an interval that is green after a switch.
    """
    if treatment == RED:
        return queue_veh + 0.5 * arrivals_veh, queue_veh + arrivals_veh
    green = 1.0 if treatment == KEPT else after_switch
    if treatment == PARTLY:
        flow_veh = 0.5 * flow_veh
    red = 1.0 - green
    longest_veh = queue_veh + arrivals_veh * red
    cost = red * 0.5 * (queue_veh + longest_veh)
    shrinks_veh = flow_veh - arrivals_veh
    end_veh = longest_veh - shrinks_veh * green
    if end_veh >= 0.0:
        return cost + green * 0.5 * (longest_veh + end_veh), end_veh
    return cost + 0.5 * longest_veh * longest_veh / shrinks_veh, 0.0


@kernel
def _foresee(
    params: LookaheadParams,
    table: ResidualTable,
    queue_veh: float,
    arrivals_veh: float,
    flow_veh: float,
    treatment: int,
) -> tuple[float, float]:
    """Return what the lane model says and what was learned beyond it."""
    cost, end_veh = lane_model(queue_veh, arrivals_veh, flow_veh, treatment, params.after_switch)
    row = int(state_bin(queue_veh, arrivals_veh))
    cost += believed(table, row, treatment, COST, params.trust)
    end_veh += params.queue_trust * believed(table, row, treatment, NEXT, params.trust)
    return max(cost, 0.0), max(end_veh, 0.0)


@kernel
def _predict(
    groups: LaneGroups,
    params: LookaheadParams,
    table: ResidualTable,
    short: ShortTerm,
    scratch: LaneScratch,
    plans: Plans,
) -> None:
    """Predict the cost of every group for whatever this and the next phase do to it."""
    effects, after_switch = plans.cost.shape[1], params.after_switch
    for g in range(groups.lanes.shape[0]):
        flow_veh = groups.lane_veh[g]
        later_veh = params.later * float(short.rate_veh[g])
        for now in range(effects):
            treatment = _treatment(now, scratch.shown[g], after_switch)
            cost, end_veh = _foresee(
                params,
                table,
                float(scratch.queue_veh[g]),
                float(scratch.expected_veh[g]),
                flow_veh,
                treatment,
            )
            if now != UNSERVED:
                cost -= float(scratch.wave[g])
            stays = _left(params, end_veh)
            for then in range(effects):
                goes = stays
                if params.plan > 0.0:
                    treatment = _treatment(then, KEPT if now == WHOLLY else RED, after_switch)
                    next_cost, last_veh = _foresee(
                        params, table, end_veh, later_veh, flow_veh, treatment
                    )
                    goes = next_cost + params.discount * _left(params, last_veh)
                # The next decision may be another one, so its plan counts in part.
                ahead = (1.0 - params.plan) * stays + params.plan * goes
                plans.cost[g, now, then] = groups.lanes[g] * (cost + params.discount * ahead)


@kernel
def _treatment(effect: int, before: int, after_switch: float) -> int:
    """Return how a group is treated by a phase, given how it was treated before."""
    if effect == UNSERVED:
        return RED
    return PARTLY if effect == IN_PART else served_wholly(before, after_switch)


@kernel
def _left(params: LookaheadParams, queue_veh: float) -> float:
    """Return what a queue costs that is left: more than in proportion to its length."""
    return (params.terminal + params.curvature * queue_veh) * queue_veh


@kernel
def _choose(
    groups: LaneGroups, vehicle: float, inputs: Inputs, plans: Plans, phases: IntArray
) -> None:
    """Choose for every intersection the first phase of the pair with the least cost."""
    cost, effect = plans.cost, plans.effect
    for i in range(phases.shape[0]):
        first, last = groups.phase_offset[i], groups.phase_offset[i + 1]
        best, lowest = 0, np.inf
        for now in range(first, last):
            unserved = 0.0
            for g in range(groups.group_offset[i], groups.group_offset[i + 1]):
                effect[g] = UNSERVED
            for place in range(groups.served_offset[now], groups.served_offset[now + 1]):
                effect[groups.served[place]] = IN_PART if groups.partly[place] else WHOLLY
            for g in range(groups.group_offset[i], groups.group_offset[i + 1]):
                unserved += cost[g, effect[g], UNSERVED]
            if inputs.owed_veh.shape[0] > 0:
                for place in range(groups.flow_offset[now], groups.flow_offset[now + 1]):
                    unserved -= vehicle * inputs.owed_veh[groups.flows[place]]
            least = np.inf
            for then in range(first, last):
                saved = 0.0
                for place in range(groups.served_offset[then], groups.served_offset[then + 1]):
                    g = groups.served[place]
                    served = IN_PART if groups.partly[place] else WHOLLY
                    saved += cost[g, effect[g], UNSERVED] - cost[g, effect[g], served]
                least = min(least, unserved - saved)
            # Of equally good phases the one shown stays.
            shown = now - first == inputs.shown[i]
            if least < lowest - SAME or (shown and least < lowest + SAME):
                best, lowest = now - first, least
        phases[i] = best


@kernel
def _learn(
    groups: LaneGroups,
    params: LookaheadParams,
    table: ResidualTable,
    short: ShortTerm,
    inputs: Inputs,
    scratch: LaneScratch,
) -> None:
    """Learn what the lane model missed in the interval that ended; keep what was foreseen now."""
    known = 0
    for i in range(inputs.shown.shape[0]):
        # A rejected request was not executed: nothing is learned of it.
        learns = params.learning and not inputs.first and inputs.shown[i] == inputs.asked[i]
        for g in range(groups.group_offset[i], groups.group_offset[i + 1]):
            queue_veh, arrivals_veh = float(short.queue_veh[g]), float(short.expected_veh[g])
            if learns and queue_veh <= NOT_LEARNED_FROM_VEH:
                row, treated = short.row[g], short.treatment[g]
                cost, end_veh = lane_model(
                    queue_veh, arrivals_veh, groups.lane_veh[g], treated, params.after_switch
                )
                learn_outcome(table, row, treated, COST, scratch.waiting_veh[g] - cost)
                learn_outcome(table, row, treated, NEXT, scratch.queue_veh[g] - end_veh)
                count_outcome(table, row, treated)
            short.queue_veh[g] = scratch.queue_veh[g]
            short.expected_veh[g] = scratch.expected_veh[g]
            short.row[g] = state_bin(float(scratch.queue_veh[g]), float(scratch.expected_veh[g]))
            short.treatment[g] = scratch.treatment[g]
            known += table.times[short.row[g], short.treatment[g]] > 0
    scratch.lookups[0] += known
    scratch.lookups[1] += groups.lanes.shape[0] - known
