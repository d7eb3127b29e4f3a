"""The paper's study: its blocks, and how one is run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, ClassVar

from dmil.experiments.checks import check_horizon
from dmil.experiments.trial import TrialResult
from dmil.parallel import Executor
from dmil.rewards import check_constants, make_reward
from dmil.studies.paper.block import run_block
from dmil.studies.paper.plan import Block, blocks
from dmil.studies.paper.settings import PaperStudySettings


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
