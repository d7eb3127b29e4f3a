"""Run one unit: train a controller, freeze it, and judge it in every simulator."""

from __future__ import annotations

from dataclasses import asdict, replace
from functools import lru_cache
from pathlib import Path

from dmil.controllers import Controller, MemoryController, make_controller
from dmil.controllers.variants import Variant
from dmil.demand.recorded import SHIFT_S
from dmil.experiments.contender import frozen_copy
from dmil.experiments.trial import (
    Row,
    TrialResult,
    measures_row,
)
from dmil.rewards import make_reward
from dmil.scenarios import Scenario, scenario
from dmil.scenarios.calibration import load_calibration
from dmil.scenarios.demand_changes import resampled
from dmil.simulation import Simulator, make_simulator
from dmil.studies.resco.plan import ContenderUnit
from dmil.studies.resco.settings import CALIBRATED, RescoStudySettings
from dmil.training import evaluate, train, vehicles_of_seed
from dmil.training.episodes import EpisodeRecorder
from dmil.training.recording import series_rows


def run_unit(settings: RescoStudySettings, folder: str, unit: ContenderUnit) -> TrialResult:
    """Train and judge one controller; a run that fails becomes a row that says so (ours).

    Parameters
    ----------
    settings
        The study.
    folder
        Where the calibrations of its networks are.
    unit
        Who, where, and which seed.
    """
    made = study_scenario(unit.scenario, settings.horizon_s)
    identity: Row = asdict(unit) | {
        "reward": settings.reward if unit.learns else None,
        "epsilon": _options(settings, unit)["epsilon"] if unit.learns else None,
    }
    trained_in = settings.training_simulator if unit.learns else None
    row: Row = identity | {
        "study": "resco",
        "horizon_s": made.horizon_s,
        "trained_in": trained_in,
        "training_s": made.horizon_s * settings.episodes if unit.learns else None,
    }
    result = TrialResult(unit, [], [])
    try:
        controller, episodes = _ready(settings, folder, unit, made)
    except Exception as error:
        status = f"training: {type(error).__name__}: {error}"
        for name in unit.simulators(settings):
            result.runs.append(row | {"simulator": name, "status": status})
        return result
    result.episodes.extend(identity | {"trained_in": trained_in} | row for row in episodes)
    vehicles = vehicles_of_seed(_day(settings, made), unit.seed)
    for name in unit.simulators(settings):
        here: Row = {"simulator": name}
        try:
            simulator = _simulator(settings, folder, unit.scenario, name, judging=True)
            run = evaluate(simulator, controller, vehicles, make_reward(settings.reward), unit.seed)
        except Exception as error:
            result.runs.append(row | here | {"status": f"{type(error).__name__}: {error}"})
            continue
        measured = measures_row(run.measures, run.memory[-1])
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


# Two networks with three simulators each: workers go through the plan in its order.
@lru_cache(maxsize=8)
def _simulator(
    settings: RescoStudySettings, folder: str, scenario_name: str, name: str, *, judging: bool
) -> Simulator:
    made = study_scenario(scenario_name, settings.horizon_s)
    if name == CALIBRATED:
        made = load_calibration(calibration_file(folder, scenario_name)).applied_to(made)
        name = "queue"
    emissions = judging and settings.emissions and name != "queue"
    return make_simulator(made, name, emissions=emissions)


def _ready(
    settings: RescoStudySettings, folder: str, unit: ContenderUnit, made: Scenario
) -> tuple[Controller, list[Row]]:
    """Return the controller that is judged, learners trained and frozen, and its training."""
    if not unit.learns:
        return make_controller(unit.controller), []
    options = _options(settings, unit)
    learner = make_controller(unit.controller, options)
    assert isinstance(learner, MemoryController)
    watched = EpisodeRecorder()
    train(
        made,
        learner,
        make_reward(settings.reward),
        unit.seed,
        episodes=range(settings.episodes),
        observers=[watched],
        simulator=_simulator(
            settings, folder, unit.scenario, settings.training_simulator, judging=False
        ),
    )
    # This study has never kept these two.
    unknown = {"mean_queue_veh": None, "bytes_total": None}
    frozen = frozen_copy(learner, made.network, Variant(unit.controller, options))
    return frozen, [row | unknown for row in watched.study_rows()]


def _options(settings: RescoStudySettings, unit: ContenderUnit) -> dict[str, object]:
    base = settings.sarsa if unit.controller == "sarsa" else settings.dual_memory
    return base.model_dump() | {
        "embedding": unit.embedding,
        "communication": unit.communication,
    }
