"""What tells the movements of a lane group apart: who has to yield, and who has waited for long.

A group is one queue to a memory of lanes. That a phase serves it wholly does not say that all of
it can go: turns yield to oncoming vehicles, and under an all-stop clearance whoever keeps green
stops, too. With X_j vehicles of movement j, queued, approaching and expected:

    y_j = 1 − max_k min(1, X_k / (f·T·lanes_k·c_k))   part of movement j that finds a gap, k over
                                                      those it yields to that have green, too
    c_j = 1 if j keeps its green, else 1 − L/T        part of the interval that is green for it
    φ = Σ X_j·y_j / Σ X_j,  c = Σ X_j·y_j·c_j / Σ X_j·y_j          of a group

Side streets with few vehicles may wait for ever beside a busy road. What waits longer than usual
counts more, the less the queues the intersection has:

    A_j ← (A_j + T)·(1 − y_j) while j has a queue, y_j = 0 at red; else 0
    R ← R + 0.05·(A_j − R) whenever j gets green         how long red usually lasts here
    b_j = max(0, 1 − Q/4)·min(α·max(0, A_j − R), 4)      vehicles that green for j counts more,
                                                         Q vehicles queued per lane here

Both ours. An age that does not depend on R and Q costs up to 4.4 % near saturation.
"""

from __future__ import annotations

from dmil.arrays import FloatArray, IntArray
from dmil.compilation import kernel
from dmil.controllers.lanes.lane_groups import LaneGroups
from dmil.controllers.lanes.lane_inputs import Inputs, LaneScratch
from dmil.controllers.lanes.movement_facts import (
    ALWAYS,
    GREEN,
    MovementFacts,
    Movements,
    MovementWork,
)

MEAN_STEP = 0.05
"""Step of moving averages: of vehicles seen per movement, and of how long red lasts."""
SMALLEST_SHARE_VEH = 0.05
"""Added to the vehicles of a movement when those of a group are divided by them."""
QUEUES_LONG_VEH = 4.0
"""Vehicles queued per lane of an intersection from which on age does not count."""
NOBODY_VEH = 1e-5
"""Sums of vehicles below it are nobody: counts are kept in 32 bits."""
MOST_OWED_VEH = 4.0
"""What age counts at most."""
NO_PHASE = -1


@kernel
def shown_phase(groups: LaneGroups, inputs: Inputs, i: int) -> int:
    """Return the phase that an intersection shows, numbered over all, or `NO_PHASE`."""
    shown = inputs.shown[i]
    return int(groups.phase_offset[i] + shown) if shown >= 0 else NO_PHASE


@kernel
def move_ages(groups: LaneGroups, inputs: Inputs, movements: Movements) -> None:
    """Move the ages on by the interval that ended: see the top of this file."""
    facts, memory = movements.facts, movements.memory
    width = facts.light.shape[1]
    for i in range(inputs.shown.shape[0]):
        phase = shown_phase(groups, inputs, i)
        as_asked = inputs.shown[i] == inputs.asked[i]
        for j in range(width):
            movement = i * width + j
            if facts.group[movement] < 0:
                continue
            went = 0.0
            if phase != NO_PHASE and facts.light[phase, j] > 0:
                # What a phase that was not asked for let go is not known: all, let it be.
                told = memory.goes.shape[0] > 0 and as_asked
                went = float(memory.goes[movement]) if told else 1.0
                if memory.age_s[movement] > 0.0:
                    late_s = memory.age_s[movement] - memory.usual_red_s[i]
                    memory.usual_red_s[i] += MEAN_STEP * late_s
            waited_s = (memory.age_s[movement] + facts.interval_s) * (1.0 - went)
            memory.age_s[movement] = waited_s if inputs.queue_veh[movement] > 0 else 0.0


@kernel
def owe(
    groups: LaneGroups, age: float, inputs: Inputs, scratch: LaneScratch, movements: Movements
) -> None:
    """Note what green counts more for those who have waited longer than usual."""
    memory, owed_veh = movements.memory, movements.work.owed_veh
    for i in range(inputs.shown.shape[0]):
        queued, lanes = 0.0, 0.0
        for g in range(groups.group_offset[i], groups.group_offset[i + 1]):
            queued += scratch.queue_veh[g] * groups.lanes[g]
            lanes += groups.lanes[g]
        calm = max(0.0, 1.0 - queued / (QUEUES_LONG_VEH * max(lanes, 1.0)))
        for g in range(groups.group_offset[i], groups.group_offset[i + 1]):
            for place in range(groups.movement_offset[g], groups.movement_offset[g + 1]):
                movement = groups.movements[place]
                late_s = max(0.0, memory.age_s[movement] - memory.usual_red_s[i])
                owed_veh[movement] = calm * min(age * late_s, MOST_OWED_VEH)


@kernel
def note_vehicles(
    groups: LaneGroups,
    use_approaching: bool,
    inputs: Inputs,
    scratch: LaneScratch,
    movements: Movements,
) -> None:
    """Note all vehicles of single movements where these are told apart: X."""
    facts, memory, vehicles = movements.facts, movements.memory, movements.work.vehicles
    width = facts.light.shape[1]
    for at in range(facts.apart.shape[0]):
        i = facts.apart[at]
        for movement in range(i * width, (i + 1) * width):
            vehicles[movement] = inputs.queue_veh[movement] + (
                inputs.approaching_veh[movement] if use_approaching else 0
            )
        for g in range(groups.group_offset[i], groups.group_offset[i + 1]):
            more = float(scratch.queue_veh[g] + scratch.expected_veh[g]) * groups.lanes[g]
            shares = 0.0
            for place in range(groups.movement_offset[g], groups.movement_offset[g + 1]):
                more -= vehicles[groups.movements[place]]
                shares += memory.seen_veh[groups.movements[place]] + SMALLEST_SHARE_VEH
            for place in range(groups.movement_offset[g], groups.movement_offset[g + 1]):
                movement = groups.movements[place]
                share = memory.seen_veh[movement] + SMALLEST_SHARE_VEH
                vehicles[movement] += more * share / shares


@kernel
def average_seen(inputs: Inputs, movements: Movements) -> None:
    """Move the averages of vehicles seen on by what is seen now."""
    seen_veh = movements.memory.seen_veh
    for movement in range(seen_veh.shape[0]):
        now = inputs.queue_veh[movement] + inputs.approaching_veh[movement]
        seen_veh[movement] += MEAN_STEP * (now - seen_veh[movement])


@kernel
def look_at_movements(
    groups: LaneGroups, age: float, inputs: Inputs, scratch: LaneScratch, movements: Movements
) -> None:
    """Move on what is remembered of movements, as far as anything depends on it."""
    if age > 0.0:
        if not inputs.first:
            move_ages(groups, inputs, movements)
        owe(groups, age, inputs, scratch, movements)
    if movements.facts.apart.shape[0] > 0:
        average_seen(inputs, movements)


@kernel
def treat(
    groups: LaneGroups,
    facts: MovementFacts,
    i: int,
    phase: int,
    before: int,
    after_switch: float,
    vehicles: FloatArray,
    work: MovementWork,
) -> None:
    """Find how a phase treats the movements and groups of an intersection: y, φ and c.

    Parameters
    ----------
    phase, before
        Numbered over all intersections; before it `NO_PHASE`, if none is shown.
    vehicles: (movements,) float64
        X, of which those without a group are counted, too.
    work
        Its ``goes``, ``served`` and ``green`` are filled for this intersection.
    """
    light, goes = facts.light, work.goes
    width = light.shape[1]
    first = i * width
    stays = before != NO_PHASE and (phase == before or not groups.all_stop[i])
    for j in range(width):
        goes[first + j] = 1.0 if light[phase, j] > 0 else 0.0
    for j in range(width):
        movement = first + j
        if goes[movement] > 0.0:
            busy = 0.0
            for place in range(facts.foe_offset[movement], facts.foe_offset[movement + 1]):
                foe = facts.foes[place]
                shown = light[phase, foe - first]
                if shown > 0:
                    kept = shown == ALWAYS or (stays and light[before, foe - first] > 0)
                    green = 1.0 if kept or before == NO_PHASE else after_switch
                    full_veh = facts.capacity_veh[foe] * green
                    busy = max(busy, min(1.0, vehicles[foe] / max(full_veh, 1e-9)))
            goes[movement] = 1.0 - busy
    for g in range(groups.group_offset[i], groups.group_offset[i + 1]):
        of_all, going, going_green, lit, lit_green = 0.0, 0.0, 0.0, 0.0, 0.0
        begin, end = groups.movement_offset[g], groups.movement_offset[g + 1]
        for place in range(begin, end):
            movement = groups.movements[place]
            j = movement - first
            of_all += vehicles[movement]
            if light[phase, j] > 0:
                green = 1.0 if stays and light[before, j] > 0 else after_switch
                lit += 1.0
                lit_green += green
                going += vehicles[movement] * goes[movement]
                going_green += vehicles[movement] * goes[movement] * green
        work.served[g] = going / of_all if of_all > NOBODY_VEH else lit / (end - begin)
        if going > NOBODY_VEH:
            work.green[g] = going_green / going
        else:
            work.green[g] = lit_green / lit if lit > 0.0 else 0.0


@kernel
def owed_in_phase(
    groups: LaneGroups,
    facts: MovementFacts,
    i: int,
    phase: int,
    before: int,
    after_switch: float,
    work: MovementWork,
) -> float:
    """Return Σ b·c·y, what a phase counts more for those who waited for long; after `treat`."""
    light = facts.light
    first = i * light.shape[1]
    stays = before != NO_PHASE and (phase == before or not groups.all_stop[i])
    owed = 0.0
    for place in range(groups.flow_offset[phase], groups.flow_offset[phase + 1]):
        movement = groups.flows[place]
        j = movement - first
        if light[phase, j] == GREEN:
            green = 1.0 if stays and light[before, j] > 0 else after_switch
            owed += work.owed_veh[movement] * work.goes[movement] * green
    return owed


@kernel
def remember_treatment(
    groups: LaneGroups,
    after_switch: float,
    inputs: Inputs,
    movements: Movements,
    phases: IntArray,
) -> None:
    """Keep how the phases that were chosen treat movements and groups."""
    facts, memory, work = movements.facts, movements.memory, movements.work
    light, width = facts.light, facts.light.shape[1]
    for i in range(phases.shape[0] if facts.apart.shape[0] > 0 else 0):
        phase = groups.phase_offset[i] + phases[i]
        for j in range(width):
            memory.goes[i * width + j] = 1.0 if light[phase, j] > 0 else 0.0
    for at in range(facts.apart.shape[0]):
        i = facts.apart[at]
        phase, before = groups.phase_offset[i] + phases[i], shown_phase(groups, inputs, i)
        treat(groups, facts, i, phase, before, after_switch, work.vehicles, work)
        for movement in range(i * width, (i + 1) * width):
            memory.goes[movement] = work.goes[movement]
        for g in range(groups.group_offset[i], groups.group_offset[i + 1]):
            memory.served[g] = work.served[g]
            memory.green[g] = work.green[g]
