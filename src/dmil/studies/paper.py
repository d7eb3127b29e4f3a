"""Run the paper's study: plan, compile, run in parallel, keep, finish."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import dmil
from dmil.rewards import check_constants, make_reward
from dmil.studies.block import BlockResult, run_block
from dmil.studies.executors import Executor
from dmil.studies.plan import Block, blocks
from dmil.studies.running import Progress, run_units
from dmil.studies.settings import PaperStudySettings, check_horizon
from dmil.studies.store import StudyStore
from dmil.studies.warm_up import compile_kernels


def run_paper_study(
    settings: PaperStudySettings,
    folder: Path,
    *,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> None:
    """Run the paper's study into a folder; a folder that holds part of it is continued (§7).

    The results are the same bytes whatever the executor and however often the study was
    interrupted. If it is interrupted, finished blocks are kept.

    Parameters
    ----------
    settings
        What to run.
    folder
        Where to; made if missing.
    executor
        Where runs happen; processes of this machine by default.
    progress
        Called with the finished blocks and all blocks, first with those kept from before.

    Raises
    ------
    InputError
        If there is no such grid or reward, or a run is too short.
    OutputError
        If the folder cannot be used.
    """
    check_study(settings)

    def prepare() -> Callable[[Block], BlockResult]:
        compile_kernels(executor)
        return partial(run_block, settings)

    with StudyStore(folder, study_identity(settings)) as store:
        run_units(store, blocks(settings), prepare, executor=executor, progress=progress)


def check_study(settings: PaperStudySettings) -> None:
    """Check what workers would find wrong, before anything is written (ours).

    Raises
    ------
    InputError
        If there is no such grid or reward, or a run is too short.
    """
    for name in settings.grids:
        made = settings.recipe(f"grid:{name}").build()
        check_horizon(settings.horizon_s, made.timing.decision_interval_s)
    for reward in settings.rewards:
        make_reward(reward)
    check_constants(settings.rewards, settings.reward_constants)


def study_identity(settings: PaperStudySettings) -> dict[str, Any]:
    """Return what makes two studies the same: configuration and version of the program (ours)."""
    configuration = settings.model_dump(mode="json")
    configuration["presets"] = {
        name: settings.preset(name).model_dump() for name in settings.presets
    }
    return {"study": "paper", "dmil": dmil.__version__, "configuration": configuration}
