"""How fast the queue simulator and the learners are, measured in turns in one process.

The network is the paper's 5×5 grid at the paper's load. The simulator runs under a fixed cycle, so
that no controller's time is in its figure; decisions are timed inside whole runs, learning
included, on the states that a learner really meets.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from statistics import median
from time import perf_counter

from dmil.arrays import IntArray
from dmil.benchmarks.figures import Decisions, SpeedFigure, beside, in_turns, run_s
from dmil.compilation import TypedOnce
from dmil.controllers import make_controller
from dmil.demand import Vehicles
from dmil.rewards import make_reward
from dmil.scenarios import Scenario, scenario
from dmil.seeding import stream
from dmil.simulation import QueueSimulator
from dmil.simulation.queue import kernel
from dmil.simulation.queue.layout import build_layout, build_trips
from dmil.simulation.queue.state import initial_state
from dmil.simulation.timing import rules_of
from dmil.training import run, vehicles_of_seed

HORIZON_S = 3600
ROUNDS = 7

KERNEL, SIMULATOR = "queue kernel, 5×5", "queue simulator with observations, 5×5"
SARSA, DUAL = "SARSA, exact", "dual memory, simple"
LEARNERS: dict[str, tuple[str, dict[str, object]]] = {
    SARSA: ("sarsa", {"embedding": "exact"}),
    "SARSA, simple": ("sarsa", {"embedding": "simple"}),
    DUAL: ("dual-memory", {"embedding": "simple"}),
    "dual memory, complex": ("dual-memory", {"embedding": "complex"}),
}


def throughput_figures(*, horizon_s: int = HORIZON_S, rounds: int = ROUNDS) -> list[SpeedFigure]:
    """Measure steps of the simulator and decisions of the learners; figures are medians."""
    made = scenario("grid:5x5", horizon_s=horizon_s)
    simulator, vehicles = QueueSimulator(made), vehicles_of_seed(made, 0)
    cycle, fixed = make_controller("fixed-cycle"), Decisions()
    reward = make_reward("diffusion")
    run(simulator, cycle, vehicles, reward, stream(0, "bench"), observers=[fixed])
    plan, vehicle_steps = fixed.phases, simulator.measures().travel_veh_s
    measured: dict[str, Callable[[], float]] = {
        KERNEL: lambda: horizon_s / _kernel_s(made, vehicles, plan),
        SIMULATOR: lambda: horizon_s / run_s(simulator, vehicles, plan),
    }
    for label in LEARNERS:
        measured[label] = partial(_decisions_per_s, label, simulator, vehicles)
    in_turns(measured, 1)  # compiled, and in the processor's caches
    values = in_turns(measured, rounds)
    steps = median(values[KERNEL])
    under_way = steps * (vehicle_steps / horizon_s)
    return [
        SpeedFigure(KERNEL, steps, "steps/s"),
        SpeedFigure(f"{KERNEL}, vehicles under way", under_way, "vehicle-steps/s"),
        beside(SIMULATOR, values[SIMULATOR], "steps/s", KERNEL, values[KERNEL]),
        SpeedFigure(SARSA, median(values[SARSA]), "decisions/s"),
        *(
            beside(name, values[name], "decisions/s", SARSA, values[SARSA])
            for name in LEARNERS
            if name != SARSA
        ),
    ]


def _kernel_s(made: Scenario, vehicles: Vehicles, plan: list[IntArray]) -> float:
    layout = build_layout(made)
    trips = build_trips(made, layout, vehicles)
    state = initial_state(layout, trips, made.horizon_s)
    rules = rules_of(made.timing, made.network)
    advance = TypedOnce(kernel.advance)
    start = perf_counter()
    for phases in plan:
        advance(layout, trips, state, phases, made.timing.decision_interval_s, rules)
    return perf_counter() - start


def _decisions_per_s(label: str, simulator: QueueSimulator, vehicles: Vehicles) -> float:
    name, options = LEARNERS[label]
    learner, reward = make_controller(name, options), make_reward("diffusion")
    found = run(simulator, learner, vehicles, reward, stream(0, "bench"))
    return found.decisions * len(simulator.network.intersections) / found.decide_s
