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
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from dmil.arrays import IntArray
from dmil.benchmarks.figures import SpeedFigure, beside, in_turns, pair, run_s
from dmil.demand import PoissonDemand
from dmil.network import Program, RoadNetwork, Stage, grid
from dmil.scenarios import QueueDynamics, Scenario, SignalTiming, scenario, signal_times
from dmil.simulation import QueueSimulator, SumoSimulator
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
    """Measure simulated seconds per second; figures are medians. It needs the extra sumo."""
    figures = []
    for name, made in (
        ("busy grid", busy_grid(horizon_s)),
        ("cologne8", scenario("resco/cologne8", horizon_s=horizon_s)),
    ):
        with tempfile.TemporaryDirectory(prefix="dmil-bench-") as folder:
            figures += _figures(name, made, Path(folder), rounds)
    return figures


def busy_grid(horizon_s: int = HORIZON_S) -> Scenario:
    """Return a grid of the size and shape of Hangzhou's, with a program and much demand."""
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


def _bare_s(made: Scenario, folder: Path, options: list[str], plan: list[IntArray]) -> float:
    """Return how long SUMO takes with nothing around it, its signals as the plan asks for."""
    files, network = run_files(made, folder), made.network
    interval_s, switches = made.timing.decision_interval_s, []
    times = signal_times(made.timing, network)
    walks = walk_ends(network, files.signals, times)
    heads = SignalHeads(signals_of(network), files.signals, times, interval_s, walks)
    for k, phases in enumerate(plan):
        time_s = k * interval_s
        for second, name, state in heads.request(phases, time_s).switches:
            if time_s + second < made.horizon_s:
                switches.append((time_s + second, name, state))
    done = subprocess.run(
        [sys.executable, "-P", str(Path(__file__).with_name("bare_sumo.py"))],
        input=json.dumps([options, made.horizon_s, switches]),
        capture_output=True,
        text=True,
        check=True,
    )
    return float(done.stdout.split()[-1])


def _figures(name: str, made: Scenario, folder: Path, rounds: int) -> list[SpeedFigure]:
    vehicles = vehicles_of_seed(made, 0)
    files = run_files(made, folder)
    routes = folder / "vehicles.rou.xml"
    write_routes(routes, vehicles, files)
    bare = partial(
        _bare_s, made, folder, options(files, routes, model="micro", seed=0, emissions=False)
    )
    own, changing = _own_programs(made), _changing_phases(made)
    queue, sumo = QueueSimulator(made), SumoSimulator(made)
    # Under its own program a network needs no decisions: SUMO steps through, and so may the queues.
    undisturbed = made.timing.model_copy(update={"decision_interval_s": made.horizon_s})
    whole = QueueSimulator(replace(made, timing=undisturbed))
    measured: dict[str, Callable[[], float]] = {
        "whole": lambda: made.horizon_s / run_s(whole, vehicles, own[:1]),
        "queue": lambda: made.horizon_s / run_s(queue, vehicles, own),
        "bare": lambda: made.horizon_s / bare(own),
        "bare, changing": lambda: made.horizon_s / bare(changing),
        "sumo, changing": lambda: made.horizon_s / run_s(sumo, vehicles, changing),
    }
    measured["queue"]()  # compiled
    speeds = in_turns(measured, rounds)
    sumo.close()
    program, phases, unit = f"{name}, its program", f"{name}, phases that change", "steps/s"
    own_bare = f"bare SUMO, {program}", speeds["bare"]
    changing_bare = f"bare SUMO, {phases}", speeds["bare, changing"]
    seen = f"seen every {made.timing.decision_interval_s} s"
    return [
        beside(f"queue simulator, {program}", speeds["whole"], unit, *own_bare),
        *pair(f"queue simulator, {program}, {seen}", speeds["queue"], unit, *own_bare),
        *pair(f"SUMO simulator, {phases}", speeds["sumo, changing"], unit, *changing_bare),
    ]


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
