"""The paper's training phase, and training of a policy over several episodes."""

from __future__ import annotations

from collections.abc import Sequence

from dmil.controllers import Controller, Prior
from dmil.controllers.tabular.sarsa import SarsaController
from dmil.controllers.tabular.settings import SarsaSettings
from dmil.rewards import Reward
from dmil.scenarios import Scenario
from dmil.seeding import simulator_seed, stream
from dmil.simulation import QueueSimulator, Simulator
from dmil.training.loop import Run, run
from dmil.training.observers import Observer

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
