"""Arrays of the queue simulator: what the network is, who drives, how things stand.

Parameters (`Layout`), journeys (`Trips`) and state (`State`) are separate; the kernel moves the
state and never allocates. A *movement* has one entry in the state vector of its intersection; the
flat index ``intersection * width + number`` names it network-wide, ``width`` being the number of
movements of the widest intersection. Vehicles queue in lanes; a lane may serve several movements of
its link. A *leg* of a journey is the way to the next stop line, or from the last one to the end;
junctions where nobody waits lie within legs. Those where vehicles may have to wait without a signal
have the movements after those of intersections, and so further rows in the tables by intersection
and movement.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dmil.simulation.timing import NEVER_S, Programs, Signals

IntArray = npt.NDArray[np.int32]
LongArray = npt.NDArray[np.int64]
FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

NOBODY = -1
"""End of a linked list of vehicles."""

(
    TIME,
    NEXT_VEHICLE,
    ARRIVED,
    WAITING,
    WAITING_STEPS,
    VISITS,
    OUTSIDE,
    OVERRULED,
    OUTSIDE_STEPS,
    STOPS,
) = range(10)
"""Places of the scalars in ``State.counters``."""
COUNTERS = 10


class Layout(NamedTuple):
    """A road network and its traffic dynamics as flat arrays; never changes during a run.

    Attributes
    ----------
    signals: Signals
        Who may go in which phase.
    programs: Programs
        The intersections' own fixed-time programs.
    movement_link: (movements,) int32
        Link on which the queue of a movement stands; −1 where a movement is padding.
    lane_offset: (rows + 1,) int32
        Where the lanes of a row begin in ``lanes``: one row per movement, then one for every
        movement and vehicle class that queue in other lanes.
    lanes: (lanes of all rows,) int32
        Network-wide numbers of the lanes of each row.
    yield_offset: (movements + 1,) int32
        Where those begin in ``yields`` to whom a movement gives way.
    yields: (priorities,) int32
        Movements.
    turns: (priorities,) bool
        Whether the two take turns, first come, first served.
    after_s: (priorities,) float64
        How long after the last of the others a vehicle may go.
    headway_s: (movements,) float64
        Time between two vehicles of a movement on one lane at saturation flow, or that follow each
        other through one gap.
    gap_s: (movements,) float64
        Critical gap of who gives way without a signal: less until others come is too little.
    capacity_veh: (links,) int32
        Most vehicles on a link and on the links that only lead to it, moving and queued; a huge
        number where storage is unlimited.
    gap_wait_s: (1,) int32
        Longest wait of a vehicle that gives way.
    start_wave_veh_per_s: (1,) float64
        How many queued vehicles of a lane begin to move per second of green; 0: none that is seen.
    """

    signals: Signals
    programs: Programs
    movement_link: IntArray
    lane_offset: IntArray
    lanes: IntArray
    yield_offset: IntArray
    yields: IntArray
    turns: BoolArray
    after_s: FloatArray
    headway_s: FloatArray
    gap_s: FloatArray
    capacity_veh: IntArray
    gap_wait_s: IntArray
    start_wave_veh_per_s: FloatArray

    @property
    def lane_count(self) -> int:
        """Number of lanes in which vehicles queue."""
        return int(self.lanes.max(initial=-1)) + 1


class Trips(NamedTuple):
    """Every journey of a run, drawn before it starts.

    A vehicle's legs are one more than its movements: leg k of vehicle v, which leads to its
    movement k or to its goal, has the number ``movement_offset[v] + v + k``.

    Attributes
    ----------
    depart_s: (vehicles,) int32, non-decreasing
    movement_offset: (vehicles + 1,) int32
        Where the journey of a vehicle begins in ``movements``.
    movements: (intersection visits,) int32
        The movements that each vehicle queues in, one after the other.
    lane_row: (intersection visits,) int32
        Row of the layout's lanes among which it chooses there; the movement where the lanes are for
        all.
    leg_link: (legs,) int32
        Link whose room a vehicle takes up on a leg: the last one.
    leg_s: (legs,) int32
        Time that an undisturbed vehicle needs.
    """

    depart_s: IntArray
    movement_offset: IntArray
    movements: IntArray
    lane_row: IntArray
    leg_link: IntArray
    leg_s: IntArray


class State(NamedTuple):
    """Everything that changes; first-in-first-out queues are linked lists through ``behind``.

    Attributes
    ----------
    counters: (10,) int64
        Time in s, next vehicle to depart, vehicles arrived, vehicles waiting, vehicle-steps waited,
        intersection visits begun, vehicles that wait outside for room, requests overruled,
        vehicle-steps waited outside, stops.
    phase: (intersections,) int32
        Phase shown; −1 before the first decision and under the own program.
    green_from_s: (intersections,) int32
        When that phase turned green; in the future during a clearance.
    switch_s: (intersections,) int32
        When the own program switches next; `NEVER_S` if it is not in charge.
    go_from_s: (intersections, movements) int32
        From when on the vehicles of a movement go; `NEVER_S` for red.
    queue_veh: (intersections, movements) int32
        Here as in all tables of this shape more rows follow, of junctions without signals.
    standing_veh: (intersections, movements) int32
        Vehicles queued that no start wave has reached, at the last decision.
    approaching_veh: (intersections, movements) int32
        Vehicles that will join the queue within the next decision interval, at the last decision.
    front, back: (lanes,) int32
        First and last vehicle queued in a lane.
    lane_veh: (lanes,) int32
        Vehicles queued in a lane.
    soonest_s: (movements at junctions without signals,) int32
        When the next vehicle joins a queue there, as far as critical gaps matter; else `NEVER_S`.
    went_s: (movements at junctions without signals,) float64
        When the last vehicle went; long ago before the first.
    behind: (vehicles,) int32
        Next vehicle in the same list.
    ready_s: (lanes,) float64
        When the headway behind the last vehicle that went is over.
    wake_s: (lanes,) int32
        Before this second nothing moves in a lane: its first vehicle has red, or the headway before
        it is not over; `NEVER_S` without one.
    occupancy_veh: (links,) int32
    outside_front, outside_back: (links,) int32
        Vehicles that have departed and find no room on their first leg.
    due_front, due_back: (longest leg in s + 1,) int32
        Vehicles on the move, by the time (modulo the length) at which they reach their leg's end.
    visit: (vehicles,) int32
        Place of the vehicle's next movement in ``Trips.movements``.
    joined_s, waited_s, arrived_s: (vehicles,) int32
        When it joined its queue, total wait over finished visits, when it arrived (−1: not yet).
    waiting_steps: (intersections, movements) int32
        Vehicle-steps waited since the last decision.
    arrived_at, queued_at: (horizon,) int32
        Vehicles arrived so far and vehicles waiting, after each step.
    """

    counters: LongArray
    phase: IntArray
    green_from_s: IntArray
    switch_s: IntArray
    go_from_s: IntArray
    queue_veh: IntArray
    standing_veh: IntArray
    approaching_veh: IntArray
    front: IntArray
    back: IntArray
    lane_veh: IntArray
    soonest_s: IntArray
    went_s: FloatArray
    behind: IntArray
    ready_s: FloatArray
    wake_s: IntArray
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
    intersections, _, width = layout.signals.served.shape
    signalled, rows = intersections * width, layout.movement_link.size // width
    lanes, links = layout.lane_count, layout.capacity_veh.size
    vehicles = trips.depart_s.size
    calendar = int(trips.leg_s.max(initial=0)) + 1

    def zeros(*shape: int) -> IntArray:
        return np.zeros(shape, np.int32)

    def empty_lists(count: int) -> IntArray:
        return np.full(count, NOBODY, np.int32)

    go_from_s = zeros(rows, width)
    go_from_s[:intersections] = NEVER_S
    return State(
        counters=np.zeros(COUNTERS, np.int64),
        phase=np.full(intersections, -1, np.int32),
        green_from_s=zeros(intersections),
        switch_s=np.full(intersections, NEVER_S, np.int32),
        go_from_s=go_from_s,
        queue_veh=zeros(rows, width),
        standing_veh=zeros(rows, width),
        approaching_veh=zeros(rows, width),
        front=empty_lists(lanes),
        back=empty_lists(lanes),
        lane_veh=zeros(lanes),
        soonest_s=np.full(rows * width - signalled, NEVER_S, np.int32),
        went_s=np.full(rows * width - signalled, -np.inf),
        behind=empty_lists(vehicles),
        ready_s=np.zeros(lanes),
        wake_s=np.full(lanes, NEVER_S, np.int32),
        occupancy_veh=zeros(links),
        outside_front=empty_lists(links),
        outside_back=empty_lists(links),
        due_front=empty_lists(calendar),
        due_back=empty_lists(calendar),
        visit=trips.movement_offset[:-1].copy(),
        joined_s=zeros(vehicles),
        waited_s=zeros(vehicles),
        arrived_s=np.full(vehicles, -1, np.int32),
        waiting_steps=zeros(rows, width),
        arrived_at=zeros(horizon_s),
        queued_at=zeros(horizon_s),
    )
