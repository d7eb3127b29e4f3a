"""The only loop: simulator, controller and reward, one decision after the other."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from dmil.controllers import Controller, MemoryUse, RunContext
from dmil.demand import Vehicles
from dmil.rewards import Reward, checked_reward
from dmil.simulation import Measures, Simulator
from dmil.training.observers import Observer, memory_use_of


@dataclass(frozen=True, slots=True)
class Run:
    """What happened in one run.

    Attributes
    ----------
    measures: Measures
        Counts at the end of the run.
    time_s: tuple of int
        The horizon; before it the decisions, where the memory was watched.
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
    observers: Sequence[Observer] = (),
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
    observers
        Who watches it.

    Raises
    ------
    InputError
        If the reward is not one finite number per intersection.
    """
    network = simulator.network
    scenario = simulator.scenario
    controller.reset(RunContext(network, scenario.timing, rng, vehicles, scenario.dynamics))
    observation = simulator.reset(vehicles, seed)
    for each in observers:
        each.begin(simulator, controller, observation)
    last_reward = None
    decisions, decide_ns = 0, 0
    while True:
        before_ns = time.perf_counter_ns()
        phases = controller.decide(observation, last_reward)
        decide_ns += time.perf_counter_ns() - before_ns
        decisions += 1
        for each in observers:
            each.decided(observation, phases)
        following = simulator.advance(phases)
        for each in observers:
            each.advanced(phases, following)
        if following.time_s >= simulator.horizon_s:
            break
        last_reward = checked_reward(reward, observation, following, network)
        for each in observers:
            each.rewarded(last_reward)
        observation = following
    return Run(
        simulator.measures(),
        (following.time_s,),
        (memory_use_of(controller)(),),
        decisions,
        decide_ns * 1e-9,
    )
