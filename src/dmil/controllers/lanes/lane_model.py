"""What lookahead expects of a lane: a fluid model, and what was learned beyond it."""

from __future__ import annotations

from typing import NamedTuple

from dmil.compilation import kernel
from dmil.controllers.lanes.lane_inputs import KEPT, PARTLY, RED
from dmil.memory.residuals import ResidualTable, believed

COST, NEXT = range(2)
"""Outcomes of an interval: mean vehicles waiting in it, vehicles queued at its end."""
OUTCOMES = 2


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
    age: float
    trust: float
    queue_trust: float
    rate_step: float
    after_switch: float
    approaching: bool
    censored: bool
    learning: bool


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
    return clear(queue_veh, arrivals_veh, flow_veh, green)


@kernel
def clear(
    queue_veh: float, arrivals_veh: float, flow_veh: float, green: float
) -> tuple[float, float]:
    """Return the same of a lane that has red first, then green for a part of the interval (ours).

    Whoever yields goes when the others are through: to them that is red, too.
    """
    red = 1.0 - green
    longest_veh = queue_veh + arrivals_veh * red
    cost = red * 0.5 * (queue_veh + longest_veh)
    shrinks_veh = flow_veh - arrivals_veh
    end_veh = longest_veh - shrinks_veh * green
    if end_veh >= 0.0:
        return cost + green * 0.5 * (longest_veh + end_veh), end_veh
    return cost + 0.5 * longest_veh * longest_veh / shrinks_veh, 0.0


@kernel
def corrected(
    params: LookaheadParams,
    table: ResidualTable,
    row: int,
    treatment: int,
    cost: float,
    end_veh: float,
) -> tuple[float, float]:
    """Return what a lane model says and what was learned beyond it."""
    cost += believed(table, row, treatment, COST, params.trust)
    end_veh += params.queue_trust * believed(table, row, treatment, NEXT, params.trust)
    return max(cost, 0.0), max(end_veh, 0.0)


@kernel
def left(params: LookaheadParams, queue_veh: float) -> float:
    """Return what a queue costs that is left: more than in proportion to its length."""
    return (params.terminal + params.curvature * queue_veh) * queue_veh
