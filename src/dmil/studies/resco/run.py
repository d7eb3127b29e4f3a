"""Run the study on the RESCO benchmark: calibrate, train, judge, keep, finish."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import dmil
from dmil.errors import unknown_name
from dmil.rewards import make_reward
from dmil.simulation.sumo.process import require_sumo
from dmil.studies.block import BlockResult
from dmil.studies.executors import Executor, LocalExecutor
from dmil.studies.resco.plan import ContenderUnit, units
from dmil.studies.resco.settings import NETWORKS, RescoStudySettings
from dmil.studies.resco.unit import calibration_file, run_unit, study_scenario
from dmil.studies.running import Progress, run_units
from dmil.studies.settings import check_horizon
from dmil.studies.store import StudyStore
from dmil.studies.warm_up import compile_kernels
from dmil.training.calibration import calibrate

CALIBRATION_SEED = 1_000_003
"""Seed of the calibration's SUMO run; test seeds are small numbers."""


def run_resco_study(
    settings: RescoStudySettings,
    folder: Path,
    *,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> None:
    """Run the study into a folder; a folder that holds part of it is continued (ours).

    First the queue simulator of every network is calibrated by one run of SUMO. Then every learner
    is trained, and every controller is judged in SUMO and in the queue simulator with and without
    calibration, on the same vehicles in a seed. The results are the same bytes whatever the
    executor and however often the study was interrupted.

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
        If there is no such network or reward, or a run is too short.
    MissingExtraError
        If SUMO or the benchmark's files are not installed.
    OutputError
        If the folder cannot be used.
    """
    check_resco_study(settings)
    plan = units(settings)

    def prepare() -> Callable[[ContenderUnit], BlockResult]:
        compile_kernels(executor)
        if settings.calibrate:
            missing = [
                name
                for name in settings.scenarios
                if not calibration_file(str(folder), name).is_file()
            ]
            work = partial(_calibrate, settings, str(folder))
            for _ in (executor or LocalExecutor()).map(work, missing):
                pass
        return partial(run_unit, settings, str(folder))

    with StudyStore(folder, resco_identity(settings), ContenderUnit) as store:
        run_units(store, plan, prepare, executor=executor, progress=progress)


def check_resco_study(settings: RescoStudySettings) -> None:
    """Check what workers would find wrong, before anything is written (ours).

    Raises
    ------
    InputError
        If there is no such network or reward, or a run is too short.
    MissingExtraError
        If SUMO or the benchmark's files are not installed.
    """
    require_sumo()
    for name in settings.scenarios:
        if name not in NETWORKS:
            raise unknown_name("network of RESCO", name, NETWORKS)
    made = study_scenario(f"resco/{settings.scenarios[0]}", settings.horizon_s)
    check_horizon(made.horizon_s, made.timing.decision_interval_s)
    make_reward(settings.reward)


def resco_identity(settings: RescoStudySettings) -> dict[str, Any]:
    """Return what makes two studies the same: configuration and version of the program (ours)."""
    configuration = settings.model_dump(mode="json")
    return {"study": "resco", "dmil": dmil.__version__, "configuration": configuration}


def _calibrate(settings: RescoStudySettings, folder: str, name: str) -> None:
    made = study_scenario(f"resco/{name}", settings.horizon_s)
    calibrate(made, CALIBRATION_SEED).save(calibration_file(folder, name))
