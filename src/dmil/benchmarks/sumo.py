"""The queue simulator beside SUMO, and the SUMO simulator beside a bare loop over SUMO.

Two networks: a busy grid of 4×4 intersections, three lanes each way, blocks of 800 m by 600 m (as
in the CityFlow data of Hangzhou), about 3,000 vehicles in an hour; and RESCO's cologne8. All run
the same vehicles under the same signals, one after the other: what slows the machine cancels.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import median
from time import perf_counter

import numpy as np

from dmil.arrays import IntArray
from dmil.benchmarks.figures import SpeedFigure
from dmil.demand import PoissonDemand, Vehicles
from dmil.network import Program, RoadNetwork, Stage, grid
from dmil.scenarios import QueueDynamics, Scenario, SignalTiming, scenario, signal_times
from dmil.simulation import QueueSimulator, Simulator, SumoSimulator
from dmil.simulation.sumo.files import options, run_files, write_routes
from dmil.simulation.sumo.signals import SignalHeads, walk_ends
from dmil.simulation.timing import PROGRAM, signals_of
from dmil.training import vehicles_of_seed

HORIZON_S = 3600
ROUNDS = 3
BLOCK_M = {"EW": 800.0, "NS": 600.0}
SPEED_M_PER_S = 11.11
VEHICLES_PER_H = 3000.0
GREEN_S, CLEARANCE_S = 27.0, 3.0
HOLD_S = 20
"""How long the controller that is no controller shows each phase."""


def sumo_figures(*, horizon_s: int = HORIZON_S, rounds: int = ROUNDS) -> list[SpeedFigure]:
    """Measure simulated seconds per second.

    Parameters
    ----------
    horizon_s
        Length of the measured runs.
    rounds
        How often each is measured; the figures are medians.

    Raises
    ------
    MissingExtraError
        If SUMO is not installed.
    """
    figures = []
    for name, made in (
        ("busy grid", busy_grid(horizon_s)),
        ("cologne8", scenario("resco/cologne8", horizon_s=horizon_s)),
    ):
        with tempfile.TemporaryDirectory(prefix="dmil-bench-") as folder:
            figures += _figures(name, made, Path(folder), rounds)
    return figures


def busy_grid(horizon_s: int = HORIZON_S) -> Scenario:
    """Return a grid of the size and shape of Hangzhou's, with a program and much demand.

    Parameters
    ----------
    horizon_s
        Length of a run.
    """
    network = _with_blocks_and_programs(grid(4, 4))
    per_node = VEHICLES_PER_H / 60 / len(network.fringe)
    return Scenario(
        name="busy grid",
        network=network,
        demand=PoissonDemand(dict.fromkeys(network.fringe, per_node)),
        timing=SignalTiming(clearance_s=int(CLEARANCE_S)),
        dynamics=QueueDynamics(saturation_flow_veh_per_s=0.5, storage=True),
        horizon_s=horizon_s,
    )


def _with_blocks_and_programs(network: RoadNetwork) -> RoadNetwork:
    """Give every link the length of its block, and every intersection a cycle of four phases."""
    east, north = BLOCK_M["EW"], BLOCK_M["NS"]
    here = network.position_m
    across = {link.id: here[link.start][0] != here[link.end][0] for link in network.links}
    stages = tuple(
        stage
        for phase in range(4)
        for stage in (
            Stage(GREEN_S, network.intersections[0].phases[phase]),
            Stage(CLEARANCE_S, frozenset(), clearance=True),
        )
    )
    unit = min(abs(here[link.start][0] - here[link.end][0]) or np.inf for link in network.links)
    return replace(
        network,
        name="busy grid",
        links=tuple(
            replace(link, length_m=east if across[link.id] else north, speed_m_per_s=SPEED_M_PER_S)
            for link in network.links
        ),
        intersections=tuple(replace(i, program=Program(stages)) for i in network.intersections),
        position_m={node: (x / unit * east, y / unit * north) for node, (x, y) in here.items()},
    )


@dataclass(frozen=True)
class _BareLoop:
    """SUMO with nothing around it.

    Parameters
    ----------
    made
        What to simulate.
    folder
        Where its files are.
    options
        Of ``sumo``.
    """

    made: Scenario
    folder: Path
    options: list[str]

    def seconds(self, plan: list[IntArray]) -> float:
        """Return how long the loop takes in which signals show what the plan asks for."""
        files = run_files(self.made, self.folder)
        network, timing = self.made.network, self.made.timing
        interval_s, switches = timing.decision_interval_s, []
        times = signal_times(timing, network)
        walks = walk_ends(network, files.signals, times)
        heads = SignalHeads(signals_of(network), files.signals, times, interval_s, walks)
        for k, phases in enumerate(plan):
            time_s = k * interval_s
            for second, name, state in heads.request(phases, time_s).switches:
                if time_s + second < self.made.horizon_s:
                    switches.append((time_s + second, name, state))
        done = subprocess.run(
            [sys.executable, "-P", str(Path(__file__).with_name("bare_sumo.py"))],
            input=json.dumps([self.options, self.made.horizon_s, switches]),
            capture_output=True,
            text=True,
            check=True,
        )
        return float(done.stdout.split()[-1])


def _figures(name: str, made: Scenario, folder: Path, rounds: int) -> list[SpeedFigure]:
    vehicles = vehicles_of_seed(made, 0)
    files = run_files(made, folder)
    write_routes(folder / "vehicles.rou.xml", vehicles, files)
    bare = _BareLoop(
        made,
        folder,
        options(files, folder / "vehicles.rou.xml", model="micro", seed=0, emissions=False),
    )
    own, changing = _own_programs(made), _changing_phases(made)
    queue, sumo = QueueSimulator(made), SumoSimulator(made)
    # Under its own program a network needs no decisions: SUMO steps through, and so may the queues.
    undisturbed = made.timing.model_copy(update={"decision_interval_s": made.horizon_s})
    whole = QueueSimulator(replace(made, timing=undisturbed))
    measured: dict[str, Callable[[], float]] = {
        "whole": lambda: _simulator_s(whole, vehicles, own[:1]),
        "queue": lambda: _simulator_s(queue, vehicles, own),
        "bare": lambda: bare.seconds(own),
        "bare, changing": lambda: bare.seconds(changing),
        "sumo, changing": lambda: _simulator_s(sumo, vehicles, changing),
    }
    speeds: dict[str, list[float]] = {key: [] for key in measured}
    measured["queue"]()  # compiled
    for _ in range(rounds):
        for key, measure in measured.items():
            speeds[key].append(made.horizon_s / measure())
    sumo.close()
    program, phases = f"{name}, its program", f"{name}, phases that change"
    return [
        _beside(f"queue simulator, {program}", f"bare SUMO, {program}", speeds, "whole", "bare"),
        _beside(
            f"queue simulator, {program}, seen every {made.timing.decision_interval_s} s",
            f"bare SUMO, {program}",
            speeds,
            "queue",
            "bare",
        ),
        SpeedFigure(f"bare SUMO, {program}", median(speeds["bare"]), "steps/s"),
        _beside(
            f"SUMO simulator, {phases}",
            f"bare SUMO, {phases}",
            speeds,
            "sumo, changing",
            "bare, changing",
        ),
        SpeedFigure(f"bare SUMO, {phases}", median(speeds["bare, changing"]), "steps/s"),
    ]


def _beside(
    name: str, other: str, speeds: dict[str, list[float]], mine: str, theirs: str
) -> SpeedFigure:
    ratios = [a / b for a, b in zip(speeds[mine], speeds[theirs], strict=True)]
    value = median(speeds[mine])
    return SpeedFigure(name, value, "steps/s", other, median(ratios), min(ratios), max(ratios))


def _own_programs(made: Scenario) -> list[IntArray]:
    intersections = len(made.network.intersections)
    decisions = -(-made.horizon_s // made.timing.decision_interval_s)
    return [np.full(intersections, PROGRAM, np.int32)] * decisions


def _changing_phases(made: Scenario) -> list[IntArray]:
    """Return phases in turn: every other decision changes all signals."""
    counts = np.array([len(item.phases) for item in made.network.intersections])
    interval_s = made.timing.decision_interval_s
    decisions = -(-made.horizon_s // interval_s)
    return [(k * interval_s // HOLD_S % counts).astype(np.int32) for k in range(decisions)]


def _simulator_s(simulator: Simulator, vehicles: Vehicles, plan: list[IntArray]) -> float:
    simulator.reset(vehicles)
    begin = perf_counter()
    for phases in plan:
        simulator.advance(phases)
    return perf_counter() - begin
