"""Look-ahead where movements are told apart: who yields now and at the next decision."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from dmil.arrays import ByteArray, FloatArray
from dmil.compilation import kernel
from dmil.controllers.lanes.lane_groups import LaneGroups
from dmil.controllers.lanes.lane_inputs import (
    KEPT,
    PARTLY,
    RED,
    Inputs,
    LaneScratch,
    ShortTerm,
    served_wholly,
    state_bin,
)
from dmil.controllers.lanes.lane_model import (
    LookaheadParams,
    clear,
    corrected,
    lane_model,
    left,
)
from dmil.controllers.lanes.movement_facts import Movements, MovementWork, make_work
from dmil.controllers.lanes.movements import (
    SMALLEST_SHARE_VEH,
    owed_in_phase,
    shown_phase,
    treat,
)
from dmil.memory.residuals import ResidualTable

YIELDING_STAY = 1.5
"""Of those left on a lane a vehicle is one with weight 1.5 − y: who yields leaves later."""


class Outlook(NamedTuple):
    """Working space: what a phase leads to.

    Attributes
    ----------
    then: MovementWork
        Vehicles of every movement at the next decision, and how a phase treats them there.
    treatment, treated_then: (groups,) uint8
        By the phase of this decision, and of the next one.
    end_veh: (groups,) float64
        Vehicles queued per lane at the next decision.
    """

    then: MovementWork
    treatment: ByteArray
    treated_then: ByteArray
    end_veh: FloatArray


def make_outlook(groups: LaneGroups, movements: Movements) -> Outlook:
    """Return working space for a network."""
    count = groups.lanes.size
    return Outlook(
        then=make_work(movements.facts.group.size, count),
        treatment=np.zeros(count, np.uint8),
        treated_then=np.zeros(count, np.uint8),
        end_veh=np.zeros(count),
    )


@kernel
def add_up_apart(
    groups: LaneGroups,
    params: LookaheadParams,
    table: ResidualTable,
    short: ShortTerm,
    inputs: Inputs,
    scratch: LaneScratch,
    movements: Movements,
    outlook: Outlook,
    total: FloatArray,
) -> None:
    """Find what phases cost with the best one after it, where movements are told apart."""
    facts, width = movements.facts, movements.facts.light.shape[1]
    for at in range(facts.apart.shape[0]):
        i = facts.apart[at]
        for movement in range(i * width, (i + 1) * width):
            # Of those without a signal as many are there at the next decision as now.
            outlook.then.vehicles[movement] = movements.work.vehicles[movement]
        first, last = groups.phase_offset[i], groups.phase_offset[i + 1]
        before = shown_phase(groups, inputs, i)
        for now in range(first, last):
            cost = _begin(groups, params, table, short, scratch, movements, outlook, i, now, before)
            if params.plan > 0.0:
                least = np.inf
                for then in range(first, last):
                    goes_on = _go_on(groups, params, table, short, movements, outlook, i, then, now)
                    least = min(least, goes_on)
                cost += params.discount * params.plan * least
            total[now - first, i] = cost


@kernel
def _foresee(
    groups: LaneGroups,
    params: LookaheadParams,
    table: ResidualTable,
    work: MovementWork,
    g: int,
    treatment: int,
    queue_veh: float,
    arrivals_veh: float,
) -> tuple[float, float]:
    """Return what a group comes to, after `treat`: by the lane model and what was learned."""
    flow_veh = float(groups.lane_veh[g])
    if treatment in (RED, PARTLY):
        cost, end_veh = lane_model(
            queue_veh, arrivals_veh, flow_veh, treatment, params.after_switch
        )
    else:
        cost, end_veh = clear(queue_veh, arrivals_veh, flow_veh, work.served[g] * work.green[g])
    row = int(state_bin(queue_veh, arrivals_veh))
    return corrected(params, table, row, treatment, cost, end_veh)


@kernel
def _begin(
    groups: LaneGroups,
    params: LookaheadParams,
    table: ResidualTable,
    short: ShortTerm,
    scratch: LaneScratch,
    movements: Movements,
    outlook: Outlook,
    i: int,
    now: int,
    before: int,
) -> float:
    """Return what a phase costs without the next one; note who is left at the next decision."""
    facts, work, after_switch = movements.facts, movements.work, params.after_switch
    treat(groups, facts, i, now, before, after_switch, work.vehicles, work)
    cost = 0.0
    if params.age > 0.0:
        owed_veh = owed_in_phase(groups, facts, i, now, before, after_switch, work)
        cost -= params.terminal * owed_veh
    for g in range(groups.group_offset[i], groups.group_offset[i + 1]):
        outlook.treatment[g] = RED
    stops = groups.all_stop[i] and now != before
    for place in range(groups.served_offset[now], groups.served_offset[now + 1]):
        g = groups.served[place]
        wholly = served_wholly(RED if stops else scratch.shown[g], after_switch)
        outlook.treatment[g] = PARTLY if groups.partly[place] else wholly
    stays = 1.0 - params.plan
    for g in range(groups.group_offset[i], groups.group_offset[i + 1]):
        queue_veh, arrivals_veh = float(scratch.queue_veh[g]), float(scratch.expected_veh[g])
        treatment = outlook.treatment[g]
        waits, end_veh = _foresee(
            groups, params, table, work, g, treatment, queue_veh, arrivals_veh
        )
        if treatment != RED:
            waits -= float(scratch.wave[g]) * (1.0 if treatment == PARTLY else work.served[g])
        outlook.end_veh[g] = end_veh
        cost += groups.lanes[g] * (waits + params.discount * stays * left(params, end_veh))
        _leave(groups, params, short, movements, outlook, g)
    return cost


@kernel
def _leave(
    groups: LaneGroups,
    params: LookaheadParams,
    short: ShortTerm,
    movements: Movements,
    outlook: Outlook,
    g: int,
) -> None:
    """Divide the vehicles of a group at the next decision among its movements."""
    work, seen_veh = movements.work, movements.memory.seen_veh
    lanes, later_veh = float(groups.lanes[g]), params.later * float(short.rate_veh[g])
    held, going, shares = 0.0, 0.0, 0.0
    for place in range(groups.movement_offset[g], groups.movement_offset[g + 1]):
        movement = groups.movements[place]
        if work.goes[movement] == 0.0:
            held += work.vehicles[movement]
        else:
            stays = YIELDING_STAY - work.goes[movement]
            going += work.vehicles[movement] * stays + SMALLEST_SHARE_VEH
        shares += seen_veh[movement] + SMALLEST_SHARE_VEH
    left_of_going = max(0.0, outlook.end_veh[g] * lanes - held)
    for place in range(groups.movement_offset[g], groups.movement_offset[g + 1]):
        movement = groups.movements[place]
        there, goes = work.vehicles[movement], work.goes[movement]
        share = (seen_veh[movement] + SMALLEST_SHARE_VEH) / shares
        if goes > 0.0:
            weight = there * (YIELDING_STAY - goes) + SMALLEST_SHARE_VEH
            there = left_of_going * weight / going
        outlook.then.vehicles[movement] = there + later_veh * lanes * share


@kernel
def _go_on(
    groups: LaneGroups,
    params: LookaheadParams,
    table: ResidualTable,
    short: ShortTerm,
    movements: Movements,
    outlook: Outlook,
    i: int,
    then: int,
    now: int,
) -> float:
    """Return what the phase of the next decision leads to."""
    facts, work, after_switch = movements.facts, outlook.then, params.after_switch
    treat(groups, facts, i, then, now, after_switch, work.vehicles, work)
    treated = outlook.treated_then
    for g in range(groups.group_offset[i], groups.group_offset[i + 1]):
        treated[g] = RED
    stops = groups.all_stop[i] and then != now
    for place in range(groups.served_offset[then], groups.served_offset[then + 1]):
        g = groups.served[place]
        goes_on = outlook.treatment[g] != RED and outlook.treatment[g] != PARTLY and not stops
        wholly = served_wholly(KEPT if goes_on else RED, after_switch)
        treated[g] = PARTLY if groups.partly[place] else wholly
    cost = 0.0
    for g in range(groups.group_offset[i], groups.group_offset[i + 1]):
        queue_veh, arrivals_veh = outlook.end_veh[g], params.later * float(short.rate_veh[g])
        waits, end_veh = _foresee(
            groups, params, table, work, g, treated[g], queue_veh, arrivals_veh
        )
        cost += groups.lanes[g] * (waits + params.discount * left(params, end_veh))
    return cost
