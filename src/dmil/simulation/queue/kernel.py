"""The queue simulator's dynamics: arrays in, arrays changed, no objects, no random draws."""

from __future__ import annotations

from dmil.compilation import kernel
from dmil.simulation.queue.state import (
    ARRIVED,
    NEXT_VEHICLE,
    NOBODY,
    OUTSIDE,
    OVERRULED,
    TIME,
    VISITS,
    WAITING_STEPS,
)
from dmil.simulation.timing import grant, may_go


@kernel
def advance(layout, trips, state, requested, steps, min_green_s, clearance_s, startup_lost_s):  # type: ignore[no-untyped-def]
    """Show the requested phases and run the network for some steps of 1 s (specification, §2).

    Each step: departures, vehicles that reach the end of their link, discharge, measurements; a
    vehicle may arrive and leave in the same step.

    Parameters
    ----------
    layout, trips, state
        See `dmil.simulation.queue.state`; the state changes in place.
    requested: (intersections,) int
        Phase wanted at each intersection.
    steps, min_green_s, clearance_s, startup_lost_s: int
    """
    counters = state.counters
    counters[OVERRULED] += grant(
        requested,
        state.phase,
        state.previous_phase,
        state.green_s,
        state.clearance_left_s,
        min_green_s,
        clearance_s,
    )
    state.waiting_steps[:] = 0
    for _ in range(steps):
        time_s = counters[TIME]
        _depart(layout, trips, state, time_s)
        _reach_link_ends(trips, state, time_s)
        _discharge(layout, trips, state, time_s, startup_lost_s)
        _measure(state, time_s)
        _tick_signals(state)
        counters[TIME] = time_s + 1


@kernel
def approaching(trips, state, within_s, counts):  # type: ignore[no-untyped-def]
    """Count the vehicles that reach the end of their link soon, per slot (specification, §2).

    Parameters
    ----------
    trips, state
        See `dmil.simulation.queue.state`.
    within_s: int
        How far ahead to look.
    counts: (intersections, orientations) int32
        Filled in place.
    """
    counts[:] = 0
    orientations = counts.shape[1]
    calendar = state.due_front.shape[0]
    time_s = state.counters[TIME]
    for ahead_s in range(min(within_s, calendar)):
        vehicle = state.due_front[(time_s + ahead_s) % calendar]
        while vehicle != NOBODY:
            if state.visit[vehicle] < trips.slot_offset[vehicle + 1]:
                slot = trips.slots[state.visit[vehicle]]
                counts[slot // orientations, slot % orientations] += 1
            vehicle = state.behind[vehicle]


@kernel
def _append(front, back, behind, place, vehicle):  # type: ignore[no-untyped-def]
    """Put a vehicle at the end of the linked list that starts at ``front[place]``."""
    behind[vehicle] = NOBODY
    if front[place] == NOBODY:
        front[place] = vehicle
    else:
        behind[back[place]] = vehicle
    back[place] = vehicle


@kernel
def _depart(layout, trips, state, time_s):  # type: ignore[no-untyped-def]
    """Let vehicles whose time has come into their entry link, or wait outside while it is full."""
    counters = state.counters
    vehicle = counters[NEXT_VEHICLE]
    while vehicle < trips.depart_s.shape[0] and trips.depart_s[vehicle] <= time_s:
        link = trips.entry_link[vehicle]
        state.joined_s[vehicle] = time_s
        _append(state.outside_front, state.outside_back, state.behind, link, vehicle)
        counters[OUTSIDE] += 1
        vehicle += 1
        if state.outside_front[link] == vehicle - 1 and _has_room(layout, state, link):
            _enter_network(layout, trips, state, link, time_s)
    counters[NEXT_VEHICLE] = vehicle
    if counters[OUTSIDE] > 0:
        for link in range(layout.travel_s.shape[0]):
            while state.outside_front[link] != NOBODY and _has_room(layout, state, link):
                _enter_network(layout, trips, state, link, time_s)


@kernel
def _has_room(layout, state, link):  # type: ignore[no-untyped-def]
    return state.occupancy_veh[link] < layout.capacity_veh[link]


@kernel
def _enter_network(layout, trips, state, link, time_s):  # type: ignore[no-untyped-def]
    """Move the first vehicle that waits outside onto its entry link."""
    vehicle = state.outside_front[link]
    state.outside_front[link] = state.behind[vehicle]
    state.counters[OUTSIDE] -= 1
    state.waited_s[vehicle] += time_s - state.joined_s[vehicle]
    _enter_link(layout, trips, state, vehicle, link, time_s)


@kernel
def _enter_link(layout, trips, state, vehicle, link, time_s):  # type: ignore[no-untyped-def]
    """Put a vehicle on a link; on one that takes no time it is at the end at once."""
    state.occupancy_veh[link] += 1
    travel_s = layout.travel_s[link]
    if travel_s == 0:
        _reach_link_end(trips, state, vehicle, time_s)
    else:
        due = (time_s + travel_s) % state.due_front.shape[0]
        _append(state.due_front, state.due_back, state.behind, due, vehicle)


@kernel
def _reach_link_ends(trips, state, time_s):  # type: ignore[no-untyped-def]
    due = time_s % state.due_front.shape[0]
    vehicle = state.due_front[due]
    state.due_front[due] = NOBODY
    while vehicle != NOBODY:
        following = state.behind[vehicle]
        _reach_link_end(trips, state, vehicle, time_s)
        vehicle = following


@kernel
def _reach_link_end(trips, state, vehicle, time_s):  # type: ignore[no-untyped-def]
    """Join the queue at the end of the link, or arrive if the link was the journey's last."""
    if state.visit[vehicle] == trips.slot_offset[vehicle + 1]:
        state.occupancy_veh[trips.exit_link[vehicle]] -= 1
        state.arrived_s[vehicle] = time_s
        state.counters[ARRIVED] += 1
        return
    slot = trips.slots[state.visit[vehicle]]
    orientations = state.queue_veh.shape[1]
    _append(state.front, state.back, state.behind, slot, vehicle)
    state.queue_veh[slot // orientations, slot % orientations] += 1
    state.joined_s[vehicle] = time_s
    state.counters[VISITS] += 1


@kernel
def _discharge(layout, trips, state, time_s, startup_lost_s):  # type: ignore[no-untyped-def]
    """Let the first vehicles of every green queue go, as saturation flow and room allow."""
    intersections, orientations = state.queue_veh.shape
    for i in range(intersections):
        served = layout.served[i]
        for j in range(orientations):
            slot = i * orientations + j
            if layout.slot_link[slot] < 0:
                break
            green = layout.unsignalled[i, j] or may_go(
                served, state.phase[i], state.previous_phase[i], state.clearance_left_s[i], j
            )
            if not green:
                state.slot_green_s[slot] = 0
                state.credit_veh[slot] = 0.0
                continue
            state.slot_green_s[slot] += 1
            if state.slot_green_s[slot] <= startup_lost_s and not layout.unsignalled[i, j]:
                continue
            rate = layout.rate_veh_per_s[slot]
            credit = state.credit_veh[slot] + rate
            # 1e-9: a third of a vehicle three times is one vehicle.
            while credit >= 1.0 - 1e-9 and state.queue_veh[i, j] > 0:
                if not _let_go(layout, trips, state, i, j, slot, time_s):
                    break
                credit -= 1.0
            # Unused flow is not saved up: an empty or blocked queue starts with at most one vehicle.
            if state.queue_veh[i, j] == 0 or credit >= 1.0:
                credit = min(credit, max(0.0, 1.0 - rate))
            state.credit_veh[slot] = max(credit, 0.0)


@kernel
def _let_go(layout, trips, state, i, j, slot, time_s):  # type: ignore[no-untyped-def]
    """Move the first vehicle of a queue to its next link; false if that link is full."""
    vehicle = state.front[slot]
    visit = state.visit[vehicle] + 1
    if visit == trips.slot_offset[vehicle + 1]:
        link = trips.exit_link[vehicle]
    else:
        link = layout.slot_link[trips.slots[visit]]
    if not _has_room(layout, state, link):
        return False
    state.front[slot] = state.behind[vehicle]
    state.queue_veh[i, j] -= 1
    state.occupancy_veh[layout.slot_link[slot]] -= 1
    state.waited_s[vehicle] += time_s - state.joined_s[vehicle]
    state.visit[vehicle] = visit
    _enter_link(layout, trips, state, vehicle, link, time_s)
    return True


@kernel
def _measure(state, time_s):  # type: ignore[no-untyped-def]
    counters = state.counters
    waiting = counters[OUTSIDE]
    intersections, orientations = state.queue_veh.shape
    for i in range(intersections):
        for j in range(orientations):
            waiting += state.queue_veh[i, j]
            state.waiting_steps[i, j] += state.queue_veh[i, j]
    counters[WAITING_STEPS] += waiting
    state.arrived_at[time_s] = counters[ARRIVED]
    state.queued_at[time_s] = waiting


@kernel
def _tick_signals(state):  # type: ignore[no-untyped-def]
    for i in range(state.phase.shape[0]):
        if state.clearance_left_s[i] > 0:
            state.clearance_left_s[i] -= 1
        else:
            state.green_s[i] += 1
