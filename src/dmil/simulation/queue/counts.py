"""What the queue simulator counts for whoever decides: queued, standing, on the way."""

from __future__ import annotations

from dmil.compilation import kernel
from dmil.simulation.queue.state import NOBODY, TIME, FloatArray, IntArray, Layout, State, Trips


@kernel
def count_queued(state: State, steps: int) -> None:
    """Count every queued vehicle's steps up to the next decision; departures subtract theirs."""
    queue_veh, waiting_steps = state.queue_veh, state.waiting_steps
    for i in range(queue_veh.shape[0]):
        for j in range(queue_veh.shape[1]):
            waiting_steps[i, j] = queue_veh[i, j] * steps


@kernel
def count_approaching(trips: Trips, state: State, within_s: int) -> None:
    """Count the vehicles that reach the end of their leg soon, per movement (specification, §2)."""
    counts = state.approaching_veh
    counts[:] = 0
    width = counts.shape[1]
    calendar = state.due_front.shape[0]
    time_s = state.counters[TIME]
    for ahead_s in range(min(within_s, calendar)):
        vehicle = state.due_front[(time_s + ahead_s) % calendar]
        while vehicle != NOBODY:
            if state.visit[vehicle] < trips.movement_offset[vehicle + 1]:
                movement = trips.movements[state.visit[vehicle]]
                counts[movement // width, movement % width] += 1
            vehicle = state.behind[vehicle]


@kernel
def count_standing(layout: Layout, trips: Trips, state: State, startup_lost_s: int) -> None:
    """Count the queued vehicles that a start wave has not reached yet, per movement (ours).

    Behind a stop line vehicle after vehicle begins to move from the beginning of green on, sooner
    than they cross it one headway after the other: those between are queued but do not stand. A
    vehicle that has green and does not go blocks those behind it.
    """
    standing_veh, wave_veh_per_s = state.standing_veh, layout.start_wave_veh_per_s[0]
    for i in range(standing_veh.shape[0]):
        for j in range(standing_veh.shape[1]):
            standing_veh[i, j] = state.queue_veh[i, j]
    if wave_veh_per_s == 0:
        return
    width, time_s = standing_veh.shape[1], state.counters[TIME]
    for lane in range(state.front.shape[0]):
        vehicle = state.front[lane]
        if vehicle == NOBODY or state.ready_s[lane] < time_s - 1e-9:
            continue
        movement = trips.movements[state.visit[vehicle]]
        go_from_s = state.go_from_s[movement // width, movement % width]
        if go_from_s >= time_s:
            continue
        since_go_s = float(time_s - go_from_s)
        reached_veh = wave_veh_per_s * (since_go_s + startup_lost_s)
        moving_veh = int(reached_veh - since_go_s / layout.headway_s[movement] + 1e-9)
        while moving_veh > 0 and vehicle != NOBODY:
            movement = trips.movements[state.visit[vehicle]]
            i, j = movement // width, movement % width
            if state.go_from_s[i, j] >= time_s:
                break
            standing_veh[i, j] -= 1
            moving_veh -= 1
            vehicle = state.behind[vehicle]


@kernel
def observe(
    state: State, interval_s: int, counts: IntArray, shown: IntArray, waiting_veh: FloatArray
) -> None:
    """Write what controllers see; they see no queues without signals.

    Parameters
    ----------
    state
    interval_s: int
        Length of the interval that ended now, in s.
    counts: (2, intersections, movements) int32
        Filled in place: vehicles queued and approaching.
    shown: (2, intersections) int32
        Filled in place: phases shown, and for how long.
    waiting_veh: (intersections, movements) float64
        Filled in place.
    """
    time_s = state.counters[TIME]
    for i in range(state.phase.shape[0]):
        shown[0, i] = state.phase[i]
        shown[1, i] = max(time_s - state.green_from_s[i], 0)
        for j in range(waiting_veh.shape[1]):
            counts[0, i, j] = state.standing_veh[i, j]
            counts[1, i, j] = state.approaching_veh[i, j]
            waiting_veh[i, j] = state.waiting_steps[i, j] / max(interval_s, 1)
