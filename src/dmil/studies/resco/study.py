"""The study on the RESCO benchmark: calibrate, train, evaluate in SUMO."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from pathlib import Path
from typing import Any, ClassVar

from dmil.controllers import Controller, MemoryController, make_controller
from dmil.controllers.variants import Variant
from dmil.demand.recorded import SHIFT_S
from dmil.errors import unknown_name
from dmil.experiments.checks import check_horizon
from dmil.experiments.contender import frozen_copy
from dmil.experiments.trial import (
    Row,
    TrialResult,
    columns_of,
    measures_row,
)
from dmil.parallel import Executor
from dmil.rewards import make_reward
from dmil.scenarios import Scenario, scenario
from dmil.scenarios.calibration import load_calibration
from dmil.scenarios.demand_changes import resampled
from dmil.simulation import Simulator, make_simulator
from dmil.simulation.sumo.process import require_sumo
from dmil.studies.resco.plan import DEEP, ContenderUnit, units
from dmil.studies.resco.settings import (
    BLOCKER_S,
    CALIBRATED,
    NETWORKS,
    UNBLOCKED,
    RescoStudySettings,
)
from dmil.training import evaluate, train, vehicles_of_seed
from dmil.training.calibration import calibrate
from dmil.training.episodes import EpisodeRecorder
from dmil.training.flow import FlowRecorder, locks_of
from dmil.training.recording import series_rows

CALIBRATION_SEED = 1_000_003
"""Seed of the calibration's SUMO run; test seeds are small numbers."""


@dataclass(frozen=True)
class RescoStudy:
    """The study on the RESCO benchmark, as `dmil.experiments.study.run_study` runs it (ours).

    First the queue simulator of every network is calibrated by one run of SUMO. Then every learner
    is trained, and every controller is evaluated in SUMO, where junctions can lock and where they
    cannot, and in the queue simulator with and without calibration, on the same vehicles in a seed.

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
        for name in (*settings.scenarios, *settings.lock_scenarios, *settings.deep_scenarios):
            if name not in NETWORKS:
                raise unknown_name("network of RESCO", name, NETWORKS)
        made = study_scenario(f"resco/{settings.scenarios[0]}", settings.horizon_s)
        check_horizon(made.horizon_s, made.timing.decision_interval_s)
        make_reward(settings.reward)
        if settings.deep:
            make_reward(settings.deep_reward)
            make_controller(DEEP)  # says so if torch is missing

    def configuration(self) -> dict[str, Any]:
        """Return all settings."""
        return self.settings.model_dump(mode="json")

    def plan(self) -> list[ContenderUnit]:
        """Return one trial for each controller, network and seed."""
        return units(self.settings)

    def prepare(self, folder: Path, executor: Executor) -> Callable[[ContenderUnit], TrialResult]:
        """Calibrate the networks that are not calibrated yet; return what runs one trial."""
        if self.settings.calibrate:
            names = self.settings.scenarios
            missing = [each for each in names if not calibration_file(str(folder), each).is_file()]
            for _ in executor.map(partial(_calibrate, self.settings, str(folder)), missing):
                pass
        return partial(run_unit, self.settings, str(folder))


def _calibrate(settings: RescoStudySettings, folder: str, name: str) -> None:
    made = study_scenario(f"resco/{name}", settings.horizon_s)
    calibrate(made, CALIBRATION_SEED).save(calibration_file(folder, name))


def run_unit(settings: RescoStudySettings, folder: str, unit: ContenderUnit) -> TrialResult:
    """Train and judge one controller; a run that fails becomes a row that says so (ours).

    The calibrations of its networks are in the folder.
    """
    made = study_scenario(unit.scenario, settings.horizon_s)
    chosen, reward = _trained(settings, unit, made)
    identity: Row = columns_of(unit) | {
        "reward": reward if unit.trains else None,
        "epsilon": _first_epsilon(chosen) if unit.trains else None,
    }
    trained_in = _training_simulator(settings, unit) if unit.trains else None
    row: Row = identity | {
        "study": "resco",
        "horizon_s": made.horizon_s,
        "intersections": len(made.network.intersections),
        "trained_in": trained_in,
        "training_s": made.horizon_s * settings.episodes if unit.trains else None,
    }
    result = TrialResult(unit, [], [])
    places: list[Row] = [
        {"simulator": name, "seed": seed}
        for seed in unit.test_seeds(settings)
        for name in unit.simulators(settings)
    ]
    try:
        make, episodes = _ready(settings, folder, unit, made, chosen, reward)
    except Exception as error:
        status = f"training: {type(error).__name__}: {error}"
        result.runs.extend(row | here | {"status": status} for here in places)
        return result
    result.episodes.extend(identity | {"trained_in": trained_in} | row for row in episodes)
    day, recorder = _day(settings, made), FlowRecorder()
    for here in places:
        vehicles, seed = vehicles_of_seed(day, here["seed"]), here["seed"]
        try:
            simulator = _simulator(settings, folder, unit.scenario, here["simulator"], judging=True)
            run = evaluate(
                simulator, make(), vehicles, make_reward(reward), seed, observers=[recorder]
            )
        except Exception as error:
            result.runs.append(row | here | {"status": f"{type(error).__name__}: {error}"})
            continue
        measured = measures_row(run.measures, run.memory[-1])
        locked = locks_of(recorder.flow, made.network, vehicles)
        measured |= {"locked": len(locked), "locked_from_s": locked[0].since_s if locked else None}
        result.runs.append(row | here | measured | {"status": "ok"})
        result.series.extend(identity | here | each for each in series_rows(run))
    return result


@lru_cache(maxsize=2)
def study_scenario(name: str, horizon_s: int | None) -> Scenario:
    """Return a scenario of the study; the last ones stay, with all that is derived from them."""
    return scenario(name, horizon_s=horizon_s)


def _day(settings: RescoStudySettings, made: Scenario) -> Scenario:
    """Return the scenario that controllers are judged in: the recorded day, or others like it."""
    if not settings.resample:
        return made
    return replace(made, demand=resampled(made.demand, SHIFT_S))


def calibration_file(folder: str, name: str) -> Path:
    """Return where the calibration of a network is kept in a study's folder (ours)."""
    return Path(folder) / "calibrations" / f"{name.removeprefix('resco/')}.json"


# Two networks with four simulators each: workers go through the plan in its order.
@lru_cache(maxsize=8)
def _simulator(
    settings: RescoStudySettings, folder: str, scenario_name: str, name: str, *, judging: bool
) -> Simulator:
    made = study_scenario(scenario_name, settings.horizon_s)
    if name == CALIBRATED:
        made = load_calibration(calibration_file(folder, scenario_name)).applied_to(made)
        name = "queue"
    elif name == UNBLOCKED:
        made, name = replace(made, ignore_junction_blocker_s=BLOCKER_S), settings.judge
    emissions = judging and settings.emissions and name != "queue"
    return make_simulator(made, name, emissions=emissions)


def _ready(
    settings: RescoStudySettings,
    folder: str,
    unit: ContenderUnit,
    made: Scenario,
    chosen: Variant,
    reward: str,
) -> tuple[Callable[[], Controller], list[Row]]:
    """Return what makes the controller for a run, learners trained and frozen, and its training.

    Those that learn online begin every run with nothing.
    """
    if not unit.trains:
        return partial(make_controller, chosen.name, chosen.options), []
    learner = make_controller(chosen.name, chosen.options)
    assert isinstance(learner, MemoryController)
    watched, name = EpisodeRecorder(), _training_simulator(settings, unit)
    train(
        made,
        learner,
        make_reward(reward),
        unit.seed,
        episodes=range(settings.episodes),
        observers=[watched],
        simulator=_simulator(settings, folder, unit.scenario, name, judging=False),
    )
    # This study has never kept these two.
    unknown = {"mean_queue_veh": None, "bytes_total": None}
    frozen = frozen_copy(learner, made.network, chosen)
    return lambda: frozen, [row | unknown for row in watched.study_rows()]


def _training_simulator(settings: RescoStudySettings, unit: ContenderUnit) -> str:
    return settings.judge if unit.deep else settings.training_simulator


def _trained(
    settings: RescoStudySettings, unit: ContenderUnit, made: Scenario
) -> tuple[Variant, str]:
    """Return the controller with all options that the study gives it, and its reward."""
    name = unit.controller.name
    if unit.deep:
        decisions = -(-made.horizon_s // made.timing.decision_interval_s)
        schedule = {"training_decisions": settings.episodes * decisions}
        return Variant(name, settings.dqn.model_dump() | schedule), settings.deep_reward
    if not unit.trains:
        return unit.controller, settings.reward
    base = settings.sarsa if name == "sarsa" else settings.dual_memory
    own = {"embedding": unit.embedding, "communication": unit.communication}
    return Variant(name, base.model_dump() | own), settings.reward


def _first_epsilon(chosen: Variant) -> Any:
    """Return the exploration rate at time 0; tables and networks call it otherwise."""
    return chosen.options.get("epsilon", chosen.options.get("epsilon_first"))
