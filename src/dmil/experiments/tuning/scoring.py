"""One score: a controller with some options, trained and judged with one tuning seed."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass

from dmil.controllers import Controller, MemoryController, make_controller
from dmil.controllers.variants import Variant
from dmil.errors import DivergedError
from dmil.experiments.comparison import place_of
from dmil.experiments.contender import frozen_copy
from dmil.experiments.tuning.record import Tuned, TuningSettings
from dmil.rewards import make_reward
from dmil.training import evaluate, train, vehicles_of_seed


@dataclass(frozen=True, slots=True)
class TuningTrial:
    """What one score is about: a controller with all options that are set, and one tuning seed.

    ``place`` says which seed it is, counted from 0.
    """

    variant: Variant
    place: int
    seed: int


@dataclass(frozen=True, slots=True)
class Judge:
    """Trains and judges a controller with some options, as a tuning says.

    The number of the tuning is there because files of scenarios may change between two.
    """

    about: Tuned
    call: int = 0

    def __call__(self, trial: TuningTrial) -> tuple[TuningTrial, float | str]:
        """Return a trial's score, or why there is none."""
        try:
            score = self.score(trial.variant, trial.seed)
        except DivergedError as error:
            return trial, str(error)
        # A millionth of what is measured says nothing, and the file is for people, too.
        told = f"{self.about.settings['metric']} is {score}"
        return trial, round(score, 6) if math.isfinite(score) else told

    def score(self, variant: Variant, seed: int) -> float:
        """Return what is to be made low, after training where the controller learns.

        Raises
        ------
        DivergedError
            What the controller learned is no longer a number.
        """
        about, settings = self.about, TuningSettings(**self.about.settings)
        scenario, simulator = place_of(json.dumps(about.recipe), about.simulator, self.call)
        reward = make_reward(about.reward, about.reward_constants)
        controller: Controller = make_controller(variant.name, variant.options)
        if isinstance(controller, MemoryController):
            numbers = range(settings.episodes)
            train(scenario, controller, reward, seed, episodes=numbers, simulator=simulator)
            if settings.frozen and settings.episodes:
                controller = frozen_copy(controller, scenario.network, variant)
        vehicles = vehicles_of_seed(scenario, seed)
        found = evaluate(simulator, controller, vehicles, reward, seed)
        return float(getattr(found.measures, settings.metric))
