"""What flows through every intersection during a run, and from when on one was locked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from dmil.controllers import Controller
from dmil.demand import Vehicles
from dmil.network import RoadNetwork
from dmil.simulation import Observation, Simulator
from dmil.simulation.sumo.approaches import build_ways
from dmil.training.observers import Observer, Phases

WINDOW_S = 300
"""At least so long an intersection stands still: longer than any cycle."""
SHARE = 0.2
"""It stands still if fewer cross it than this share of what another controller lets through."""


@dataclass(frozen=True, slots=True)
class Flow:
    """Queues and crossings of one run at every decision, the first at 0 s (ours).

    Attributes
    ----------
    time_s: (decisions + 1,) int32
        The last is the horizon.
    queue_veh: (decisions + 1, intersections) int32
        Vehicles that wait before each intersection.
    passed_veh: (decisions + 1, intersections) int32
        Vehicles that have crossed it since the run began.
    """

    time_s: npt.NDArray[np.int32]
    queue_veh: npt.NDArray[np.int32]
    passed_veh: npt.NDArray[np.int32]


@dataclass(frozen=True, slots=True)
class Lock:
    """An intersection that stood still until the end of a run (ours).

    Attributes
    ----------
    intersection: int
    since_s: int
        From this decision on, to within a minute.
    """

    intersection: int
    since_s: int


class FlowRecorder(Observer):
    """Notes what flows through the intersections during a run (ours)."""

    @property
    def flow(self) -> Flow:
        """What was noted in the last run."""
        times, queues, passed = zip(*self._noted, strict=True)
        return Flow(np.array(times, np.int32), np.stack(queues), np.stack(passed))

    def begin(self, simulator: Simulator, controller: Controller, seen: Observation) -> None:
        """Forget the run before."""
        self._simulator = simulator
        self._noted: list[tuple[int, npt.NDArray[np.int32], npt.NDArray[np.int32]]] = []
        self._note(seen)

    def advanced(self, phases: Phases, seen: Observation) -> None:
        """Note who waits, and who has crossed."""
        self._note(seen)

    def _note(self, seen: Observation) -> None:
        queue = seen.queue_veh.sum(axis=1, dtype=np.int32)
        passed = self._simulator.passed_veh().astype(np.int32)
        self._noted.append((seen.time_s, queue, passed))


def locks(flows: Sequence[Flow]) -> list[tuple[Lock, ...]]:
    """Tell which intersections locked in which runs (ours).

    An intersection is locked from some second on if vehicles wait before it at every decision until
    the end of the run, and nobody crosses it, or less than `SHARE` of those that cross it under
    another controller, both in the `WINDOW_S` that follow and until the end. Where there are only
    more vehicles than the signals can serve, queues stay as well, but people go on crossing.

    Parameters
    ----------
    flows
        One per controller, on the same vehicles.

    Returns
    -------
    list of tuples
        For every controller its locked intersections, the first to lock first.
    """
    time_s = flows[0].time_s
    # The last interval may be shorter: the first tells how long they are.
    steps = -(-WINDOW_S // int(time_s[1] - time_s[0]))
    if time_s.size <= steps:
        return [() for _ in flows]
    passed = np.stack([flow.passed_veh for flow in flows])
    starts = slice(0, time_s.size - steps)
    until_end, in_window = passed[:, -1:] - passed[:, starts], passed[:, steps:] - passed[:, starts]
    nobody_waits = np.stack([flow.queue_veh for flow in flows]) == 0
    # Where nobody waited for the last time; what begins after that has a queue to the end.
    emptied = np.cumsum(nobody_waits[:, ::-1], axis=1)[:, ::-1][:, starts]
    locked = (emptied == 0) & _stands_still(in_window) & _stands_still(until_end)
    found = []
    for each in locked:
        since = [
            Lock(int(i), int(time_s[np.argmax(each[:, i])])) for i in np.flatnonzero(each.any(0))
        ]
        found.append(tuple(sorted(since, key=lambda lock: (lock.since_s, lock.intersection))))
    return found


def locks_of(flow: Flow, network: RoadNetwork, vehicles: Vehicles) -> tuple[Lock, ...]:
    """Tell which intersections locked in a run that is compared with no other (ours).

    As `locks`, with those who would cross if nobody ever waited in place of another controller's.
    """
    return locks([flow, undelayed(network, vehicles, flow.time_s)])[0]


def undelayed(network: RoadNetwork, vehicles: Vehicles, time_s: npt.NDArray[np.int32]) -> Flow:
    """Return what would flow if all departed in time and drove at the limits (ours).

    ``time_s`` are the decisions to count at, ascending.
    """
    ways, sizes = build_ways(network, vehicles), np.diff(vehicles.route_offset)
    so_far_s = np.append(0.0, np.cumsum(network.free_flow_time_s[vehicles.route_links]))
    begun_s = vehicles.depart_s - so_far_s[vehicles.route_offset[:-1]]
    crossed_s = np.repeat(begun_s, sizes) + so_far_s[1:]
    movements = max(len(item.movements) for item in network.intersections)
    at = np.searchsorted(time_s, crossed_s[ways.own])
    crossing = np.zeros((time_s.size + 1, len(network.intersections)), np.int32)
    np.add.at(crossing, (at, ways.movement[ways.own] // movements), 1)
    passed = np.cumsum(crossing[:-1], axis=0, dtype=np.int32)
    return Flow(time_s, np.zeros_like(passed), passed)


def _stands_still(crossed: npt.NDArray[np.int32]) -> npt.NDArray[np.bool_]:
    """Compare (controllers, stretches, intersections) crossings over the controllers."""
    still: npt.NDArray[np.bool_] = (crossed == 0) | (crossed < SHARE * crossed.max(axis=0))
    return still
