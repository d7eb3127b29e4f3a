"""One score: a controller with some options, trained and judged with one tuning seed."""

from __future__ import annotations

import math
from dataclasses import dataclass

from dmil.controllers import Controller, MemoryController, make_controller
from dmil.controllers.variants import Variant
from dmil.errors import DivergedError
from dmil.experiments.comparison import place_of
from dmil.experiments.contender import frozen_copy
from dmil.rewards import PAPER_CONSTANTS, RewardConstants, make_reward
from dmil.training import evaluate, train, vehicles_of_seed


@dataclass(frozen=True, slots=True)
class TuningTrial:
    """What one score is about.

    Attributes
    ----------
    variant: Variant
        The controller with all options that are set.
    place: int
        Which tuning seed, counted from 0.
    seed: int
        The seed itself.
    """

    variant: Variant
    place: int
    seed: int


@dataclass(frozen=True, slots=True)
class Judge:
    """Trains and judges controllers; see `TuningSettings` for what is not said here.

    Attributes
    ----------
    recipe: str
        The scenario, as JSON.
    simulator, reward, metric: str
    episodes: int
    frozen: bool
    call: int
        Number of the tuning: files of scenarios may change between two.
    reward_constants: RewardConstants
    """

    recipe: str
    simulator: str
    reward: str
    metric: str
    episodes: int
    frozen: bool
    call: int = 0
    reward_constants: RewardConstants = PAPER_CONSTANTS

    def __call__(self, trial: TuningTrial) -> tuple[TuningTrial, float | str]:
        """Return a trial's score, or why there is none."""
        try:
            score = self.score(trial.variant, trial.seed)
        except DivergedError as error:
            return trial, str(error)
        # A millionth of what is measured says nothing, and the file is for people, too.
        return trial, round(score, 6) if math.isfinite(score) else f"{self.metric} is {score}"

    def score(self, variant: Variant, seed: int) -> float:
        """Return what is to be made low, after training where the controller learns.

        Raises
        ------
        DivergedError
            What the controller learned is no longer a number.
        """
        scenario, simulator = place_of(self.recipe, self.simulator, self.call)
        reward = make_reward(self.reward, self.reward_constants)
        controller: Controller = make_controller(variant.name, variant.options)
        if isinstance(controller, MemoryController):
            numbers = range(self.episodes)
            train(scenario, controller, reward, seed, episodes=numbers, simulator=simulator)
            if self.frozen and self.episodes:
                controller = frozen_copy(controller, scenario.network, variant)
        vehicles = vehicles_of_seed(scenario, seed)
        found = evaluate(simulator, controller, vehicles, reward, seed)
        return float(getattr(found.measures, self.metric))
