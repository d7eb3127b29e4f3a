"""The paper's training phase, training over several episodes, and runs that compare controllers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from dmil.controllers import Controller, Prior
from dmil.controllers.tabular.sarsa import SarsaController
from dmil.controllers.tabular.settings import SarsaSettings
from dmil.demand import Vehicles
from dmil.rewards import Reward
from dmil.scenarios import Scenario
from dmil.seeding import simulator_seed, stream
from dmil.simulation import QueueSimulator, Simulator
from dmil.training.loop import Run, run
from dmil.training.observers import MemoryRecorder, Observer

DUMMY_EPSILON = 0.1
"""ε_train of the dummy agent (paper, §VI)."""


def train_prior(
    scenario: Scenario,
    reward: Reward,
    seed: int,
    *,
    epsilon: float = DUMMY_EPSILON,
    announced: bool = False,
    simulator: Simulator | None = None,
) -> Prior:
    """Train the dummy agent: exact SARSA, one table for all agents of a shape (paper, §VI-B).

    Demand and exploration come from streams of the seed that no test uses.

    Parameters
    ----------
    scenario
        Where, and for how long (T_train is its horizon).
    reward
        The reward that the trained agents will get.
    seed
        Master seed of the study's run.
    epsilon
        Chance of a random action.
    announced
        Whether states count what neighbours announce, as those of the agents that start from it.
    simulator
        Simulator of the scenario, to reuse one.
    """
    simulator = simulator or QueueSimulator(scenario)
    dummy = SarsaController(
        SarsaSettings(embedding="exact", epsilon=epsilon, shared=True, announced=announced)
    )
    vehicles = scenario.demand.vehicles(
        scenario.network, simulator.horizon_s, stream(seed, "training", "demand")
    )
    exploration = stream(seed, "training", "exploration")
    chance = simulator_seed(seed, "training")
    run(simulator, dummy, vehicles, reward, exploration, chance)
    return Prior(dummy.table)


def train(
    scenario: Scenario,
    controller: Controller,
    reward: Reward,
    seed: int,
    *,
    episodes: range,
    observers: Sequence[Observer] = (),
    simulator: Simulator | None = None,
) -> list[Run]:
    """Let a controller learn over some episodes, each with demand of its own (ours).

    An episode's streams depend on the seed and its number alone, so training that goes on from a
    saved policy draws what uninterrupted training would have drawn.

    Parameters
    ----------
    scenario
        Where.
    controller
        Keeps its memory from episode to episode.
    reward
        What it gets.
    seed
        Master seed.
    episodes
        Numbers of the episodes, such as ``range(10)``.
    observers
        Who watches the episodes, and hears the end of each.
    simulator
        Simulator of the scenario; the queue simulator by default.
    """
    simulator = simulator or QueueSimulator(scenario)
    results = []
    for episode in episodes:
        vehicles = scenario.demand.vehicles(
            scenario.network,
            simulator.horizon_s,
            stream(seed, "training", "episode", episode, "demand"),
        )
        exploration = stream(seed, "training", "episode", episode, "exploration")
        chance = simulator_seed(seed, "training", "episode", episode)
        result = run(
            simulator, controller, vehicles, reward, exploration, chance, observers=observers
        )
        results.append(result)
        for each in observers:
            each.episode_ended(episode, result)
    return results


def vehicles_of_seed(scenario: Scenario, seed: int) -> Vehicles:
    """Return the vehicles of a test seed, the same for every controller (specification, §1)."""
    return scenario.demand.vehicles(scenario.network, scenario.horizon_s, stream(seed, "demand"))


def evaluate(
    simulator: Simulator,
    controller: Controller,
    vehicles: Vehicles,
    reward: Reward,
    seed: int,
    *,
    observers: Sequence[Observer] = (),
) -> Run:
    """Run a controller in the testing phase of a seed, its memory watched (paper, §VI-B).

    Parameters
    ----------
    simulator
        Simulator of the scenario.
    controller
        The one to test; it learns on if its settings say so.
    vehicles
        See `vehicles_of_seed`.
    reward
        What a learner gets.
    seed
        Master seed; exploration and the simulator have streams of their own, the same for every
        controller.
    observers
        Who watches besides.
    """
    recorder, exploration = MemoryRecorder(), stream(seed, "exploration")
    result = run(
        simulator,
        controller,
        vehicles,
        reward,
        exploration,
        simulator_seed(seed),
        observers=(recorder, *observers),
    )
    return replace(
        result,
        time_s=(*recorder.time_s, *result.time_s),
        memory=(*recorder.memory, *result.memory),
    )
