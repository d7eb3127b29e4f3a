"""One score: a controller with some options, trained and judged with one tuning seed."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from functools import lru_cache

from dmil.controllers import CONTROLLERS, Controller, MemoryController, make_controller
from dmil.errors import DivergedError
from dmil.network import RoadNetwork
from dmil.rewards import PAPER_CONSTANTS, RewardConstants, make_reward
from dmil.scenarios import Scenario
from dmil.scenarios.recipe import ScenarioRecipe
from dmil.simulation import Simulator, make_simulator
from dmil.training import controller_of, evaluate, policy_of, train, vehicles_of_seed

FROZEN = {"learning": False, "epsilon": 0.0}


@dataclass(frozen=True, slots=True)
class TuningTrial:
    """What one score is about.

    Attributes
    ----------
    options: str
        All options of the controller that are set, as JSON.
    place: int
        Which tuning seed, counted from 0.
    seed: int
        The seed itself.
    """

    options: str
    place: int
    seed: int


@dataclass(frozen=True, slots=True)
class Judge:
    """Trains and judges one controller; see `TuningSettings` for what is not said here.

    Attributes
    ----------
    recipe: str
        The scenario, as JSON.
    simulator, controller, reward, metric: str
    episodes: int
    frozen: bool
    call: int
        Number of the tuning: files of scenarios may change between two.
    reward_constants: RewardConstants
    """

    recipe: str
    simulator: str
    controller: str
    reward: str
    metric: str
    episodes: int
    frozen: bool
    call: int = 0
    reward_constants: RewardConstants = PAPER_CONSTANTS

    def __call__(self, trial: TuningTrial) -> tuple[TuningTrial, float | str]:
        """Return a trial's score, or why there is none."""
        try:
            score = self.score(json.loads(trial.options), trial.seed)
        except DivergedError as error:
            return trial, str(error)
        # A millionth of what is measured says nothing, and the file is for people, too.
        return trial, round(score, 6) if math.isfinite(score) else f"{self.metric} is {score}"

    def score(self, options: dict[str, object], seed: int) -> float:
        """Return what is to be made low, after training where the controller learns.

        Raises
        ------
        DivergedError
            What the controller learned is no longer a number.
        """
        scenario, simulator = _place(self.recipe, self.simulator, self.call)
        reward = make_reward(self.reward, self.reward_constants)
        controller = make_controller(self.controller, options)
        if isinstance(controller, MemoryController):
            numbers = range(self.episodes)
            train(scenario, controller, reward, seed, episodes=numbers, simulator=simulator)
            if self.frozen and self.episodes:
                controller = self._as_frozen(controller, options, scenario.network)
        vehicles = vehicles_of_seed(scenario, seed)
        found = evaluate(simulator, controller, vehicles, reward, seed)
        return float(getattr(found.measures, self.metric))

    def _as_frozen(
        self, controller: MemoryController, options: dict[str, object], network: RoadNetwork
    ) -> Controller:
        policy = policy_of(
            controller,
            network,
            name=self.controller,
            options=options,
            reward=self.reward,
            reward_constants=self.reward_constants,
            training={"scenario": network.name},
        )
        settings = CONTROLLERS[self.controller].settings
        known = settings.model_fields if settings else {}
        frozen = {name: value for name, value in FROZEN.items() if name in known}
        return controller_of(policy, network, where=self.controller, **frozen)


@lru_cache(maxsize=2)
def _place(recipe: str, name: str, call: int) -> tuple[Scenario, Simulator]:
    """Return scenario and simulator; what is derived from a network is kept with it."""
    scenario = ScenarioRecipe.model_validate_json(recipe).build()
    return scenario, make_simulator(scenario, name)
