"""The queue simulator's dynamics: arrays in, arrays changed, no objects, no random draws."""

from __future__ import annotations

from dmil.compilation import kernel
from dmil.simulation.queue.state import (
    ARRIVED,
    NEXT_VEHICLE,
    NOBODY,
    OUTSIDE,
    REFUSED,
    TIME,
    VISITS,
    WAITING,
    WAITING_STEPS,
    IntArray,
    Layout,
    State,
    Trips,
)
from dmil.simulation.timing import Rules, grant


@kernel
def advance(
    layout: Layout,
    trips: Trips,
    state: State,
    requested: IntArray,
    steps: int,
    rules: Rules,
) -> None:
    """Show the requested phases and run the network for some steps of 1 s (specification, §2).

    Each step: departures, vehicles that reach the end of their link, discharge, measurements; a
    vehicle may arrive and leave in the same step. Queues discharge in the order of their slots:
    with finite storage the first of several queues that lead to one link gets its last place, and
    a place that a queue frees can be taken by a later one in the same step.

    Parameters
    ----------
    layout, trips, state
        See `dmil.simulation.queue.state`; the state changes in place.
    requested: (intersections,) int
        Phase wanted at each intersection.
    steps: int
    rules
        Signal timing; a vehicle that will join a queue within one decision interval counts as
        approaching.
    """
    counters = state.counters
    counters[REFUSED] += grant(
        layout.served,
        layout.unsignalled,
        requested,
        state.phase,
        state.green_from_s,
        state.go_from_s,
        counters[TIME],
        rules,
    )
    # Arrays are taken out of their tuples once: the loop over all slots is the hot one.
    queue_veh, waiting_steps = state.queue_veh.reshape(-1), state.waiting_steps.reshape(-1)
    go_from_s, due_front = state.go_from_s.reshape(-1), state.due_front
    depart_s, arrived_at, queued_at = trips.depart_s, state.arrived_at, state.queued_at
    waiting_steps[:] = 0
    for time_s in range(counters[TIME], counters[TIME] + steps):
        next_vehicle = counters[NEXT_VEHICLE]
        if next_vehicle < depart_s.shape[0] and depart_s[next_vehicle] <= time_s:
            _depart(layout, trips, state, time_s)
        if counters[OUTSIDE] > 0:
            _enter_where_room(layout, trips, state, time_s)
        if due_front[time_s % due_front.shape[0]] != NOBODY:
            _reach_link_ends(trips, state, time_s)
        for slot in range(queue_veh.shape[0]):
            if queue_veh[slot] > 0:
                if go_from_s[slot] <= time_s:
                    _discharge(layout, trips, state, slot, time_s)
                waiting_steps[slot] += queue_veh[slot]
        waiting_veh = counters[WAITING] + counters[OUTSIDE]
        counters[WAITING_STEPS] += waiting_veh
        arrived_at[time_s] = counters[ARRIVED]
        queued_at[time_s] = waiting_veh
    counters[TIME] += steps
    _count_approaching(trips, state, rules.decision_interval_s)


@kernel
def _count_approaching(trips: Trips, state: State, within_s: int) -> None:
    """Count the vehicles that reach the end of their link soon, per slot (specification, §2)."""
    counts = state.approaching_veh
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
def _append(front: IntArray, back: IntArray, behind: IntArray, place: int, vehicle: int) -> None:
    """Put a vehicle at the end of the linked list that starts at ``front[place]``."""
    behind[vehicle] = NOBODY
    if front[place] == NOBODY:
        front[place] = vehicle
    else:
        behind[back[place]] = vehicle
    back[place] = vehicle


@kernel
def _depart(layout: Layout, trips: Trips, state: State, time_s: int) -> None:
    """Let vehicles whose time has come into their entry link, or wait outside while it is full."""
    counters = state.counters
    vehicle = counters[NEXT_VEHICLE]
    while vehicle < trips.depart_s.shape[0] and trips.depart_s[vehicle] <= time_s:
        link = trips.entry_link[vehicle]
        if state.outside_front[link] == NOBODY and _has_room(layout, state, link):
            _enter_link(layout, trips, state, vehicle, link, time_s)
        else:
            state.joined_s[vehicle] = time_s
            _append(state.outside_front, state.outside_back, state.behind, link, vehicle)
            counters[OUTSIDE] += 1
        vehicle += 1
    counters[NEXT_VEHICLE] = vehicle


@kernel
def _enter_where_room(layout: Layout, trips: Trips, state: State, time_s: int) -> None:
    """Let vehicles that wait outside into entry links that have room again."""
    for link in range(layout.travel_s.shape[0]):
        while state.outside_front[link] != NOBODY and _has_room(layout, state, link):
            vehicle = state.outside_front[link]
            state.outside_front[link] = state.behind[vehicle]
            state.counters[OUTSIDE] -= 1
            state.waited_s[vehicle] += time_s - state.joined_s[vehicle]
            _enter_link(layout, trips, state, vehicle, link, time_s)


@kernel
def _has_room(layout: Layout, state: State, link: int) -> bool:
    return bool(state.occupancy_veh[link] < layout.capacity_veh[link])


@kernel
def _enter_link(
    layout: Layout, trips: Trips, state: State, vehicle: int, link: int, time_s: int
) -> None:
    """Put a vehicle on a link; on one that takes no time it is at the end at once."""
    state.occupancy_veh[link] += 1
    travel_s = layout.travel_s[link]
    if travel_s == 0:
        _reach_link_end(trips, state, vehicle, time_s)
    else:
        due = (time_s + travel_s) % state.due_front.shape[0]
        _append(state.due_front, state.due_back, state.behind, due, vehicle)


@kernel
def _reach_link_ends(trips: Trips, state: State, time_s: int) -> None:
    due = time_s % state.due_front.shape[0]
    vehicle = state.due_front[due]
    state.due_front[due] = NOBODY
    while vehicle != NOBODY:
        following = state.behind[vehicle]
        _reach_link_end(trips, state, vehicle, time_s)
        vehicle = following


@kernel
def _reach_link_end(trips: Trips, state: State, vehicle: int, time_s: int) -> None:
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
    state.counters[WAITING] += 1
    state.joined_s[vehicle] = time_s
    state.counters[VISITS] += 1


@kernel
def _discharge(layout: Layout, trips: Trips, state: State, slot: int, time_s: int) -> None:
    """Let the first vehicles of a green queue go, one headway after the other, while there is room.

    A vehicle goes in this step if the headway behind the one before it ends within the step.
    """
    orientations = state.queue_veh.shape[1]
    i, j = slot // orientations, slot % orientations
    # 1e-9: three headways of a third of a second are one second.
    while state.queue_veh[i, j] > 0 and state.ready_s[slot] < time_s + 1 - 1e-9:
        if not _let_go(layout, trips, state, i, j, slot, time_s):
            break
        state.ready_s[slot] = max(state.ready_s[slot], float(time_s)) + layout.headway_s[slot]


@kernel
def _let_go(
    layout: Layout, trips: Trips, state: State, i: int, j: int, slot: int, time_s: int
) -> bool:
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
    state.counters[WAITING] -= 1
    state.occupancy_veh[layout.slot_link[slot]] -= 1
    state.waited_s[vehicle] += time_s - state.joined_s[vehicle]
    state.visit[vehicle] = visit
    _enter_link(layout, trips, state, vehicle, link, time_s)
    return True
