"""Runs that compare: every controller meets the same vehicles in the same seed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from dmil.controllers import Controller
from dmil.demand import Vehicles
from dmil.rewards import Reward
from dmil.scenarios import Scenario
from dmil.seeding import simulator_seed, stream
from dmil.simulation import Simulator
from dmil.training.loop import Run, run
from dmil.training.observers import MemoryRecorder, Observer


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
