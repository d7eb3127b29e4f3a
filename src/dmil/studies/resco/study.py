"""The study on the RESCO benchmark: calibrate, train, evaluate in SUMO."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, ClassVar

from dmil.errors import unknown_name
from dmil.experiments.checks import check_horizon
from dmil.experiments.trial import TrialResult
from dmil.parallel import Executor
from dmil.rewards import make_reward
from dmil.simulation.sumo.process import require_sumo
from dmil.studies.resco.plan import ContenderUnit, units
from dmil.studies.resco.settings import NETWORKS, RescoStudySettings
from dmil.studies.resco.unit import calibration_file, run_unit, study_scenario
from dmil.training.calibration import calibrate

CALIBRATION_SEED = 1_000_003
"""Seed of the calibration's SUMO run; test seeds are small numbers."""


@dataclass(frozen=True)
class RescoStudy:
    """The study on the RESCO benchmark, as `dmil.experiments.study.run_study` runs it (ours).

    First the queue simulator of every network is calibrated by one run of SUMO. Then every learner
    is trained, and every controller is evaluated in SUMO and in the queue simulator with and
    without calibration, on the same vehicles in a seed.

    Parameters
    ----------
    settings
        What to run.
    """

    settings: RescoStudySettings
    name: ClassVar[str] = "resco"

    def check(self) -> None:
        """Check that networks, reward and SUMO are there, and that runs are long enough.

        Raises
        ------
        InputError
            If there is no such network or reward, or a run is too short.
        MissingExtraError
            If SUMO or the benchmark's files are not installed.
        """
        settings = self.settings
        require_sumo()
        for name in settings.scenarios:
            if name not in NETWORKS:
                raise unknown_name("network of RESCO", name, NETWORKS)
        made = study_scenario(f"resco/{settings.scenarios[0]}", settings.horizon_s)
        check_horizon(made.horizon_s, made.timing.decision_interval_s)
        make_reward(settings.reward)

    def configuration(self) -> dict[str, Any]:
        """Return all settings."""
        return self.settings.model_dump(mode="json")

    def plan(self) -> list[ContenderUnit]:
        """Return one trial for each controller, network and seed."""
        return units(self.settings)

    def prepare(self, folder: Path, executor: Executor) -> Callable[[ContenderUnit], TrialResult]:
        """Calibrate the networks that are not calibrated yet; return what runs one trial."""
        if self.settings.calibrate:
            missing = [
                name
                for name in self.settings.scenarios
                if not calibration_file(str(folder), name).is_file()
            ]
            for _ in executor.map(partial(_calibrate, self.settings, str(folder)), missing):
                pass
        return partial(run_unit, self.settings, str(folder))


def _calibrate(settings: RescoStudySettings, folder: str, name: str) -> None:
    made = study_scenario(f"resco/{name}", settings.horizon_s)
    calibrate(made, CALIBRATION_SEED).save(calibration_file(folder, name))
