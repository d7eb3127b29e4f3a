"""Run the study of memories: plan, compile, run in parallel, keep, finish."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import dmil
from dmil.controllers import make_controller
from dmil.controllers.variants import parse_variant
from dmil.errors import InputError
from dmil.rewards import make_reward
from dmil.studies.block import BlockResult
from dmil.studies.executors import Executor
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
from dmil.studies.running import Progress, run_units
from dmil.studies.settings import check_horizon
from dmil.studies.store import StudyStore
from dmil.studies.warm_up import compile_kernels


def run_memories_study(
    settings: MemoriesStudySettings,
    folder: Path,
    *,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> None:
    """Run the study into a folder; a folder that holds part of it is continued (ours).

    The results, but for the timings, are the same bytes whatever the executor and however often
    the study was interrupted.

    Parameters
    ----------
    settings
        What to run.
    folder
        Where to; made if missing.
    executor
        Where runs happen; processes of this machine by default.
    progress
        Called with the finished units and all units, first with those kept from before.

    Raises
    ------
    InputError
        If there is no such cell, controller, option or reward, or a run is too short.
    MissingExtraError
        If a controller needs a package that is not installed.
    OutputError
        If the folder cannot be used.
    """
    check_memories_study(settings)

    def prepare() -> Callable[[MemoriesUnit], BlockResult]:
        compile_kernels(executor)
        return partial(run_unit, settings)

    with StudyStore(folder, memories_identity(settings), MemoriesUnit) as store:
        run_units(store, units(settings), prepare, executor=executor, progress=progress)


def check_memories_study(settings: MemoriesStudySettings) -> None:
    """Check what workers would find wrong, before anything is written (ours).

    Raises
    ------
    InputError
        If there is no such cell, controller, option or reward, or a run is too short.
    MissingExtraError
        If a controller needs a package that is not installed.
    """
    for cell in cells(settings):
        made = cell.build(settings.horizon_s, settings.data)
        check_horizon(made.horizon_s, made.timing.decision_interval_s)
    for label in contenders(settings):
        make_controller(parse_variant(label).name, options_of(settings, label))
    for label in settings.controllers:
        if not any(fits(label, cell) for cell in cells(settings)):
            raise InputError(
                "it plans for a single intersection",
                where=f"controller '{label}'",
                expected="a cell with one intersection, such as grid:1x1",
            )
    names = {parse_variant(label).name for label in contenders(settings)}
    if settings.tuned and not settings.tuned.keys() & names.union(contenders(settings)):
        raise InputError(
            f"options of {', '.join(sorted(settings.tuned))}, none of whom runs",
            where="tuned",
            expected=f"options of controllers of the study: {', '.join(sorted(names))}",
        )
    for reward in (settings.reward, *settings.rewards.values()):
        make_reward(reward)


def memories_identity(settings: MemoriesStudySettings) -> dict[str, Any]:
    """Return what makes two studies the same: configuration and version of the program (ours).

    Cells and controllers are named; where the files of cities lie does not matter.
    """
    configuration = settings.model_dump(mode="json", exclude={"data", "deep"})
    configuration["cells"] = [cell.name for cell in cells(settings)]
    configuration["controllers"] = contenders(settings)
    configuration["ablations"] = ablations(settings)
    return {"study": "memories", "dmil": dmil.__version__, "configuration": configuration}
