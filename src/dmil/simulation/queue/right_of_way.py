"""Who goes first: of two queues with green, and without signals by gaps or in turn."""

from __future__ import annotations

from dmil.compilation import inlined_kernel, kernel
from dmil.simulation.queue.state import NOBODY, Layout, State, Trips
from dmil.simulation.timing import NEVER_S

LONGEST_GAP_S = 7
"""No critical gap reaches beyond the whole second after this one."""


@kernel
def _came_first(
    layout: Layout, trips: Trips, state: State, foe: int, movement: int, lane: int
) -> bool:
    """Tell whether somebody waits at the head of a lane of the other movement for longer."""
    since_s = _first_since_s(state, lane)
    for place in range(layout.lane_offset[foe], layout.lane_offset[foe + 1]):
        vehicle = state.front[layout.lanes[place]]
        if vehicle != NOBODY and trips.movements[state.visit[vehicle]] == foe:
            foe_since_s = _first_since_s(state, layout.lanes[place])
            if foe_since_s < since_s or (foe_since_s == since_s and foe < movement):
                return True
    return False


@inlined_kernel
def _first_since_s(state: State, lane: int) -> int:
    """Return the second in which the first vehicle of a lane came to its head."""
    return int(max(state.ready_s[lane], float(state.joined_s[state.front[lane]])) + 1e-9)


@inlined_kernel
def must_yield(
    layout: Layout, trips: Trips, state: State, vehicle: int, lane: int, movement: int, time_s: int
) -> bool:
    """Tell whether others go first: a queue that has green, and who comes within the critical gap.

    Nobody waits for a queue for ever; gaps are asked for at junctions without signals.

    Parameters
    ----------
    layout, trips, state
        See `dmil.simulation.queue.state`.
    vehicle, lane, movement
        Who wants to go, from where and whereto.
    time_s
        Now.
    """
    first, last = layout.yield_offset[movement], layout.yield_offset[movement + 1]
    if first == last:
        return False
    if layout.gap_s[movement] > 0:
        signalled = layout.movement_link.shape[0] - state.soonest_s.shape[0]
        for place in range(first, last):
            foe = layout.yields[place] - signalled
            if state.went_s[foe] + layout.after_s[place] > time_s:
                return True
            if not layout.turns[place] and state.soonest_s[foe] < time_s + layout.gap_s[movement]:
                return True
    ahead_since_s = max(state.ready_s[lane], float(state.joined_s[vehicle]))
    # 1e-9: seven headways of 1 / 0.7 s are ten seconds.
    if ahead_since_s + layout.gap_wait_s[0] <= time_s + 1e-9:
        return False
    width = state.queue_veh.shape[1]
    for place in range(first, last):
        foe = layout.yields[place]
        i, j = foe // width, foe % width
        if (
            state.queue_veh[i, j] > 0
            and state.go_from_s[i, j] <= time_s
            and (not layout.turns[place] or _came_first(layout, trips, state, foe, movement, lane))
        ):
            return True
    return False


@kernel
def look_ahead(layout: Layout, trips: Trips, state: State, time_s: int) -> None:
    """Note when the next vehicles come to junctions without signals: who gives way asks.

    Parameters
    ----------
    layout, trips, state
        See `dmil.simulation.queue.state`; ``soonest_s`` changes.
    time_s
        Now.
    """
    soonest_s, signalled = state.soonest_s, layout.movement_link.shape[0] - state.soonest_s.shape[0]
    soonest_s[:] = NEVER_S
    calendar = state.due_front.shape[0]
    # From the last second to the next, so that what is noted last is the soonest.
    for ahead_s in range(min(LONGEST_GAP_S, calendar - 1), 0, -1):
        vehicle = state.due_front[(time_s + ahead_s) % calendar]
        while vehicle != NOBODY:
            if state.visit[vehicle] < trips.movement_offset[vehicle + 1]:
                movement = trips.movements[state.visit[vehicle]]
                if movement >= signalled:
                    soonest_s[movement - signalled] = time_s + ahead_s
            vehicle = state.behind[vehicle]
