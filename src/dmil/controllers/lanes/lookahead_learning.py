"""What lookahead learns from an interval that ended, compiled."""

from __future__ import annotations

from dmil.compilation import kernel
from dmil.controllers.lanes.lane_arrivals import filled_in
from dmil.controllers.lanes.lane_groups import LaneGroups
from dmil.controllers.lanes.lane_inputs import PARTLY, Inputs, LaneScratch, ShortTerm, state_bin
from dmil.controllers.lanes.lane_model import COST, NEXT, LookaheadParams, clear, lane_model
from dmil.controllers.lanes.movement_facts import Movements
from dmil.memory.residuals import ResidualTable, count_outcome, learn_outcome

NOT_LEARNED_FROM_VEH = 20.0
"""Longest queue that is learned from: beyond, the lane model needs no help."""


@kernel
def learn_model(
    groups: LaneGroups,
    params: LookaheadParams,
    table: ResidualTable,
    short: ShortTerm,
    inputs: Inputs,
    scratch: LaneScratch,
    movements: Movements,
) -> None:
    """Learn what the lane model missed in the interval that ended.

    Who still moves may be about to stop or to go: with ``censored`` an outcome is known only up to
    those, and what the model said within that was right.
    """
    facts, memory = movements.facts, movements.memory
    apart = 0
    for i in range(inputs.shown.shape[0]):
        told_apart = apart < facts.apart.shape[0] and facts.apart[apart] == i
        apart += told_apart
        # A rejected request was not executed: nothing is learned of it.
        if not params.learning or inputs.first or inputs.shown[i] != inputs.asked[i]:
            continue
        for g in range(groups.group_offset[i], groups.group_offset[i + 1]):
            queue_veh, arrivals_veh = float(short.queue_veh[g]), float(short.expected_veh[g])
            if queue_veh > NOT_LEARNED_FROM_VEH or filled_in(short, g):
                continue
            row, treated = int(state_bin(queue_veh, arrivals_veh)), short.treatment[g]
            flow_veh = float(groups.lane_veh[g])
            if told_apart and treated != PARTLY:
                part = memory.served[g] * memory.green[g]
                cost, end_veh = clear(queue_veh, arrivals_veh, flow_veh, part)
            else:
                cost, end_veh = lane_model(
                    queue_veh, arrivals_veh, flow_veh, treated, params.after_switch
                )
            waiting_veh, left_veh = float(scratch.waiting_veh[g]), float(scratch.queue_veh[g])
            if params.censored:
                moving_veh = float(scratch.moving_veh[g])
                mean_veh = 0.5 * (moving_veh + arrivals_veh)
                waiting_veh = min(max(cost, waiting_veh), waiting_veh + mean_veh)
                left_veh = min(max(end_veh, left_veh), left_veh + moving_veh)
            learn_outcome(table, row, treated, COST, waiting_veh - cost)
            learn_outcome(table, row, treated, NEXT, left_veh - end_veh)
            count_outcome(table, row, treated)
