"""The study of memories: every controller, on grids and recorded cities, under one protocol."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, ClassVar

from dmil.controllers import make_controller
from dmil.errors import InputError
from dmil.experiments.checks import check_horizon
from dmil.experiments.trial import TrialResult
from dmil.parallel import Executor
from dmil.rewards import make_reward
from dmil.studies.memories.plan import (
    MemoriesUnit,
    ablations,
    cells,
    contenders,
    fits,
    options_of,
    units,
)
from dmil.studies.memories.settings import MemoriesStudySettings
from dmil.studies.memories.unit import run_unit


@dataclass(frozen=True)
class MemoriesStudy:
    """The study of memories, as `dmil.experiments.study.run_study` runs it (ours).

    Parameters
    ----------
    settings
        What to run.
    """

    settings: MemoriesStudySettings
    name: ClassVar[str] = "memories"

    def check(self) -> None:
        """Check that cells, controllers, options and rewards exist, and runs are long enough.

        Raises
        ------
        InputError
            If there is no such cell, controller, option or reward, or a run is too short.
        MissingExtraError
            If a controller needs a package that is not installed.
        """
        settings = self.settings
        for cell in cells(settings):
            made = cell.build(settings.horizon_s, settings.data)
            check_horizon(made.horizon_s, made.timing.decision_interval_s)
        variants = contenders(settings)
        for each in variants:
            make_controller(each.name, options_of(settings, each))
        for each in variants[: len(settings.controllers)]:
            if not any(fits(each, cell) for cell in cells(settings)):
                raise InputError(
                    "it plans for a single intersection",
                    where=f"controller '{each.label}'",
                    expected="a cell with one intersection, such as grid:1x1",
                )
        names = {each.name for each in variants}
        labels = {each.label for each in variants}
        if settings.tuned and not settings.tuned.keys() & (names | labels):
            raise InputError(
                f"options of {', '.join(sorted(settings.tuned))}, none of which runs",
                where="tuned",
                expected=f"options of controllers of the study: {', '.join(sorted(names))}",
            )
        for reward in (settings.reward, *settings.rewards.values()):
            make_reward(reward)

    def configuration(self) -> dict[str, Any]:
        """Return all settings; cells and controllers by name, files of cities left out."""
        settings = self.settings
        configuration = settings.model_dump(mode="json", exclude={"data", "deep"})
        configuration["cells"] = [cell.name for cell in cells(settings)]
        configuration["controllers"] = [each.label for each in contenders(settings)]
        configuration["ablations"] = [each.label for each in ablations(settings)]
        return configuration

    def plan(self) -> list[MemoriesUnit]:
        """Return one trial for each controller, cell and seed."""
        return units(self.settings)

    def prepare(self, folder: Path, executor: Executor) -> Callable[[MemoriesUnit], TrialResult]:
        """Return what runs one trial."""
        return partial(run_unit, self.settings)
