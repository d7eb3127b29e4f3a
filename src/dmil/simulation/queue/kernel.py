"""The queue simulator's dynamics: arrays in, arrays changed, no objects, no random draws."""

from __future__ import annotations

from dmil.compilation import inlined_kernel, kernel
from dmil.simulation.queue.counts import count_approaching, count_queued, count_standing, observe
from dmil.simulation.queue.right_of_way import look_ahead, must_yield
from dmil.simulation.queue.state import (
    ARRIVED,
    NEXT_VEHICLE,
    NOBODY,
    OUTSIDE,
    OUTSIDE_STEPS,
    OVERRULED,
    STOPS,
    TIME,
    VISITS,
    WAITING,
    WAITING_STEPS,
    FloatArray,
    IntArray,
    Layout,
    State,
    Trips,
)
from dmil.simulation.timing import NEVER_S, Rules, first_wrong, follow_programs, grant


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

    Each step: departures, vehicles that reach the end of their leg, discharge, measurements; a
    vehicle may arrive and leave in the same step. Lanes discharge in their order: with finite
    storage the first of several lanes that lead to one link gets its last place, and a place that a
    lane frees can be taken by a later one in the same step.

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
    counters[OVERRULED] += grant(
        layout.signals,
        requested,
        state.phase,
        state.green_from_s,
        state.go_from_s,
        state.switch_s,
        counters[TIME],
        rules,
    )
    _wake_lanes(trips, state)
    # Arrays are taken out of their tuples once: the loop over all lanes is the hot one.
    wake_s, due_front = state.wake_s, state.due_front
    depart_s, arrived_at, queued_at = trips.depart_s, state.arrived_at, state.queued_at
    begin_s, end_s = counters[TIME], counters[TIME] + steps
    count_queued(state, steps)
    switch_s = begin_s
    for time_s in range(begin_s, end_s):
        if switch_s <= time_s:
            switch_s = follow_programs(
                layout.programs, state.go_from_s, state.switch_s, time_s, rules.startup_lost_s
            )
            _wake_lanes(trips, state)
        next_vehicle = counters[NEXT_VEHICLE]
        if next_vehicle < depart_s.shape[0] and depart_s[next_vehicle] <= time_s:
            _depart(layout, trips, state, time_s, end_s)
        if counters[OUTSIDE] > 0:
            _enter_where_room(layout, trips, state, time_s, end_s)
        if due_front[time_s % due_front.shape[0]] != NOBODY:
            _reach_leg_ends(layout, trips, state, time_s, end_s)
        if state.soonest_s.shape[0] > 0:
            look_ahead(layout, trips, state, time_s)
        for lane in range(wake_s.shape[0]):
            if wake_s[lane] <= time_s:
                _discharge(layout, trips, state, lane, time_s, end_s)
        counters[OUTSIDE_STEPS] += counters[OUTSIDE]
        waiting_veh = counters[WAITING] + counters[OUTSIDE]
        counters[WAITING_STEPS] += waiting_veh
        arrived_at[time_s] = counters[ARRIVED]
        queued_at[time_s] = waiting_veh
    counters[TIME] = end_s
    count_standing(layout, trips, state, rules.startup_lost_s)
    count_approaching(trips, state, rules.decision_interval_s)


@kernel
def advance_and_observe(
    layout: Layout,
    trips: Trips,
    state: State,
    requested: IntArray,
    lowest: IntArray,
    steps: int,
    rules: Rules,
    counts: IntArray,
    shown: IntArray,
    waiting_veh: FloatArray,
) -> bool:
    """Advance, then write what controllers see; see `advance` and `observe`.

    For a small network a call from Python takes as long as what it is for: one, not three. If a
    requested phase does not exist (see `checked_phases`), it returns false and changes nothing.
    """
    if first_wrong(requested, lowest, layout.signals.phase_count) < requested.shape[0]:
        return False
    advance(layout, trips, state, requested, steps, rules)
    observe(state, steps, counts, shown, waiting_veh)
    return True


@kernel
def _wake_lanes(trips: Trips, state: State) -> None:
    """Note for all lanes when they may move, after signals have changed."""
    for lane in range(state.wake_s.shape[0]):
        _wake_lane(trips, state, lane)


@inlined_kernel
def _wake_lane(trips: Trips, state: State, lane: int) -> None:
    """Note the first second in which the first vehicle of a lane may have green and headway.

    Until then the lane needs no look: what else holds a vehicle back is asked when it is time.
    """
    if state.front[lane] == NOBODY:
        state.wake_s[lane] = NEVER_S
        return
    movement = trips.movements[state.visit[state.front[lane]]]
    width = state.queue_veh.shape[1]
    go_from_s = state.go_from_s[movement // width, movement % width]
    state.wake_s[lane] = max(go_from_s, int(state.ready_s[lane]))


@inlined_kernel
def _append(front: IntArray, back: IntArray, behind: IntArray, place: int, vehicle: int) -> None:
    """Put a vehicle at the end of the linked list that starts at ``front[place]``."""
    behind[vehicle] = NOBODY
    if front[place] == NOBODY:
        front[place] = vehicle
    else:
        behind[back[place]] = vehicle
    back[place] = vehicle


@kernel
def _depart(layout: Layout, trips: Trips, state: State, time_s: int, end_s: int) -> None:
    """Let vehicles whose time has come into the network, or wait outside while it is full."""
    counters = state.counters
    vehicle = counters[NEXT_VEHICLE]
    while vehicle < trips.depart_s.shape[0] and trips.depart_s[vehicle] <= time_s:
        link = trips.leg_link[state.visit[vehicle] + vehicle]
        if state.outside_front[link] == NOBODY and _has_room(layout, state, link):
            _begin_leg(layout, trips, state, vehicle, time_s, end_s)
        else:
            state.joined_s[vehicle] = time_s
            _append(state.outside_front, state.outside_back, state.behind, link, vehicle)
            counters[OUTSIDE] += 1
        vehicle += 1
    counters[NEXT_VEHICLE] = vehicle


@kernel
def _enter_where_room(layout: Layout, trips: Trips, state: State, time_s: int, end_s: int) -> None:
    """Let vehicles that wait outside in where there is room again."""
    for link in range(layout.capacity_veh.shape[0]):
        while state.outside_front[link] != NOBODY and _has_room(layout, state, link):
            vehicle = state.outside_front[link]
            state.outside_front[link] = state.behind[vehicle]
            state.counters[OUTSIDE] -= 1
            state.waited_s[vehicle] += time_s - state.joined_s[vehicle]
            _begin_leg(layout, trips, state, vehicle, time_s, end_s)


@inlined_kernel
def _has_room(layout: Layout, state: State, link: int) -> bool:
    return bool(state.occupancy_veh[link] < layout.capacity_veh[link])


@inlined_kernel
def _begin_leg(
    layout: Layout, trips: Trips, state: State, vehicle: int, time_s: int, end_s: int
) -> None:
    """Send a vehicle to its next stop line; if that takes no time it is there at once."""
    leg = state.visit[vehicle] + vehicle
    state.occupancy_veh[trips.leg_link[leg]] += 1
    travel_s = trips.leg_s[leg]
    if travel_s == 0:
        _reach_leg_end(layout, trips, state, vehicle, time_s, end_s)
    else:
        due = (time_s + travel_s) % state.due_front.shape[0]
        _append(state.due_front, state.due_back, state.behind, due, vehicle)


@kernel
def _reach_leg_ends(layout: Layout, trips: Trips, state: State, time_s: int, end_s: int) -> None:
    due = time_s % state.due_front.shape[0]
    vehicle = state.due_front[due]
    state.due_front[due] = NOBODY
    while vehicle != NOBODY:
        following = state.behind[vehicle]
        _reach_leg_end(layout, trips, state, vehicle, time_s, end_s)
        vehicle = following


@inlined_kernel
def _reach_leg_end(
    layout: Layout, trips: Trips, state: State, vehicle: int, time_s: int, end_s: int
) -> None:
    """Join the shortest of its lanes at the stop line, or arrive if the leg was the last."""
    visit = state.visit[vehicle]
    if visit == trips.movement_offset[vehicle + 1]:
        state.occupancy_veh[trips.leg_link[visit + vehicle]] -= 1
        state.arrived_s[vehicle] = time_s
        state.counters[ARRIVED] += 1
        return
    movement = trips.movements[visit]
    row = trips.lane_row[visit]
    lane = layout.lanes[layout.lane_offset[row]]
    for place in range(layout.lane_offset[row] + 1, layout.lane_offset[row + 1]):
        if state.lane_veh[layout.lanes[place]] < state.lane_veh[lane]:
            lane = layout.lanes[place]
    _append(state.front, state.back, state.behind, lane, vehicle)
    state.lane_veh[lane] += 1
    if state.front[lane] == vehicle:
        _wake_lane(trips, state, lane)
    width = state.queue_veh.shape[1]
    i, j = movement // width, movement % width
    state.queue_veh[i, j] += 1
    state.waiting_steps[i, j] += end_s - time_s
    state.counters[WAITING] += 1
    state.joined_s[vehicle] = time_s
    state.counters[VISITS] += movement < layout.movement_link.shape[0] - state.soonest_s.shape[0]


@inlined_kernel
def _discharge(
    layout: Layout, trips: Trips, state: State, lane: int, time_s: int, end_s: int
) -> None:
    """Let the first vehicles of a lane go, one headway after the other.

    A vehicle goes in this step if it has green, need not give way, finds room, and the headway
    behind the one before it ends within the step; if not, all behind it wait.
    """
    width = state.queue_veh.shape[1]
    # 1e-9: three headways of a third of a second are one second.
    while state.front[lane] != NOBODY and state.ready_s[lane] < time_s + 1 - 1e-9:
        vehicle = state.front[lane]
        movement = trips.movements[state.visit[vehicle]]
        i, j = movement // width, movement % width
        if state.go_from_s[i, j] > time_s or must_yield(
            layout, trips, state, vehicle, lane, movement, time_s
        ):
            break
        link = trips.leg_link[state.visit[vehicle] + 1 + vehicle]
        if not _has_room(layout, state, link):
            break
        state.front[lane] = state.behind[vehicle]
        state.lane_veh[lane] -= 1
        state.queue_veh[i, j] -= 1
        state.waiting_steps[i, j] -= end_s - time_s
        state.counters[WAITING] -= 1
        state.counters[STOPS] += time_s > state.joined_s[vehicle]
        state.occupancy_veh[layout.movement_link[movement]] -= 1
        state.waited_s[vehicle] += time_s - state.joined_s[vehicle]
        state.visit[vehicle] += 1
        if movement >= layout.movement_link.shape[0] - state.went_s.shape[0]:
            state.went_s[movement - layout.movement_link.shape[0] + state.went_s.shape[0]] = time_s
        state.ready_s[lane] = max(state.ready_s[lane], float(time_s)) + layout.headway_s[movement]
        _begin_leg(layout, trips, state, vehicle, time_s, end_s)
    _wake_lane(trips, state, lane)
