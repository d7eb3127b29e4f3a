"""Look-ahead over a learned model of lanes, compiled: all intersections at once."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dmil.compilation import kernel
from dmil.controllers.lanes.lane_groups import LaneGroups
from dmil.controllers.lanes.lane_sight import (
    announce,
    count_arrivals,
    expect_announced,
    expect_by_rate,
    find_waves,
    forget_overruled,
    look,
    note_shown,
    note_treatment,
    served_wholly,
    sight_bin,
)
from dmil.controllers.lanes.lane_state import (
    KEPT,
    PARTLY,
    RED,
    ByteArray,
    IntArray,
    Scratch,
    Seen,
    ShortTerm,
    Single,
)
from dmil.memory.outcomes import OutcomeTable, believed, count_outcome, learn_outcome

COST, NEXT = range(2)
"""Outcomes of an interval: mean vehicles waiting in it, vehicles queued at its end."""
OUTCOMES = 2
UNSERVED, WHOLLY, IN_PART = range(3)
"""What a phase does to a group; with what was before it makes a treatment."""
NOT_LEARNED_FROM_VEH = 20.0
"""Longest queue that is learned from: beyond, the lane model needs no help."""
SAME = 1e-4
"""Costs that differ by less are the same: queues and arrivals are 32-bit numbers."""


class Outlook(NamedTuple):
    """Numbers of `LookaheadSettings` and of signal timing for the kernel."""

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
    use_approaching: bool
    learns: bool


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
    outlook: Outlook,
    table: OutcomeTable,
    short: ShortTerm,
    seen: Seen,
    scratch: Scratch,
    plans: Plans,
    phases: IntArray,
) -> None:
    """Choose all phases and learn from the last choice.

    Every intersection chooses by what it sees and announces that; then, knowing what its neighbours
    mean to do, it chooses again, some rounds long.

    Parameters
    ----------
    groups, outlook, table, short, seen, scratch, plans
        See there; table, short-term memory and scratch change in place.
    phases: (intersections,) int32
        Filled with the choice.
    """
    note_shown(groups, seen, scratch)
    look(groups, outlook.use_approaching, seen, scratch)
    if not seen.first:
        forget_overruled(groups, seen, short)
        count_arrivals(
            groups, outlook.use_approaching, outlook.after_switch, outlook.rate_step, short, scratch
        )
    expect_by_rate(groups, outlook.expected, short, scratch)
    for g in range(groups.lanes.shape[0]):
        plans.known_veh[g] = scratch.expected_veh[g]
        scratch.wave[g] = 0.0
    _predict(groups, outlook, table, short, scratch, plans)
    _choose(groups, outlook.terminal, seen, plans, phases)
    for _ in range(outlook.rounds):
        announce(groups, outlook.use_approaching, seen, scratch, phases)
        for g in range(groups.lanes.shape[0]):
            scratch.expected_veh[g] = plans.known_veh[g]
        expect_announced(groups, outlook.expected, short, scratch)
        find_waves(groups, outlook.wave, scratch)
        _predict(groups, outlook, table, short, scratch, plans)
        _choose(groups, outlook.terminal, seen, plans, phases)
    note_treatment(groups, outlook.after_switch, scratch, phases)
    _learn(groups, outlook, table, short, seen, scratch)


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
    outlook: Outlook,
    table: OutcomeTable,
    queue_veh: float,
    arrivals_veh: float,
    flow_veh: float,
    treatment: int,
) -> tuple[float, float]:
    """Return what the lane model says and what was learned beyond it."""
    cost, end_veh = lane_model(queue_veh, arrivals_veh, flow_veh, treatment, outlook.after_switch)
    row = int(sight_bin(queue_veh, arrivals_veh))
    cost += believed(table, row, treatment, COST, outlook.trust)
    end_veh += outlook.queue_trust * believed(table, row, treatment, NEXT, outlook.trust)
    return max(cost, 0.0), max(end_veh, 0.0)


@kernel
def _predict(
    groups: LaneGroups,
    outlook: Outlook,
    table: OutcomeTable,
    short: ShortTerm,
    scratch: Scratch,
    plans: Plans,
) -> None:
    """Predict the cost of every group for whatever this and the next phase do to it."""
    effects, after_switch = plans.cost.shape[1], outlook.after_switch
    for g in range(groups.lanes.shape[0]):
        flow_veh = groups.lane_veh[g]
        later_veh = outlook.later * float(short.rate_veh[g])
        for now in range(effects):
            treatment = _treatment(now, scratch.shown[g], after_switch)
            cost, end_veh = _foresee(
                outlook,
                table,
                float(scratch.queue_veh[g]),
                float(scratch.expected_veh[g]),
                flow_veh,
                treatment,
            )
            if now != UNSERVED:
                cost -= float(scratch.wave[g])
            stays = _left(outlook, end_veh)
            for then in range(effects):
                goes = stays
                if outlook.plan > 0.0:
                    treatment = _treatment(then, KEPT if now == WHOLLY else RED, after_switch)
                    next_cost, last_veh = _foresee(
                        outlook, table, end_veh, later_veh, flow_veh, treatment
                    )
                    goes = next_cost + outlook.discount * _left(outlook, last_veh)
                # The next decision may be another one, so its plan counts in part.
                ahead = (1.0 - outlook.plan) * stays + outlook.plan * goes
                plans.cost[g, now, then] = groups.lanes[g] * (cost + outlook.discount * ahead)


@kernel
def _treatment(effect: int, before: int, after_switch: float) -> int:
    """Return how a group is treated by a phase, given how it was treated before."""
    if effect == UNSERVED:
        return RED
    return PARTLY if effect == IN_PART else served_wholly(before, after_switch)


@kernel
def _left(outlook: Outlook, queue_veh: float) -> float:
    """Return what a queue costs that is left: more than in proportion to its length."""
    return (outlook.terminal + outlook.curvature * queue_veh) * queue_veh


@kernel
def _choose(groups: LaneGroups, vehicle: float, seen: Seen, plans: Plans, phases: IntArray) -> None:
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
            if seen.owed_veh.shape[0] > 0:
                for place in range(groups.flow_offset[now], groups.flow_offset[now + 1]):
                    unserved -= vehicle * seen.owed_veh[groups.flows[place]]
            least = np.inf
            for then in range(first, last):
                saved = 0.0
                for place in range(groups.served_offset[then], groups.served_offset[then + 1]):
                    g = groups.served[place]
                    served = IN_PART if groups.partly[place] else WHOLLY
                    saved += cost[g, effect[g], UNSERVED] - cost[g, effect[g], served]
                least = min(least, unserved - saved)
            # Of equally good phases the one shown stays.
            shown = now - first == seen.shown[i]
            if least < lowest - SAME or (shown and least < lowest + SAME):
                best, lowest = now - first, least
        phases[i] = best


@kernel
def _learn(
    groups: LaneGroups,
    outlook: Outlook,
    table: OutcomeTable,
    short: ShortTerm,
    seen: Seen,
    scratch: Scratch,
) -> None:
    """Learn what the lane model missed in the interval that ended; keep what was foreseen now."""
    known = 0
    for i in range(seen.shown.shape[0]):
        # Who was overruled was treated otherwise than his entry says.
        learns = outlook.learns and not seen.first and seen.shown[i] == seen.asked[i]
        for g in range(groups.group_offset[i], groups.group_offset[i + 1]):
            queue_veh, arrivals_veh = float(short.queue_veh[g]), float(short.expected_veh[g])
            if learns and queue_veh <= NOT_LEARNED_FROM_VEH:
                row, treated = short.row[g], short.treatment[g]
                cost, end_veh = lane_model(
                    queue_veh, arrivals_veh, groups.lane_veh[g], treated, outlook.after_switch
                )
                learn_outcome(table, row, treated, COST, scratch.waiting_veh[g] - cost)
                learn_outcome(table, row, treated, NEXT, scratch.queue_veh[g] - end_veh)
                count_outcome(table, row, treated)
            short.queue_veh[g] = scratch.queue_veh[g]
            short.expected_veh[g] = scratch.expected_veh[g]
            short.row[g] = sight_bin(float(scratch.queue_veh[g]), float(scratch.expected_veh[g]))
            short.treatment[g] = scratch.treatment[g]
            known += table.times[short.row[g], short.treatment[g]] > 0
    scratch.lookups[0] += known
    scratch.lookups[1] += groups.lanes.shape[0] - known
