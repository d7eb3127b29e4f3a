"""Compile all kernels once, so that workers only load them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np

from dmil.compilation import is_cold, mark_warm
from dmil.controllers import Prior, RunContext, make_controller
from dmil.memory import make_value_table
from dmil.parallel import Executor, LocalExecutor
from dmil.rewards import make_reward
from dmil.scenarios import Scenario
from dmil.scenarios.recipe import DynamicsChanges, GridChanges, ScenarioRecipe
from dmil.seeding import stream
from dmil.simulation import QueueSimulator
from dmil.training import evaluate, train_prior, vehicles_of_seed

RULES = ("random", "fixed-cycle", "longest-queue-first", "max-pressure")
REWARDS = ("default", "diffusion", "entropy")
SARSA: tuple[dict[str, object], ...] = (
    {"embedding": "exact"},
    {"embedding": "simple"},
    {"embedding": "complex"},
    {"embedding": "complex", "communication": True},
)
DUAL_MEMORY: tuple[dict[str, object], ...] = (
    {},
    {"trigger": "entries"},
    {"trigger": "values"},
    {"trigger": "staging"},
    {"sent": "short"},
    {"sent": "both"},
    {"communication_delay_s": 50},
    {"message_loss": 0.1},
    {"announced": True},
)
"""Options with which agents that communicate need other kernels."""


def compile_kernels(executor: Executor | None = None) -> None:
    """Run a miniature of all studies if the kernels are not compiled yet.

    Without it every worker process of a first start would compile the same kernels. Those that the
    memory-based agents alone have, more than half, are compiled beside the others, in processes of
    this machine; where runs happen elsewhere, this process does it.
    """
    if not is_cold():
        return
    here = executor or LocalExecutor()
    if not isinstance(here, LocalExecutor):
        here = LocalExecutor(1)
    for _ in here.map(_call, [_decide_from_memory, _run_the_others]):
        pass
    mark_warm()


def _call(part: Callable[[], None]) -> None:
    part()


@cache
def _smallest() -> Scenario:
    """Two agents and 200 s: the smallest run in which the agents meet the central unit."""
    return ScenarioRecipe(
        scenario="grid:1x2",
        horizon_s=200,
        dynamics=DynamicsChanges(saturation_flow_veh_per_s=1.0),
        grid=GridChanges(link_time_s=5.0),
    ).build()


def _run_the_others() -> None:
    scenario = _smallest()
    simulator, vehicles = QueueSimulator(scenario), vehicles_of_seed(scenario, 0)
    for name in REWARDS:
        reward = make_reward(name)
        prior = train_prior(scenario, reward, 0, epsilon=0.6, simulator=simulator)
        for options in SARSA:
            controller = make_controller("sarsa", options, prior=prior)
            evaluate(simulator, controller, vehicles, reward, 0)
    for name in RULES:
        evaluate(simulator, make_controller(name), vehicles, make_reward("queue"), 0)


def _decide_from_memory() -> None:
    """Let the memory-based agents decide in an empty network: no simulator, and no training."""
    scenario = _smallest()
    empty = QueueSimulator(scenario).reset(vehicles_of_seed(scenario, 0))
    actions = max(len(item.phases) for item in scenario.network.intersections)
    prior = Prior(make_value_table(1, 1, empty.queue_veh.shape[1], actions, tolerance=0))
    for options in DUAL_MEMORY:
        controller = make_controller("dual-memory", {"communication": True} | options, prior=prior)
        chance = stream(0, "exploration")
        controller.reset(RunContext(scenario.network, scenario.timing, chance))
        for time_s in range(0, scenario.horizon_s, scenario.timing.decision_interval_s):
            controller.decide(replace(empty, time_s=time_s), np.zeros(empty.phase.size))
