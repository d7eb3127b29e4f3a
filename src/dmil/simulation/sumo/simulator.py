"""The SUMO simulator: Eclipse SUMO behind the protocol of all simulators."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from dmil.demand import Vehicles
from dmil.errors import InputError
from dmil.network import RoadNetwork
from dmil.network.sumo import sumo_lane
from dmil.scenarios import Scenario, signal_times
from dmil.simulation.disturbances import first_movement
from dmil.simulation.measures import Measures
from dmil.simulation.protocol import Observation
from dmil.simulation.sumo.accounts import Accounts
from dmil.simulation.sumo.approaches import (
    Crossings,
    FloatArray,
    RouteGeometry,
    build_ways,
    count_vehicles,
    rerouted,
)
from dmil.simulation.sumo.files import Model, RunFiles, options, run_files, together, write_routes
from dmil.simulation.sumo.process import SumoProcess, require_sumo
from dmil.simulation.sumo.signals import SignalHeads, walk_ends
from dmil.simulation.timing import ACTUATED, checked_phases, signals_of

NO_RUN = -1
ROUTES, OUTPUT = "vehicles.rou.xml", "output.xml"
DETECTION_M = 200.0
"""How far detectors see beyond an incoming link that is shorter (RESCO's range)."""


class SumoSimulator:
    """Simulate a scenario in SUMO, 1 s steps, in a process of its own.

    The process is kept for later runs and ends with the simulator. A network that does not come
    from SUMO is written for it, see `dmil.network.sumo.write_sumo_network`.

    Parameters
    ----------
    scenario
        Network, signal timing, horizon, and SUMO's files if it has any.
    model
        SUMO's microscopic or its mesoscopic model.
    emissions
        Whether to run SUMO's emission model too.
    detection_m
        How far from a stop line vehicles are counted where the incoming link is shorter.
    further_options
        Gives more options of ``sumo`` for a run, such as `SurveyFiles.options`.

    Raises
    ------
    MissingExtraError
        If SUMO is not installed.
    NetworkError
        If the network cannot be written for SUMO.

    Notes
    -----
    ``queue_veh`` are vehicles slower than 0.1 m/s, ``approaching_veh`` others nearer than one
    decision interval in free flow, on the incoming link or within ``detection_m``.
    Who stands at a stop is neither. Vehicles that SUMO drives beside those of the run, such as
    bicycles, are traffic that others meet, and not counted.
    Where a vehicle goes is what SUMO says, also if SUMO has sent it elsewhere during the run.
    ``visits`` counts the links before stop lines that vehicles have come to. Emissions
    are those of vehicles that have ended their trip, so until the horizon only of those that have
    arrived; and so is the time loss of the mesoscopic model. Of ``queued_at``, the vehicles outside
    are exact, and those that halt at every decision; between two decisions these lie on a straight
    line. ``wait_veh_s`` is the time that SUMO itself counts for every vehicle.
    """

    def __init__(
        self,
        scenario: Scenario,
        *,
        model: Model = "micro",
        emissions: bool = False,
        detection_m: float = DETECTION_M,
        further_options: Callable[[RunFiles], Sequence[str]] | None = None,
    ) -> None:
        require_sumo()
        self._further_options = further_options
        self._scenario, self._model = scenario, model
        self._emissions, self._detection_m = emissions, detection_m
        self._signals = signals_of(scenario.network)
        programs = np.array(
            [bool(item.program or item.own_control) for item in scenario.network.intersections]
        )
        self._lowest = np.where(programs, ACTUATED, 0).astype(np.int32)
        self._process: SumoProcess | None = None
        self._files: RunFiles
        self._vehicles: Vehicles | None = None
        self._ways: RouteGeometry
        self._ways_of_files: RouteGeometry
        self._heads: SignalHeads
        self._accounts: Accounts
        self._crossings: Crossings
        self._seen: FloatArray
        self._under_way: FloatArray
        self._queue_veh = np.zeros(self._signals.unsignalled.shape, np.int32)
        self._time_s = NO_RUN

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
    def warnings(self) -> tuple[str, ...]:
        """What SUMO has warned of in the run under way."""
        text = self._process.messages if self._process and self._process.end.alive else ""
        return tuple(line for line in text.splitlines() if line.startswith("Warning:"))

    def reset(self, vehicles: Vehicles, seed: int = 0) -> Observation:
        """Start a run with an empty network and the given journeys.

        Raises
        ------
        SimulationError
            If SUMO refuses the network; with its own message.
        """
        self._time_s = NO_RUN
        process = self._ready_process()
        if vehicles is not self._vehicles:
            self._vehicles = None
            self._ways_of_files = build_ways(self.network, vehicles)
            write_routes(process.folder / ROUTES, vehicles, self._files)
            self._vehicles = vehicles
        self._ways = self._ways_of_files
        process.forget_messages()
        self._queue_veh = np.zeros_like(self._queue_veh)
        output = process.folder / OUTPUT
        output.unlink(missing_ok=True)
        chosen = options(
            self._files,
            process.folder / ROUTES,
            model=self._model,
            seed=seed,
            emissions=self._emissions,
        )
        if self._further_options is not None:
            chosen = together(chosen, self._further_options(self._files))
        stops = any("<stop" in inner for inner in self._files.beside.inner_xml)
        process.ask("start", [*chosen, "--tripinfo-output", str(output)], stops)
        times = signal_times(self._scenario.timing, self.network)
        self._heads = SignalHeads(
            self._signals,
            self._files.signals,
            times,
            self.decision_interval_s,
            walk_ends(self.network, self._files.signals, times),
        )
        self._accounts = Accounts(output, vehicles, self._files.begin_s)
        self._crossings = Crossings(len(vehicles))
        self._seen = np.frombuffer(b"").reshape(5, 0)
        self._time_s = 0
        return self._observe()

    def advance(self, phases: npt.NDArray[np.integer]) -> Observation:
        """Show the given phases for one decision interval (less where the horizon is nearer).

        Parameters
        ----------
        phases: (intersections,) int
            `PROGRAM` leaves an intersection to its own program, `ACTUATED` to SUMO's actuated
            control of that.

        Raises
        ------
        InputError
            If there is not one existing phase per intersection, or no run is under way.
        SimulationError
            If SUMO refuses a journey or dies; with its own message.
        """
        process = self._running()
        steps = min(self.decision_interval_s, self.horizon_s - self._time_s)
        if steps <= 0:
            raise InputError(
                f"the run is over: its horizon is {self.horizon_s} s",
                where=self._scenario.name,
                mend="call reset",
            )
        where = self._scenario.name
        wanted = checked_phases(phases, self.network, self._signals, self._lowest, where=where)
        orders = self._heads.request(wanted, self._time_s)
        seen, elsewhere = process.ask("advance", steps, orders.programs, orders.switches)
        self._seen = np.frombuffer(seen).reshape(5, -1)
        if elsewhere:
            self._ways = rerouted(self.network, self._ways, elsewhere)
        self._time_s += steps
        if self._time_s == self.horizon_s:
            self._under_way = self._account()
            process.ask("close")  # only then SUMO writes about vehicles that have not arrived
        return self._observe()

    def close_lane(self, link: str, lane: int, until_s: int) -> None:
        """Let no vehicle leave a lane from now until a time; see `ClosesLanes`.

        The first vehicle is held at the stop line, as one that broke down; those behind it change
        lanes where they can. (SUMO stops a run in which a route needs a lane that is forbidden, and
        finds no time lost in one that nobody may drive fast in.)

        Raises
        ------
        InputError
            If no movement of an intersection has such a lane, no run is under way, or the model is
            mesoscopic.
        """
        if self._model == "meso":
            raise InputError(
                "the mesoscopic model holds no single vehicle",
                where=self._scenario.name,
                expected="the microscopic model where lanes are closed",
            )
        process, made = self._running(), self._scenario
        i, j = first_movement(self.network, link, lane)
        movement = self.network.intersections[i].movements[j]
        name = f"{link}_{lane}" if made.sumo else sumo_lane(self.network, movement, lane)
        process.ask("close_lane", name, self._files.begin_s + until_s)

    def passed_veh(self) -> npt.NDArray[np.int64]:
        """Return how many vehicles have crossed each intersection's stop lines; see `Simulator`."""
        self._running()
        intersections, _, movements = self._signals.served.shape
        return self._crossings.counted(self._ways, intersections, movements)

    def measures(self) -> Measures:
        """Return what has been measured since the last reset.

        Raises
        ------
        InputError
            If no run has begun.
        """
        self._running()
        ended = self._time_s == self.horizon_s
        return self._accounts.measures(
            self._time_s,
            self._ways,
            self._seen,
            self._under_way if ended else self._account(),
            ended=ended,
            overruled=self._heads.overruled,
            emissions=self._emissions,
        )

    def close(self) -> None:
        """End the process of SUMO; the next reset begins another."""
        self._time_s = NO_RUN
        if self._process is not None:
            self._process.end()
            self._process = None

    def _ready_process(self) -> SumoProcess:
        """Return a process without a run: a new one if there is none that answers."""
        if self._process is not None and self._process.alive:
            self._process.ask("close")
            return self._process
        self._process = self._vehicles = None
        process = SumoProcess(self._scenario.name)
        self._files = run_files(self._scenario, process.folder)
        self._process = process
        return process

    def _running(self) -> SumoProcess:
        if self._process is None or not self._process.end.alive or self._time_s == NO_RUN:
            raise InputError("no run is under way", where=self._scenario.name, mend="call reset")
        return self._process

    def _account(self) -> FloatArray:
        """Ask about the vehicles in the network, see `Accounts.measures`."""
        return np.frombuffer(self._running().ask("account")).reshape(-1, 5)

    def _observe(self) -> Observation:
        heads = self._heads
        self._crossings.see(self._ways, self._seen)
        queue, approaching, halting = count_vehicles(
            self._ways,
            self._seen,
            (self._signals.served.shape[0], self._signals.served.shape[2]),
            within_s=self.decision_interval_s,
            detection_m=self._detection_m,
        )
        self._accounts.note_halting(self._time_s, halting)
        before, self._queue_veh = self._queue_veh, queue
        return Observation(
            queue_veh=queue,
            approaching_veh=approaching,
            phase=heads.phase.copy(),
            phase_elapsed_s=np.maximum(self._time_s - heads.green_from_s, 0),
            time_s=self._time_s,
            waiting_veh=(before + queue) / 2,
        )
