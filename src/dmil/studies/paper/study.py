"""The paper's study: its blocks, and how one is run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from functools import lru_cache, partial
from pathlib import Path
from typing import Any, ClassVar

from dmil.controllers import Controller, Prior, make_controller
from dmil.controllers.variants import read_options
from dmil.demand import Vehicles
from dmil.experiments.checks import check_horizon
from dmil.experiments.trial import SIMULATOR, Row, TrialResult, measures_row
from dmil.parallel import Executor
from dmil.rewards import PAPER_CONSTANTS, Reward, check_constants, make_reward
from dmil.scenarios import Scenario
from dmil.scenarios.recipe import ScenarioRecipe
from dmil.simulation import QueueSimulator
from dmil.studies.paper.plan import Architecture, Block, architectures, blocks, training_s, variants
from dmil.studies.paper.settings import PaperStudySettings
from dmil.training import evaluate, train_prior, vehicles_of_seed
from dmil.training.recording import series_rows


@dataclass(frozen=True)
class PaperStudy:
    """The paper's study, as `dmil.experiments.study.run_study` runs it (paper, §VI).

    Parameters
    ----------
    settings
        What to run.
    """

    settings: PaperStudySettings
    name: ClassVar[str] = "paper"

    def check(self) -> None:
        """Check that grids and rewards exist, and that runs are long enough.

        Raises
        ------
        InputError
            If there is no such grid or reward, or a run is too short.
        """
        settings = self.settings
        for name in settings.grids:
            made = settings.recipe(f"grid:{name}").build()
            check_horizon(settings.horizon_s, made.timing.decision_interval_s)
        for reward in settings.rewards:
            make_reward(reward)
        check_constants(settings.rewards, settings.reward_constants)

    def configuration(self) -> dict[str, Any]:
        """Return all settings, with what its presets stand for."""
        configuration = self.settings.model_dump(mode="json")
        configuration["presets"] = {
            name: self.settings.preset(name).model_dump() for name in self.settings.presets
        }
        return configuration

    def plan(self) -> list[Block]:
        """Return the blocks of runs that share their demand."""
        return blocks(self.settings)

    def prepare(self, folder: Path, executor: Executor) -> Callable[[Block], TrialResult]:
        """Return what runs one block."""
        return partial(run_block, self.settings)


def run_block(
    settings: PaperStudySettings,
    block: Block,
    wanted: Callable[[Architecture], bool] = lambda architecture: True,
) -> TrialResult:
    """Run the architectures of a block that are wanted, by default all (ours).

    A run that fails becomes a row that says so.
    """
    stage = _stage(settings, block)
    runs, series = [], []
    for architecture in filter(wanted, architectures(settings)):
        row, course = _run(settings, block, architecture, stage)
        runs.append(row)
        series += course
    varied = list(filter(wanted, variants(settings, block)))
    if varied:
        longer = stage.lasting(settings.horizon_s * settings.variant_factor, block.seed)
        runs += [_run(settings, block, architecture, longer)[0] for architecture in varied]
    return TrialResult(block, runs, series)


@dataclass(frozen=True, slots=True)
class _Stage:
    """What all runs of a block share: vehicles, a simulator, and where learners begin."""

    scenario: Scenario
    simulator: QueueSimulator
    vehicles: Vehicles
    training: Scenario
    training_simulator: QueueSimulator
    rewards: dict[str, Reward]
    priors: dict[tuple[str, bool], Prior]
    """By reward, and by whether states count what neighbours announce; made when first asked."""

    def lasting(self, horizon_s: int, seed: int) -> _Stage:
        """Return the same for longer runs."""
        longer = replace(self.scenario, horizon_s=horizon_s)
        return replace(
            self,
            scenario=longer,
            simulator=QueueSimulator(longer),
            vehicles=vehicles_of_seed(longer, seed),
        )

    def prior(self, reward: str, announced: bool, seed: int, epsilon: float) -> Prior:
        """Return what the dummy agent learned with a reward."""
        key = (reward, announced)
        if key not in self.priors:
            self.priors[key] = train_prior(
                self.training,
                self.rewards[reward],
                seed,
                epsilon=epsilon,
                announced=announced,
                simulator=self.training_simulator,
            )
        return self.priors[key]


def _stage(settings: PaperStudySettings, block: Block) -> _Stage:
    test, simulator, training, training_simulator = _scenarios(
        settings.recipe(block.scenario).model_dump_json(), training_s(settings, block.preset)
    )
    vehicles = vehicles_of_seed(test, block.seed)
    rewards = {name: _reward(settings, name) for name in settings.rewards}
    return _Stage(test, simulator, vehicles, training, training_simulator, rewards, {})


def _run(
    settings: PaperStudySettings, block: Block, architecture: Architecture, stage: _Stage
) -> tuple[Row, list[Row]]:
    """Run one architecture: its row of the runs, and its rows of the series."""
    reward = architecture.reward or settings.rewards[0]
    learns = architecture.reward is not None
    identity: Row = asdict(block) | asdict(architecture) | {"simulator": SIMULATOR}
    row = identity | {
        "study": "paper",
        "horizon_s": stage.scenario.horizon_s,
        "trained_in": SIMULATOR if learns else None,
        "training_s": stage.training.horizon_s if learns else None,
    }
    try:
        prior = None
        if learns:
            announced = bool(_options(architecture).get("announced", False))
            prior = stage.prior(reward, announced, block.seed, settings.training_epsilon)
        controller = _controller(settings, block.preset, architecture, prior)
        result = evaluate(
            stage.simulator, controller, stage.vehicles, stage.rewards[reward], block.seed
        )
    except Exception as error:
        return row | {"status": f"{type(error).__name__}: {error}"}, []
    row |= measures_row(result.measures, result.memory[-1]) | {"status": "ok"}
    return row, [identity | each for each in series_rows(result)]


def _controller(
    settings: PaperStudySettings, preset: str, architecture: Architecture, prior: Prior | None
) -> Controller:
    if architecture.reward is None:
        return make_controller(architecture.controller)
    base = settings.sarsa if architecture.controller == "sarsa" else settings.dual_memory
    options = base.model_dump() | {
        "embedding": architecture.embedding,
        "communication": architecture.communication,
        "epsilon": architecture.epsilon,
        "epsilon_decay": settings.preset(preset).epsilon_decay,
        **_options(architecture),
    }
    return make_controller(architecture.controller, options, prior=prior)


def _options(architecture: Architecture) -> dict[str, Any]:
    """Return the options of a variant."""
    return read_options([architecture.variant] if architecture.variant else [], where="variant")


def _reward(settings: PaperStudySettings, name: str) -> Reward:
    return make_reward(name, settings.reward_constants if name == "default" else PAPER_CONSTANTS)


@lru_cache(maxsize=8)
def _scenarios(
    recipe: str, training_s: int
) -> tuple[Scenario, QueueSimulator, Scenario, QueueSimulator]:
    test = _scenario(recipe)
    training = replace(test, horizon_s=training_s)
    return test, QueueSimulator(test), training, QueueSimulator(training)


# One network for all presets: what is derived from it is kept with it, or found by what it equals.
@lru_cache(maxsize=8)
def _scenario(recipe: str) -> Scenario:
    return ScenarioRecipe.model_validate_json(recipe).build()
