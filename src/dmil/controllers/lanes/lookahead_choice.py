"""Look-ahead over a learned model of lanes, compiled: all intersections at once."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dmil.arrays import ByteArray, FloatArray, IntArray, Single
from dmil.compilation import kernel
from dmil.controllers.lanes.lane_arrivals import count_arrivals
from dmil.controllers.lanes.lane_groups import LaneGroups
from dmil.controllers.lanes.lane_inputs import (
    KEPT,
    PARTLY,
    RED,
    STATE_BINS,
    Inputs,
    LaneScratch,
    ShortTerm,
    aggregate,
    announce,
    expect_announced,
    expect_by_rate,
    find_waves,
    forget_rejected,
    green_part,
    note_shown,
    note_treatment,
    served_wholly,
    state_bin,
)
from dmil.controllers.lanes.lane_model import (
    COST,
    NEXT,
    LookaheadParams,
    lane_model,
    left,
)
from dmil.controllers.lanes.lookahead_apart import Outlook, add_up_apart, make_outlook
from dmil.controllers.lanes.lookahead_learning import learn_model
from dmil.controllers.lanes.movement_facts import Movements
from dmil.controllers.lanes.movements import (
    look_at_movements,
    note_vehicles,
    remember_treatment,
)
from dmil.memory.residuals import ResidualTable, believed, has_numbers_only

UNSERVED, WHOLLY, IN_PART = range(3)
"""What a phase does to a group; with what was before it makes a treatment."""
SAME = 1e-4
"""Costs that differ by less are the same: queues and arrivals are 32-bit numbers."""


class Plans(NamedTuple):
    """Working space of the look-ahead.

    Attributes
    ----------
    cost: (groups, effects, effects) float64
        Predicted cost of a group for what the phases of this and the next decision do to it; there
        are three effects where phases serve groups in part, else two.
    cost_more, left_more: (rows, columns) float64
        What was learned of the cost and of the vehicles left, as far as it is trusted.
    effect: (groups,) uint8
        What the phase that is looked at does.
    known_veh: (groups,) float32
        Expected vehicles without those that are announced.
    movements: Movements
        What tells movements apart.
    outlook: Outlook
        Working space where they are.
    total: (most phases, intersections) float64
        What a phase and the best one after it cost; infinity for a phase that does not exist.
    """

    cost: npt.NDArray[np.float64]
    cost_more: FloatArray
    left_more: FloatArray
    effect: ByteArray
    known_veh: Single
    movements: Movements
    outlook: Outlook
    total: FloatArray


def make_plans(groups: LaneGroups, movements: Movements, columns: int) -> Plans:
    """Return working space for a network and so many ways to treat a lane."""
    count, effects = groups.lanes.size, 3 if groups.partly.any() else 2
    _, phases, agents = groups.served_block.shape
    return Plans(
        cost=np.zeros((count, effects, effects)),
        cost_more=np.zeros((STATE_BINS, columns)),
        left_more=np.zeros((STATE_BINS, columns)),
        effect=np.zeros(count, np.uint8),
        known_veh=np.zeros(count, np.float32),
        movements=movements,
        outlook=make_outlook(groups, movements),
        total=np.full((phases, agents), np.inf),
    )


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
    look_at_movements(groups, params.age, inputs, scratch, plans.movements)
    expect_by_rate(groups, params.expected, short, scratch)
    for g in range(groups.lanes.shape[0]):
        plans.known_veh[g] = scratch.expected_veh[g]
        scratch.wave[g] = 0.0
    add_up_costs(groups, params, params, table, short, inputs, scratch, plans)
    _choose(groups, params.terminal, inputs, plans, phases)
    for _ in range(params.rounds):
        announce(groups, params.approaching, inputs, scratch, phases)
        for g in range(groups.lanes.shape[0]):
            scratch.expected_veh[g] = plans.known_veh[g]
        expect_announced(groups, params.expected, short, scratch)
        find_waves(groups, params.wave, scratch)
        add_up_costs(groups, params, params, table, short, inputs, scratch, plans)
        _choose(groups, params.terminal, inputs, plans, phases)
    note_treatment(groups, params.after_switch, inputs, scratch, phases)
    learn_model(groups, params, table, short, inputs, scratch, plans.movements)
    _remember(groups, table, short, scratch)
    if plans.movements.facts.apart.shape[0] > 0:
        remember_treatment(groups, params.after_switch, inputs, plans.movements, phases)
    return has_numbers_only(table)


@kernel
def add_up_costs(
    groups: LaneGroups,
    params: LookaheadParams,
    params_apart: LookaheadParams,
    table: ResidualTable,
    short: ShortTerm,
    inputs: Inputs,
    scratch: LaneScratch,
    plans: Plans,
) -> None:
    """Find what all phases cost by what is known and announced now.

    Where movements are told apart, ``params_apart`` holds.
    """
    _predict(groups, params, table, short, scratch, plans)
    _add_up_pairs(groups, plans)
    if plans.movements.facts.apart.shape[0] > 0:
        note_vehicles(groups, params.approaching, inputs, scratch, plans.movements)
        moves, outlook, total = plans.movements, plans.outlook, plans.total
        add_up_apart(groups, params_apart, table, short, inputs, scratch, moves, outlook, total)


@kernel
def _trust(params: LookaheadParams, table: ResidualTable, plans: Plans) -> None:
    """Prepare what was learned, as far as it is trusted."""
    for row in range(table.residual.shape[0]):
        for treatment in range(table.residual.shape[1]):
            cost = believed(table, row, treatment, COST, params.trust)
            left_veh = params.queue_trust * believed(table, row, treatment, NEXT, params.trust)
            plans.cost_more[row, treatment] = cost
            plans.left_more[row, treatment] = left_veh


@kernel
def _foresee(
    params: LookaheadParams,
    plans: Plans,
    queue_veh: float,
    arrivals_veh: float,
    flow_veh: float,
    treatment: int,
) -> tuple[float, float]:
    """Return what the lane model says and what was learned beyond it."""
    cost, end_veh = lane_model(queue_veh, arrivals_veh, flow_veh, treatment, params.after_switch)
    row = int(state_bin(queue_veh, arrivals_veh))
    more, more_left = plans.cost_more[row, treatment], plans.left_more[row, treatment]
    return max(cost + more, 0.0), max(end_veh + more_left, 0.0)


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
    _trust(params, table, plans)
    effects, after_switch = plans.cost.shape[1], params.after_switch
    for g in range(groups.lanes.shape[0]):
        queue_veh, expected_veh = float(scratch.queue_veh[g]), float(scratch.expected_veh[g])
        flow_veh = float(groups.lane_veh[g])
        later_veh = params.later * float(short.rate_veh[g])
        for now in range(effects):
            treatment = _treatment(now, scratch.shown[g], after_switch)
            cost, end_veh = _foresee(params, plans, queue_veh, expected_veh, flow_veh, treatment)
            if now != UNSERVED:
                cost -= float(scratch.wave[g])
                if params.age > 0.0:
                    # Where a phase serves groups in part, movements are told apart.
                    part = float(green_part(treatment, after_switch))
                    owed_veh = _owed(groups, plans, g)
                    cost -= params.terminal * owed_veh * part / groups.lanes[g]
            stays = left(params, end_veh)
            for then in range(effects):
                goes = stays
                if params.plan > 0.0:
                    treatment = _treatment(then, KEPT if now == WHOLLY else RED, after_switch)
                    next_cost, last_veh = _foresee(
                        params, plans, end_veh, later_veh, flow_veh, treatment
                    )
                    goes = next_cost + params.discount * left(params, last_veh)
                # The next decision may be another one, so its plan counts in part.
                ahead = (1.0 - params.plan) * stays + params.plan * goes
                plans.cost[g, now, then] = groups.lanes[g] * (cost + params.discount * ahead)


@kernel
def _owed(groups: LaneGroups, plans: Plans, g: int) -> float:
    """Return what green counts more for those of a group who waited for long."""
    owed_veh = 0.0
    for place in range(groups.movement_offset[g], groups.movement_offset[g + 1]):
        owed_veh += plans.movements.work.owed_veh[groups.movements[place]]
    return owed_veh


@kernel
def _treatment(effect: int, before: int, after_switch: float) -> int:
    """Return how a group is treated by a phase, given how it was treated before."""
    if effect == UNSERVED:
        return RED
    return PARTLY if effect == IN_PART else served_wholly(before, after_switch)


@kernel
def _add_up_pairs(groups: LaneGroups, plans: Plans) -> None:
    """Find what every phase costs with the best one after it."""
    cost, effect = plans.cost, plans.effect
    for i in range(plans.total.shape[1]):
        first, last = groups.phase_offset[i], groups.phase_offset[i + 1]
        for now in range(first, last):
            unserved = 0.0
            for g in range(groups.group_offset[i], groups.group_offset[i + 1]):
                effect[g] = UNSERVED
            for place in range(groups.served_offset[now], groups.served_offset[now + 1]):
                effect[groups.served[place]] = IN_PART if groups.partly[place] else WHOLLY
            for g in range(groups.group_offset[i], groups.group_offset[i + 1]):
                unserved += cost[g, effect[g], UNSERVED]
            least = np.inf
            for then in range(first, last):
                saved = 0.0
                for place in range(groups.served_offset[then], groups.served_offset[then + 1]):
                    g = groups.served[place]
                    served = IN_PART if groups.partly[place] else WHOLLY
                    saved += cost[g, effect[g], UNSERVED] - cost[g, effect[g], served]
                least = min(least, unserved - saved)
            plans.total[now - first, i] = least


@kernel
def _choose(
    groups: LaneGroups, vehicle: float, inputs: Inputs, plans: Plans, phases: IntArray
) -> None:
    """Choose for every intersection the phase that costs least with the best one after it."""
    for i in range(phases.shape[0]):
        first = groups.phase_offset[i]
        best, lowest = 0, np.inf
        for now in range(groups.phase_offset[i + 1] - first):
            cost = plans.total[now, i]
            if inputs.owed_veh.shape[0] > 0:
                begin, end = groups.flow_offset[first + now : first + now + 2]
                for place in range(begin, end):
                    cost -= vehicle * inputs.owed_veh[groups.flows[place]]
            # Of equally good phases the one shown stays.
            shown = now == inputs.shown[i]
            if cost < lowest - SAME or (shown and cost < lowest + SAME):
                best, lowest = now, cost
        phases[i] = best


@kernel
def _remember(
    groups: LaneGroups,
    table: ResidualTable,
    short: ShortTerm,
    scratch: LaneScratch,
) -> None:
    """Keep what the next interval will be compared with; count entries that were known already."""
    known = 0
    for g in range(groups.lanes.shape[0]):
        short.queue_veh[g] = scratch.queue_veh[g]
        short.expected_veh[g] = scratch.expected_veh[g]
        short.row[g] = state_bin(float(scratch.queue_veh[g]), float(scratch.expected_veh[g]))
        short.treatment[g] = scratch.treatment[g]
        known += table.times[short.row[g], short.treatment[g]] > 0
    scratch.lookups[0] += known
    scratch.lookups[1] += groups.lanes.shape[0] - known
