"""The queue simulator: point queues at the stop line, links that take time, 1 s steps."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from dmil.demand import Vehicles
from dmil.errors import InputError
from dmil.network import RoadNetwork
from dmil.scenarios import Scenario
from dmil.simulation.measures import Measures
from dmil.simulation.protocol import Observation
from dmil.simulation.queue import kernel
from dmil.simulation.queue.layout import build_layout, build_trips, rules_of
from dmil.simulation.queue.state import (
    ARRIVED,
    REFUSED,
    TIME,
    VISITS,
    WAITING_STEPS,
    IntArray,
    State,
    Trips,
    initial_state,
)


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
        self._rules = rules_of(scenario.timing)
        self._vehicles: Vehicles | None = None
        self._trips: Trips
        self._state: State | None = None

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

    def reset(self, vehicles: Vehicles) -> Observation:
        """Start a run with an empty network and the given journeys.

        Raises
        ------
        DemandError
            If a route goes over links that no movement joins.
        """
        if vehicles is not self._vehicles:
            self._trips = build_trips(self.network, self._layout, vehicles)
            self._vehicles = vehicles
        self._state = initial_state(self._layout, self._trips, self.horizon_s)
        return self._observe()

    def advance(self, phases: npt.NDArray[np.integer]) -> Observation:
        """Show the given phases for one decision interval (less where the horizon is nearer).

        Parameters
        ----------
        phases: (intersections,) int

        Raises
        ------
        InputError
            If there is not one existing phase per intersection, or no run is under way.
        """
        left_s = self.horizon_s - int(self.state.counters[TIME])
        if left_s <= 0:
            raise InputError(
                f"the run is over: its horizon is {self.horizon_s} s",
                where=self._scenario.name,
                mend="call reset",
            )
        requested = self._checked(phases)
        kernel.advance(
            self._layout,
            self._trips,
            self.state,
            requested,
            min(self.decision_interval_s, left_s),
            self._rules,
        )
        return self._observe()

    def measures(self) -> Measures:
        """Return what has been measured since the last reset."""
        state, trips = self.state, self._trips
        counters = state.counters
        time_s = int(counters[TIME])
        spawned = int(np.searchsorted(trips.depart_s, time_s))
        done = state.arrived_s[:spawned] >= 0
        end_s = np.where(done, state.arrived_s[:spawned], time_s)
        return Measures(
            time_s=time_s,
            spawned_veh=spawned,
            arrived_veh=int(counters[ARRIVED]),
            wait_veh_s=int(counters[WAITING_STEPS]),
            visits=int(counters[VISITS]),
            arrived_wait_veh_s=int(state.waited_s[:spawned][done].sum()),
            travel_veh_s=int((end_s - trips.depart_s[:spawned]).sum()),
            refused_changes=int(counters[REFUSED]),
            arrived_at=state.arrived_at[:time_s].copy(),
            queued_at=state.queued_at[:time_s].copy(),
        )

    def _observe(self) -> Observation:
        state = self.state
        time_s = int(state.counters[TIME])
        return Observation(
            queue_veh=state.queue_veh.copy(),
            approaching_veh=state.approaching_veh.copy(),
            phase=state.phase.copy(),
            phase_elapsed_s=np.maximum(time_s - state.green_from_s, 0),
            time_s=time_s,
        )

    def _checked(self, phases: npt.NDArray[np.integer]) -> IntArray:
        counts = self._layout.phase_count
        phases = np.asarray(phases)
        if phases.shape != counts.shape or phases.dtype.kind not in "iu":
            raise InputError(
                f"the controller chose phases of shape {phases.shape} and type {phases.dtype}",
                where=self._scenario.name,
                expected=f"one whole number for each of the {counts.size} intersections",
            )
        wrong = (phases < 0) | (phases >= counts)
        if wrong.any():
            i = int(wrong.argmax())
            raise InputError(
                f"the controller chose phase {phases[i]}",
                where=f"intersection '{self.network.intersections[i].id}'",
                expected=f"a phase from 0 to {counts[i] - 1}",
            )
        return np.ascontiguousarray(phases, np.int32)
