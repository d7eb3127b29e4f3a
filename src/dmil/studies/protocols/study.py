"""The study of protocols, as the engine runs it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache, partial
from pathlib import Path
from typing import Any, ClassVar

from dmil.controllers import Controller, check_controller, make_controller
from dmil.experiments.checks import check_horizon
from dmil.experiments.trial import Row, TrialResult, columns_of, measures_row
from dmil.parallel import Executor
from dmil.rewards import make_reward
from dmil.scenarios import Scenario
from dmil.simulation import Simulator, make_simulator
from dmil.simulation.cityflow import CityflowSimulator
from dmil.simulation.cityflow.process import has_cityflow
from dmil.studies.protocols.plan import CITYFLOW, ProtocolTrial, build, day, trials
from dmil.studies.protocols.recipes import PROTOCOLS
from dmil.studies.protocols.rule import NAME, PublishedMaxPressure
from dmil.studies.protocols.settings import ProtocolsStudySettings
from dmil.training import evaluate

REWARD = "queue"


@dataclass(frozen=True)
class ProtocolsStudy:
    """Methods × protocols × cities, as `dmil.experiments.study.run_study` runs it (ours).

    Parameters
    ----------
    settings
        What to run.
    """

    settings: ProtocolsStudySettings
    name: ClassVar[str] = "protocols"

    def check(self) -> None:
        """Check that protocols, cities and controllers are there, and runs are long enough.

        Raises
        ------
        InputError
            If there is no such protocol, city or controller, or a run is too short.
        """
        for trial in self.plan():
            if trial.controller.name != NAME:
                check_controller(trial.controller.name)
                make_controller(trial.controller.name, trial.controller.options)
            interval_s = PROTOCOLS[trial.preset].decision_interval_s
            check_horizon(self.settings.horizon_s, interval_s)

    def configuration(self) -> dict[str, Any]:
        """Return all settings, the folder of data left out, and whether CityFlow is there."""
        values = self.settings.model_dump(mode="json", exclude={"data"})
        return values | {"cityflow": has_cityflow()}

    def plan(self) -> list[ProtocolTrial]:
        """Return all trials; those in CityFlow only where it is."""
        return trials(self.settings, cityflow=has_cityflow())

    def prepare(self, folder: Path, executor: Executor) -> Callable[[ProtocolTrial], TrialResult]:
        """Return what runs one trial."""
        return partial(run_trial, self.settings)


def run_trial(settings: ProtocolsStudySettings, trial: ProtocolTrial) -> TrialResult:
    """Run one controller for a day; a run that fails becomes a row that says so (ours)."""
    identity: Row = columns_of(trial) | {"communication": False}
    result = TrialResult(trial, [], [])
    row = identity | {"study": "protocols", "horizon_s": settings.horizon_s}
    simulator: Simulator | None = None
    try:
        made = _scenario(settings, trial.preset, trial.scenario)
        simulator = _simulator(made, trial)
        vehicles = day(made, trial.seed, settings.shift_s)
        run = evaluate(
            simulator, _controller(trial, simulator), vehicles, make_reward(REWARD), trial.seed
        )
        row |= measures_row(run.measures, run.memory[-1])
        row |= {"intersections": len(made.network.intersections)}
        times = {"decisions": run.decisions, "decide_s": run.decide_s}
        result.timings.append(identity | times)
    except Exception as error:
        result.runs.append(row | {"status": f"{type(error).__name__}: {error}"})
        return result
    finally:
        if isinstance(simulator, CityflowSimulator):
            simulator.close()
    result.runs.append(row | {"status": "ok"})
    return result


@lru_cache(maxsize=2)
def _scenario(settings: ProtocolsStudySettings, protocol: str, city: str) -> Scenario:
    return build(settings, PROTOCOLS[protocol], city)


def _simulator(made: Scenario, trial: ProtocolTrial) -> Simulator:
    if trial.simulator == CITYFLOW:
        return CityflowSimulator(made, begins=PROTOCOLS[trial.preset].begins)
    return make_simulator(made, trial.simulator)


def _controller(trial: ProtocolTrial, simulator: Simulator) -> Controller:
    if trial.controller.name == NAME:
        assert isinstance(simulator, CityflowSimulator)
        return PublishedMaxPressure(simulator)
    return make_controller(trial.controller.name, trial.controller.options)
