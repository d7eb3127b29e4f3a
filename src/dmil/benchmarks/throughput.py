"""How fast the queue simulator and the learners are, measured in turns in one process.

The network is the paper's 5×5 grid at the paper's load. The simulator runs under a fixed cycle, so
that no controller's time is in its figure; decisions are timed inside whole runs, learning
included, on the states that a learner really meets.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from statistics import median
from time import perf_counter

from dmil.arrays import FloatArray, IntArray
from dmil.benchmarks.figures import SpeedFigure
from dmil.compilation import TypedOnce
from dmil.controllers import Controller, RunContext, make_controller
from dmil.demand import Vehicles
from dmil.rewards import make_reward
from dmil.scenarios import Scenario, scenario
from dmil.seeding import stream
from dmil.simulation import Observation, QueueSimulator
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


@dataclass(slots=True)
class Timed:
    """A controller with a stopwatch around its decisions."""

    inner: Controller
    decisions: int = 0
    spent_s: float = 0.0

    def reset(self, context: RunContext) -> None:
        """Begin a run."""
        self.inner.reset(context)

    def decide(self, observation: Observation, reward: FloatArray | None) -> IntArray:
        """Decide, and note how long it took."""
        start = perf_counter()
        phases = self.inner.decide(observation, reward)
        self.spent_s += perf_counter() - start
        self.decisions += phases.size
        return phases


def throughput_figures(*, horizon_s: int = HORIZON_S, rounds: int = ROUNDS) -> list[SpeedFigure]:
    """Measure steps of the simulator and decisions of the learners.

    Parameters
    ----------
    horizon_s
        Length of the measured runs.
    rounds
        How often each is measured; the figures are medians.
    """
    made = scenario("grid:5x5", horizon_s=horizon_s)
    simulator, vehicles = QueueSimulator(made), vehicles_of_seed(made, 0)
    plan = _fixed_plan(made, simulator, vehicles)
    vehicle_steps = simulator.measures().travel_veh_s
    measured: dict[str, Callable[[], float]] = {
        KERNEL: lambda: horizon_s / _kernel_s(made, vehicles, plan),
        SIMULATOR: lambda: horizon_s / _simulator_s(simulator, vehicles, plan),
    }
    for label in LEARNERS:
        measured[label] = lambda label=label: _decisions_per_s(  # type: ignore[misc]
            label, simulator, vehicles
        )
    values: dict[str, list[float]] = {name: [] for name in measured}
    for measure in measured.values():
        measure()  # compiled, and in the processor's caches
    for _ in range(rounds):
        for name, measure in measured.items():
            values[name].append(measure())
    per_step = vehicle_steps / horizon_s
    return [
        SpeedFigure(KERNEL, median(values[KERNEL]), "steps/s"),
        SpeedFigure(
            f"{KERNEL}, vehicles under way", median(values[KERNEL]) * per_step, "vehicle-steps/s"
        ),
        _beside(SIMULATOR, KERNEL, values, "steps/s"),
        SpeedFigure(SARSA, median(values[SARSA]), "decisions/s"),
        *(_beside(name, SARSA, values, "decisions/s") for name in LEARNERS if name != SARSA),
    ]


def _beside(name: str, other: str, values: dict[str, list[float]], unit: str) -> SpeedFigure:
    """Compare with another figure of the same round, so that what slows the machine cancels."""
    ratios = [mine / theirs for mine, theirs in zip(values[name], values[other], strict=True)]
    return SpeedFigure(
        name, median(values[name]), unit, other, median(ratios), min(ratios), max(ratios)
    )


def _fixed_plan(made: Scenario, simulator: QueueSimulator, vehicles: Vehicles) -> list[IntArray]:
    """Return the phases of a fixed cycle for every decision of a run, and make that run."""
    cycle = make_controller("fixed-cycle")
    cycle.reset(RunContext(made.network, made.timing, stream(0, "bench")))
    observation = simulator.reset(vehicles)
    plan = []
    while observation.time_s < made.horizon_s:
        plan.append(cycle.decide(observation, None))
        observation = simulator.advance(plan[-1])
    return plan


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


def _simulator_s(simulator: QueueSimulator, vehicles: Vehicles, plan: list[IntArray]) -> float:
    simulator.reset(vehicles)
    start = perf_counter()
    for phases in plan:
        simulator.advance(phases)
    return perf_counter() - start


def _decisions_per_s(label: str, simulator: QueueSimulator, vehicles: Vehicles) -> float:
    name, options = LEARNERS[label]
    timed = Timed(make_controller(name, options))
    run(simulator, timed, vehicles, make_reward("diffusion"), stream(0, "bench"))
    return timed.decisions / timed.spent_s
