"""The only loop: simulator, controller and reward, one decision after the other."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from dmil.controllers import NO_MEMORY, Controller, MemoryController, MemoryUse, Situation
from dmil.demand import Vehicles
from dmil.rewards import Reward, checked_reward
from dmil.simulation import Measures, Simulator


@dataclass(frozen=True, slots=True)
class Run:
    """What happened in one run.

    Attributes
    ----------
    measures: Measures
        Counts at the end of the run.
    time_s: tuple of int
        Decision times where the memory was watched, and the horizon as the last.
    memory: tuple of MemoryUse
        Memory in use at these times.
    decisions: int
        How often the controller was asked.
    decide_s: float
        What its answers took, in s of this machine; two runs are equal whatever it is.
    """

    measures: Measures
    time_s: tuple[int, ...]
    memory: tuple[MemoryUse, ...]
    decisions: int = 0
    decide_s: float = field(default=0.0, compare=False)


def run(
    simulator: Simulator,
    controller: Controller,
    vehicles: Vehicles,
    reward: Reward,
    rng: np.random.Generator,
    seed: int = 0,
    *,
    watch_memory: bool = True,
) -> Run:
    """Run a controller from an empty network to the horizon (Algorithm 3, all agents at once).

    The last interval has no next choice, so nothing is learned from it: the horizon cuts a task
    that goes on, it is no terminal state.

    Parameters
    ----------
    simulator
        Moves the network.
    controller
        Chooses the phases; it keeps what it learned before, and learns if its settings say so.
    vehicles
        All journeys, drawn before the run.
    reward
        What the controller gets for an interval.
    rng
        The controller's stream of chance.
    seed
        Seed of the chance inside the simulator.
    watch_memory
        Whether to note the memory in use at every decision, or at the end only.

    Raises
    ------
    InputError
        If the reward is not one finite number per intersection.
    """
    network = simulator.network
    scenario = simulator.scenario
    controller.begin(Situation(network, scenario.timing, rng, vehicles, scenario.dynamics))
    observation = simulator.reset(vehicles, seed)
    memory_use = _memory_use_of(controller)
    last_reward = None
    times_s, memory = [], []
    decisions, decide_ns = 0, 0
    while True:
        before_ns = time.perf_counter_ns()
        phases = controller.decide(observation, last_reward)
        decide_ns += time.perf_counter_ns() - before_ns
        decisions += 1
        if watch_memory:
            times_s.append(observation.time_s)
            memory.append(memory_use())
        following = simulator.advance(phases)
        if following.time_s >= simulator.horizon_s:
            break
        last_reward = checked_reward(reward, observation, following, network)
        observation = following
    at_the_end = memory[-1] if memory else memory_use()
    return Run(
        simulator.measures(),
        (*times_s, following.time_s),
        (*memory, at_the_end),
        decisions,
        decide_ns * 1e-9,
    )


def _memory_use_of(controller: Controller) -> Callable[[], MemoryUse]:
    # Once a run: to ask whether an object follows a protocol takes longer than many a decision.
    return controller.memory_use if isinstance(controller, MemoryController) else lambda: NO_MEMORY
