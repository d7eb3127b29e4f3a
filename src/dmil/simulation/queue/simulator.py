"""The queue simulator: point queues at the stop line, links that take time, 1 s steps."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from dmil.compilation import TypedOnce
from dmil.demand import Vehicles
from dmil.errors import InputError
from dmil.network import RoadNetwork
from dmil.scenarios import Scenario
from dmil.simulation.disturbances import first_movement
from dmil.simulation.measures import Measures
from dmil.simulation.protocol import Observation
from dmil.simulation.queue import kernel
from dmil.simulation.queue.counts import observe
from dmil.simulation.queue.layout import build_layout, build_trips
from dmil.simulation.queue.state import (
    ARRIVED,
    OUTSIDE_STEPS,
    OVERRULED,
    STOPS,
    TIME,
    VISITS,
    WAITING,
    WAITING_STEPS,
    FloatArray,
    IntArray,
    State,
    Trips,
    initial_state,
)
from dmil.simulation.timing import PROGRAM, checked_phases, rules_of

INT32 = np.dtype(np.int32)


class QueueSimulator:
    """Simulate a scenario with first-in-first-out point queues (specification, §2).

    Parameters
    ----------
    scenario
        Network, signal timing, traffic dynamics and horizon.
    """

    def __init__(self, scenario: Scenario) -> None:
        self._scenario = scenario
        self._layout = build_layout(scenario)
        has_program = np.diff(self._layout.programs.offset) > 0
        self._lowest = np.where(has_program, PROGRAM, 0).astype(np.int32)
        self._rules = rules_of(scenario.timing, scenario.network)
        intersections, _, movements = self._layout.signals.served.shape
        self._shapes = (2, intersections, movements), (2, intersections), (intersections, movements)
        self._vehicles: Vehicles | None = None
        self._trips: Trips
        self._free_leg_s: npt.NDArray[np.int32]
        self._state: State | None = None
        self._advance: TypedOnce
        self._time_s = 0

    @property
    def scenario(self) -> Scenario:
        """What is simulated."""
        return self._scenario

    @property
    def network(self) -> RoadNetwork:
        """The road network that is simulated."""
        return self._scenario.network

    @property
    def decision_interval_s(self) -> int:
        """Time between two decisions, in s."""
        return self._scenario.timing.decision_interval_s

    @property
    def horizon_s(self) -> int:
        """Time at which a run ends, in s."""
        return self._scenario.horizon_s

    @property
    def state(self) -> State:
        """The arrays of the run under way, for inspection.

        Raises
        ------
        InputError
            If there has been no reset yet.
        """
        if self._state is None:
            raise InputError("no run has begun", where=self._scenario.name, mend="call reset first")
        return self._state

    def reset(self, vehicles: Vehicles, seed: int = 0) -> Observation:
        """Start a run with an empty network and the given journeys; nothing is drawn from the seed.

        Raises
        ------
        DemandError
            If a route goes over links that no movement joins.
        """
        if vehicles is not self._vehicles:
            self._trips = build_trips(self._scenario, self._layout, vehicles)
            if self._scenario.link_time_s is not None:
                free_flow = replace(self._scenario, link_time_s=self._scenario.link_free_s)
                self._free_leg_s = build_trips(free_flow, self._layout, vehicles).leg_s
            self._vehicles = vehicles
            self._advance = TypedOnce(kernel.advance_and_observe)
        self._state = initial_state(self._layout, self._trips, self.horizon_s)
        self._time_s = 0
        seen = self._unseen()
        observe(self._state, 0, *seen)
        return self._observe(*seen)

    def advance(self, phases: npt.NDArray[np.integer]) -> Observation:
        """Show the given phases for one decision interval (less where the horizon is nearer).

        Parameters
        ----------
        phases: (intersections,) int
            `PROGRAM` leaves an intersection to its own fixed-time program.

        Raises
        ------
        InputError
            If there is not one existing phase per intersection, or no run is under way.
        """
        scenario, state = self._scenario, self.state
        left_s = scenario.horizon_s - self._time_s
        if left_s <= 0:
            raise InputError(
                f"the run is over: its horizon is {self.horizon_s} s",
                where=scenario.name,
                mend="call reset",
            )
        steps = min(scenario.timing.decision_interval_s, left_s)
        requested, lowest, seen = self._whole_numbers(phases), self._lowest, self._unseen()
        rules = self._rules
        if not self._advance(
            self._layout, self._trips, state, requested, lowest, steps, rules, *seen
        ):
            self._checked(phases)  # says which is wrong
        self._time_s += steps
        return self._observe(*seen)

    def close_lane(self, link: str, lane: int, until_s: int) -> None:
        """Let no vehicle leave a lane from now until a time; see `ClosesLanes`.

        Vehicles go on queueing in it, where it is the shortest of theirs, and are counted. A closed
        lane is one whose next headway is over at that time, so that closing costs the kernel
        nothing. With a start wave those of them that would move by now do not count as standing.
        """
        i, j = first_movement(self.network, link, lane)
        layout, ready_s = self._layout, self.state.ready_s
        first = layout.lane_offset[i * layout.signals.served.shape[2] + j]
        number = layout.lanes[first + self.network.intersections[i].movements[j].lanes.index(lane)]
        ready_s[number] = max(ready_s[number], float(until_s))

    def passed_veh(self) -> npt.NDArray[np.int64]:
        """Return how many vehicles have left the queues of every intersection; see `Simulator`."""
        trips = self._trips
        place = np.arange(trips.movements.size)
        gone = place < np.repeat(self.state.visit, np.diff(trips.movement_offset))
        intersections, _, movements = self._layout.signals.served.shape
        # Movements at junctions without signals follow those of the intersections.
        return np.bincount(trips.movements[gone] // movements, minlength=intersections)[
            :intersections
        ]

    def measures(self) -> Measures:
        """Return what has been measured since the last reset."""
        state, trips = self.state, self._trips
        counters = state.counters
        time_s = int(counters[TIME])
        spawned = int(np.searchsorted(trips.depart_s, time_s))
        done = state.arrived_s[:spawned] >= 0
        end_s = np.where(done, state.arrived_s[:spawned], time_s)
        wait_veh_s, outside_veh_s = int(counters[WAITING_STEPS]), int(counters[OUTSIDE_STEPS])
        return Measures(
            time_s=time_s,
            spawned_veh=spawned,
            arrived_veh=int(counters[ARRIVED]),
            wait_veh_s=wait_veh_s,
            visits=int(counters[VISITS]),
            arrived_wait_veh_s=int(state.waited_s[:spawned][done].sum()),
            travel_veh_s=int((end_s - trips.depart_s[:spawned]).sum()),
            time_loss_veh_s=wait_veh_s - outside_veh_s + self._slow_veh_s(),
            departure_delay_veh_s=outside_veh_s,
            stops=int(counters[STOPS] + counters[WAITING]),
            overruled=int(counters[OVERRULED]),
            arrived_at=state.arrived_at[:time_s].copy(),
            queued_at=state.queued_at[:time_s].copy(),
        )

    def _slow_veh_s(self) -> float:
        """Return the time lost on links whose measured times are above those of free flow.

        A leg counts when the intersection at its end has been crossed.
        """
        if self._scenario.link_time_s is None:
            return 0.0
        state, trips = self.state, self._trips
        first = trips.movement_offset[:-1] + np.arange(len(trips.depart_s))
        crossed = state.visit + np.arange(len(trips.depart_s)) + (state.arrived_s >= 0)
        slow_s = np.concatenate([[0.0], np.cumsum(trips.leg_s - self._free_leg_s)])
        return float((slow_s[crossed] - slow_s[first]).sum())

    def _unseen(self) -> tuple[IntArray, IntArray, FloatArray]:
        """Return arrays for what controllers see; see `observe`."""
        counts, shown, waiting_veh = self._shapes
        return np.empty(counts, INT32), np.empty(shown, INT32), np.empty(waiting_veh)

    def _observe(self, counts: IntArray, shown: IntArray, waiting_veh: FloatArray) -> Observation:
        return Observation(counts[0], counts[1], shown[0], shown[1], self._time_s, waiting_veh)

    def _whole_numbers(self, phases: npt.NDArray[Any]) -> IntArray:
        """Return phases as kernels take them; whether they exist is left to the kernel."""
        fits = type(phases) is np.ndarray and phases.dtype is INT32 and phases.flags.c_contiguous
        return phases if fits and phases.shape == self._lowest.shape else self._checked(phases)

    def _checked(self, phases: npt.NDArray[np.integer]) -> npt.NDArray[np.int32]:
        signals, where = self._layout.signals, self._scenario.name
        return checked_phases(phases, self.network, signals, self._lowest, where=where)
