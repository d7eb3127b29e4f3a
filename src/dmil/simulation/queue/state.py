"""Arrays of the queue simulator: what the network is, who drives, how things stand.

Parameters (`Layout`), journeys (`Trips`) and state (`State`) are separate; the kernel moves the
state and never allocates. An *orientation* is one entry of the state vector of an intersection; the
flat index ``slot = intersection * orientations + orientation`` names it network-wide.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dmil.simulation.timing import NEVER_S

IntArray = npt.NDArray[np.int32]
LongArray = npt.NDArray[np.int64]
FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

NOBODY = -1
"""End of a linked list of vehicles."""

TIME, NEXT_VEHICLE, ARRIVED, WAITING, WAITING_STEPS, VISITS, OUTSIDE, REFUSED = range(8)
"""Places of the scalars in ``State.counters``."""
COUNTERS = 8


class Layout(NamedTuple):
    """A road network and its traffic dynamics as flat arrays; never changes during a run.

    Attributes
    ----------
    phase_count: (intersections,) int32
    served: (intersections, phases, orientations) bool
        Who may go in a phase, the unsignalled movements included.
    unsignalled: (intersections, orientations) bool
    slot_link: (slots,) int32
        Link on which the queue of a slot stands; −1 where a slot is padding.
    headway_s: (slots,) float64
        Time between two vehicles at saturation flow, all lanes of the movement together.
    travel_s: (links,) int32
    capacity_veh: (links,) int32
        Most vehicles on a link, moving and queued; a huge number where storage is unlimited.
    """

    phase_count: IntArray
    served: BoolArray
    unsignalled: BoolArray
    slot_link: IntArray
    headway_s: FloatArray
    travel_s: IntArray
    capacity_veh: IntArray


class Trips(NamedTuple):
    """Every journey of a run, drawn before it starts.

    Attributes
    ----------
    depart_s: (vehicles,) int32, non-decreasing
    slot_offset: (vehicles + 1,) int32
        Where the journey of a vehicle begins in ``slots``.
    slots: (intersection visits,) int32
        The slots that each vehicle queues in, one after the other.
    entry_link, exit_link: (vehicles,) int32
    """

    depart_s: IntArray
    slot_offset: IntArray
    slots: IntArray
    entry_link: IntArray
    exit_link: IntArray


class State(NamedTuple):
    """Everything that changes; first-in-first-out queues are linked lists through ``behind``.

    Attributes
    ----------
    counters: (8,) int64
        Time in s, next vehicle to depart, vehicles arrived, vehicles waiting, vehicle-steps waited,
        intersection visits begun, vehicles that wait outside for room, phase changes refused.
    phase: (intersections,) int32
        Phase shown; −1 before the first decision.
    green_from_s: (intersections,) int32
        When that phase turned green; in the future during a clearance.
    go_from_s: (intersections, orientations) int32
        From when on the vehicles of a movement go; `NEVER_S` for red.
    queue_veh: (intersections, orientations) int32
    approaching_veh: (intersections, orientations) int32
        Vehicles that will join the queue within the next decision interval, at the last decision.
    front, back: (slots,) int32
        First and last vehicle of a queue.
    behind: (vehicles,) int32
        Next vehicle in the same list.
    ready_s: (slots,) float64
        When the headway behind the last vehicle that went is over.
    occupancy_veh: (links,) int32
    outside_front, outside_back: (links,) int32
        Vehicles that have departed and find no room on their entry link.
    due_front, due_back: (longest link in s + 1,) int32
        Vehicles on the move, by the time (modulo the length) at which they reach their link's end.
    visit: (vehicles,) int32
        Place of the vehicle's next slot in ``Trips.slots``.
    joined_s, waited_s, arrived_s: (vehicles,) int32
        When it joined its queue, total wait over finished visits, when it arrived (−1: not yet).
    waiting_steps: (intersections, orientations) int32
        Vehicle-steps waited since the last decision.
    arrived_at, queued_at: (horizon,) int32
        Vehicles arrived so far and vehicles waiting, after each step.
    """

    counters: LongArray
    phase: IntArray
    green_from_s: IntArray
    go_from_s: IntArray
    queue_veh: IntArray
    approaching_veh: IntArray
    front: IntArray
    back: IntArray
    behind: IntArray
    ready_s: FloatArray
    occupancy_veh: IntArray
    outside_front: IntArray
    outside_back: IntArray
    due_front: IntArray
    due_back: IntArray
    visit: IntArray
    joined_s: IntArray
    waited_s: IntArray
    arrived_s: IntArray
    waiting_steps: IntArray
    arrived_at: IntArray
    queued_at: IntArray


def initial_state(layout: Layout, trips: Trips, horizon_s: int) -> State:
    """Return the state of an empty network at time 0 (ours).

    Parameters
    ----------
    layout, trips
        What the state belongs to.
    horizon_s
        Steps of 1 s that can be recorded.
    """
    intersections, _, orientations = layout.served.shape
    slots, links, vehicles = layout.slot_link.size, layout.travel_s.size, trips.depart_s.size
    calendar = int(layout.travel_s.max(initial=0)) + 1

    def zeros(*shape: int) -> IntArray:
        return np.zeros(shape, np.int32)

    def empty_lists(count: int) -> IntArray:
        return np.full(count, NOBODY, np.int32)

    return State(
        counters=np.zeros(COUNTERS, np.int64),
        phase=np.full(intersections, -1, np.int32),
        green_from_s=zeros(intersections),
        go_from_s=np.full((intersections, orientations), NEVER_S, np.int32),
        queue_veh=zeros(intersections, orientations),
        approaching_veh=zeros(intersections, orientations),
        front=empty_lists(slots),
        back=empty_lists(slots),
        behind=empty_lists(vehicles),
        ready_s=np.zeros(slots),
        occupancy_veh=zeros(links),
        outside_front=empty_lists(links),
        outside_back=empty_lists(links),
        due_front=empty_lists(calendar),
        due_back=empty_lists(calendar),
        visit=trips.slot_offset[:-1].copy(),
        joined_s=zeros(vehicles),
        waited_s=zeros(vehicles),
        arrived_s=np.full(vehicles, -1, np.int32),
        waiting_steps=zeros(intersections, orientations),
        arrived_at=zeros(horizon_s),
        queued_at=zeros(horizon_s),
    )
