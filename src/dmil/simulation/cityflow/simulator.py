"""The CityFlow simulator: CityFlow's engine behind the protocol of all simulators."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from dmil.demand import Vehicles
from dmil.errors import InputError, SimulationError
from dmil.network import RoadNetwork
from dmil.network.cityflow import CityflowNetwork
from dmil.scenarios import Scenario, signal_times
from dmil.simulation.cityflow.files import write_configuration, write_flow, write_network
from dmil.simulation.cityflow.process import CityflowProcess, require_cityflow
from dmil.simulation.cityflow.signals import LightHeads
from dmil.simulation.measures import Measures
from dmil.simulation.protocol import Observation
from dmil.simulation.timing import PROGRAM, checked_phases, signals_of

FloatArray = npt.NDArray[np.float64]


class IntersectionTimes(NamedTuple):
    """Time at intersections as evaluation codes for CityFlow count it, in s.

    Attributes
    ----------
    last_minus_first_s: float
        Of every intersection and vehicle the last leaving of its entering lanes minus the first
        entering, summed over intersections, mean over vehicles ever on such lanes; a vehicle that
        has never left counts as leaving at the horizon.
    entering_lanes_s: float
        Time on these lanes, mean over the same vehicles.
    """

    last_minus_first_s: float
    entering_lanes_s: float


class CityflowSimulator:
    """Simulate a scenario from CityFlow's files in CityFlow, 1 s steps, a process for each run.

    Parameters
    ----------
    scenario
        What to simulate; its clearance and the kind of it are shown by light phases of the file, or
        by some that are added to a copy of it.
    lane_changes
        Whether vehicles change lanes: an option of CityFlow's engine, which benchmarks set.
    begins
        Whether all signals show their first phase before the run: then another one begins with a
        clearance. By default none is shown, and the first has no clearance.

    Raises
    ------
    InputError
        If CityFlow is not installed, or the scenario is not from CityFlow's files.

    Notes
    -----
    ``queue_veh`` are vehicles slower than 0.1 m/s, ``approaching_veh`` others nearer to the stop
    line than one decision interval in free flow, on the incoming link. ``time_loss_veh_s`` is
    counted against the limit of link and vehicle. All counts are made every second.
    """

    def __init__(
        self, scenario: Scenario, *, lane_changes: bool = True, begins: bool = False
    ) -> None:
        require_cityflow()
        if scenario.cityflow is None:
            raise InputError(
                "it is not from CityFlow's files",
                where=f"scenario {scenario.name}",
                expected="a road network and vehicles in CityFlow's format",
                mend="use cityflow:FOLDER or --roadnet and --flow, or another simulator",
            )
        self._scenario, self._files = scenario, scenario.cityflow
        self._lane_changes, self._begins = lane_changes, begins
        items = scenario.network.intersections
        self._signals = signals_of(scenario.network)
        programs = [item.program is not None for item in items]
        self._lowest = np.where(programs, PROGRAM, 0).astype(np.int32)
        self._shape = self._signals.unsignalled.shape
        self.lanes = [
            (number, lane)
            for number, link in enumerate(scenario.network.links)
            for lane in range(link.lanes)
        ]
        self._process: CityflowProcess | None = None
        self._heads: LightHeads
        self._vehicles: Vehicles
        self._seen: dict[str, Any] = {}
        self._arrived_at: list[int] = []
        self._queued_at: list[int] = []
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
    def lane_halting_veh(self) -> FloatArray:
        """Vehicles that halt on every lane of `lanes`, exits too: (lanes,) float64."""
        return np.array(self._seen.get("lane_halting", [0] * len(self.lanes)), np.float64)

    def reset(self, vehicles: Vehicles, seed: int = 0) -> Observation:
        """Start a run with an empty network and the given journeys.

        Raises
        ------
        SimulationError
            If CityFlow refuses the files; with its own message.
        """
        self.close()
        network, timing = self.network, self._scenario.timing
        process = self._process = CityflowProcess(self._scenario.name)
        all_stop = signal_times(timing, network).all_stop
        lights = write_network(self._files, network, all_stop, process.folder)
        top = write_flow(self._files, network, vehicles, process.folder)
        config = write_configuration(process.folder, seed=seed, lane_changes=self._lane_changes)
        self._heads = LightHeads(network, timing, lights, begins=self._begins)
        self._vehicles, self._time_s = vehicles, 0
        self._arrived_at, self._queued_at, self._seen = [], [], {}
        process.ask("start", (config, *self._plan(vehicles, top)))
        said = process.messages.split("\n")
        if any(said):  # the engine goes on without the file that it could not read
            self.close()
            problem = f"CityFlow failed: {' / '.join(filter(None, said))}"
            raise SimulationError(problem, where=self._scenario.name)
        process.ask("show", self._heads.first())
        return self._observe()

    def advance(self, phases: npt.NDArray[np.integer]) -> Observation:
        """Show the given phases for one decision interval (less where the horizon is nearer).

        Parameters
        ----------
        phases: (intersections,) int
            `PROGRAM` leaves an intersection to its own program.

        Raises
        ------
        InputError
            If there is not one existing phase per intersection, or no run is under way.
        SimulationError
            If CityFlow dies.
        """
        process, where = self._running(), self._scenario.name
        steps = min(self.decision_interval_s, self.horizon_s - self._time_s)
        if steps <= 0:
            raise InputError(
                f"the run is over: its horizon is {self.horizon_s} s",
                where=where,
                mend="call reset",
            )
        wanted = checked_phases(phases, self.network, self._signals, self._lowest, where=where)
        switches = self._heads.request(wanted, self._time_s)
        self._seen = process.ask("advance", steps, switches)
        self._arrived_at += self._seen["arrived_at"]
        self._queued_at += self._seen["queued_at"]
        self._time_s += steps
        return self._observe()

    def passed_veh(self) -> npt.NDArray[np.int64]:
        """Return how many vehicles have crossed each intersection's stop lines; see `Simulator`."""
        self._running()
        return np.array(self._seen.get("passed", [0] * self._shape[0]), np.int64)

    def measures(self) -> Measures:
        """Return what has been measured since the last reset."""
        times, seen = self.intersection_times(), self._seen
        arrived_at = np.array(self._arrived_at, np.int32)
        queued_at = np.array(self._queued_at, np.int32)
        return Measures(
            time_s=self._time_s,
            spawned_veh=int(np.searchsorted(self._vehicles.depart_s, self._time_s)),
            arrived_veh=int(arrived_at[-1]) if arrived_at.size else 0,
            wait_veh_s=float(queued_at.sum()),
            visits=seen.get("visits", 0),
            arrived_wait_veh_s=float(seen.get("arrived_wait_s", 0)),
            travel_veh_s=float(seen.get("travel_s", 0)),
            time_loss_veh_s=float(seen.get("loss_s", 0.0)),
            departure_delay_veh_s=float(seen.get("outside_s", 0)),
            stops=seen.get("stops", 0),
            overruled=self._heads.overruled,
            arrived_at=arrived_at,
            queued_at=queued_at,
            last_minus_first_s=times.last_minus_first_s,
            entering_lanes_s=times.entering_lanes_s,
        )

    def intersection_times(self) -> IntersectionTimes:
        """Return the time at intersections up to now, by the counts of published codes."""
        total_s, count = self._running().ask("times", self.horizon_s)
        spent_s = self._seen.get("entering_s", 0)
        return IntersectionTimes(total_s / max(count, 1), spent_s / max(count, 1))

    def close(self) -> None:
        """End the process of the run."""
        if self._process is not None:
            self._process.end()
            self._process = None

    def _running(self) -> CityflowProcess:
        if self._process is None:
            raise InputError("no run is under way", where=self._scenario.name, mend="call reset")
        return self._process

    def _plan(self, vehicles: Vehicles, top_m_per_s: list[float]) -> tuple[Any, ...]:
        """Return a `worker.Plan` without its configuration."""
        network, (_, most) = self.network, self._shape
        index, numbers = network.intersection_index, network.movement_index
        route, last = vehicles.route_links.tolist(), set((vehicles.route_offset[1:] - 1).tolist())
        place = [
            (-1, 0) if p in last else numbers.get((link, route[p + 1]), (-1, 0))
            for p, link in enumerate(route)
        ]
        length_m = [link.length_m for link in network.links]
        if isinstance(network, CityflowNetwork) and network.lane_length_m:
            length_m = list(network.lane_length_m)
        return (
            [(f"{network.links[link].id}_{lane}", link) for link, lane in self.lanes],
            [index.get(link.end, -1) for link in network.links],
            length_m,
            [link.speed_m_per_s for link in network.links],
            vehicles.depart_s.tolist(),
            top_m_per_s,
            vehicles.route_offset.tolist(),
            route,
            [i * most + j if i >= 0 else -1 for i, j in place],
            self._shape[0] * most,
            most,
            self.decision_interval_s,
        )

    def _observe(self) -> Observation:
        heads, empty = self._heads, [0] * (self._shape[0] * self._shape[1])

        def counted(name: str, kind: type[Any]) -> npt.NDArray[Any]:
            return np.array(self._seen.get(name, empty), kind).reshape(self._shape)

        return Observation(
            queue_veh=counted("queue", np.int32),
            approaching_veh=counted("near", np.int32),
            phase=heads.phase.copy(),
            phase_elapsed_s=np.maximum(self._time_s - heads.green_from_s, 0).astype(np.int32),
            time_s=self._time_s,
            waiting_veh=counted("waiting", np.float64),
        )
