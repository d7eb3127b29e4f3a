"""The study of memories: every controller, on grids and recorded cities, under one protocol."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from dmil.controllers import CONTROLLERS, Controller, make_controller
from dmil.controllers.registry import make_settings
from dmil.demand import Vehicles
from dmil.errors import InputError
from dmil.experiments.cells import Cell
from dmil.experiments.checks import check_horizon
from dmil.experiments.trial import (
    SIMULATOR,
    Row,
    TrialResult,
    columns_of,
    measures_row,
)
from dmil.parallel import Executor
from dmil.rewards import make_reward
from dmil.scenarios import Scenario
from dmil.simulation import QueueSimulator
from dmil.studies.memories.plan import (
    REFERENCE,
    MemoriesUnit,
    ablations,
    cells,
    contenders,
    fits,
    is_trained,
    learns,
    options_of,
    units,
)
from dmil.studies.memories.settings import MemoriesStudySettings
from dmil.training import evaluate, train, vehicles_of_seed
from dmil.training.episodes import EpisodeRecorder
from dmil.training.recording import series_rows

SERIES_EVERY_S = 60
"""The course of a run is kept at about this distance."""
Courses = tuple[npt.NDArray[np.int32], ...]
WINDOW_S = 900
"""Queues are compared over a quarter of an hour: shorter, and chance alone turns the sign."""


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


def run_unit(settings: MemoriesStudySettings, unit: MemoriesUnit) -> TrialResult:
    """Train and test one controller; a run that fails becomes a row that says so (ours)."""
    made, simulator = _place(unit.cell, settings.horizon_s, settings.data)
    trained = is_trained(settings, unit.controller)
    identity = _identity(settings, unit)
    row: Row = identity | {
        "study": "memories",
        "horizon_s": made.horizon_s,
        "intersections": len(made.network.intersections),
        "trained_in": SIMULATOR if trained else None,
        "training_s": made.horizon_s * settings.episodes if trained else None,
    }
    result = TrialResult(unit, [], [])
    reward = make_reward(identity["reward"] or settings.reward)
    where, started = "training", time.perf_counter()
    watched = EpisodeRecorder()
    try:
        controller = make_controller(unit.controller.name, options_of(settings, unit.controller))
        if trained:
            more: dict[str, Any] = {"observers": [watched], "simulator": simulator}
            train(made, controller, reward, unit.seed, episodes=range(settings.episodes), **more)
        training_wall_s = time.perf_counter() - started
        where, before = "the test", lookups_of(controller)
        vehicles = _vehicles(unit.cell, settings.horizon_s, settings.data, unit.seed)
        run = evaluate(simulator, controller, vehicles, reward, unit.seed)
    except Exception as error:
        if where == "training":
            where = f"episode {len(watched.rows)} of the training"
        result.runs.append(row | {"status": f"{type(error).__name__}: {error} (in {where})"})
        return result
    finally:
        trained_in = {"trained_in": SIMULATOR}
        result.episodes.extend(identity | trained_in | row for row in watched.study_rows())
    if learns(unit.controller):
        count = settings.episodes if trained else 0
        courses = _reference_courses(unit.cell, settings.horizon_s, settings.data, unit.seed, count)
        row["decisions_until_better"] = decisions_until_better(
            [each.measures.queued_at for each in (*watched.runs, run)],
            courses,
            made.timing.decision_interval_s,
        )
    result.runs.append(row | measures_row(run.measures, run.memory[-1]) | {"status": "ok"})
    result.series.extend(identity | each for each in _thinned(series_rows(run)))
    result.lookups.extend(
        identity | {"source": source, "lookups": count - before.get(source, 0)}
        for source, count in lookups_of(controller).items()
    )
    times = {"decisions": run.decisions, "decide_s": run.decide_s}
    result.timings.append(
        identity | times | {"training_wall_s": training_wall_s if trained else None}
    )
    return result


def lookups_of(controller: Controller) -> dict[str, int]:
    """Return how often a controller has read its memory, by source; empty if it does not count."""
    count = getattr(controller, "lookups", None)
    return {} if count is None else {name: int(number) for name, number in count().items()}


@lru_cache(maxsize=2)
def _place(cell: Cell, horizon_s: int, data: Path | None) -> tuple[Scenario, QueueSimulator]:
    """Return a cell's scenario and simulator; the last ones stay, with all derived from them."""
    made = cell.build(horizon_s, data)
    return made, QueueSimulator(made)


# The units of one cell and seed follow each other, and their simulator knows the vehicles again.
@lru_cache(maxsize=2)
def _vehicles(cell: Cell, horizon_s: int, data: Path | None, seed: int) -> Vehicles:
    """Return the vehicles of a test."""
    made, _ = _place(cell, horizon_s, data)
    return vehicles_of_seed(made, seed)


# The learners of one cell and seed follow each other in the plan.
@lru_cache(maxsize=2)
def _reference_courses(
    cell: Cell, horizon_s: int, data: Path | None, seed: int, episodes: int
) -> Courses:
    """Return max-pressure's queue in every second of the training episodes and of the test."""
    made, simulator = _place(cell, horizon_s, data)
    controller, reward = make_controller(REFERENCE), make_reward("queue")
    runs = train(made, controller, reward, seed, episodes=range(episodes), simulator=simulator)
    vehicles = _vehicles(cell, horizon_s, data, seed)
    runs.append(evaluate(simulator, controller, vehicles, reward, seed))
    return tuple(run.measures.queued_at for run in runs)


def _identity(settings: MemoriesStudySettings, unit: MemoriesUnit) -> Row:
    """Return what tells the run from all others, and what it learns with."""
    name = unit.controller.name
    entry = CONTROLLERS.get(name)
    options: Any = None
    if entry is not None and entry.settings is not None:
        where = f"controller '{name}'"
        options = make_settings(entry.settings, options_of(settings, unit.controller), where=where)
    reward = settings.rewards.get(name, settings.reward)
    return columns_of(unit) | {
        "embedding": getattr(options, "embedding", None),
        "communication": getattr(options, "communication", False),
        "reward": reward if learns(unit.controller) else None,
        "epsilon": getattr(options, "epsilon", None),
        "simulator": SIMULATOR,
    }


def _thinned(rows: list[Row]) -> list[Row]:
    """Return the first row of every minute, and the last of all."""
    kept, until = [], 0
    for row in rows[:-1]:
        if row["time_s"] >= until:
            kept.append(row)
            until = row["time_s"] - row["time_s"] % SERIES_EVERY_S + SERIES_EVERY_S
    return [*kept, rows[-1]]


def decisions_until_better(
    queued_veh: Sequence[npt.NDArray[np.integer]],
    reference_veh: Sequence[npt.NDArray[np.integer]],
    decision_interval_s: int,
    *,
    window_s: int = WINDOW_S,
) -> int | None:
    """Return the decisions after which a queue stays below another on the same vehicles (ours).

    All runs of a learner's life follow each other: its training, then its test. From the decision
    returned on, the mean queue over every window is below the reference's over that window.

    Parameters
    ----------
    queued_veh, reference_veh
        For every run, (seconds,) vehicles waiting, in order; the same of the reference.
    decision_interval_s
        Time between two decisions.
    window_s
        Length of the windows; a life shorter than that is one window.

    Returns
    -------
    Decisions, counted from the first of all; None if the last window is not better.
    """
    pairs = zip(queued_veh, reference_veh, strict=True)
    difference = np.concatenate([np.subtract(*pair, dtype=np.int64) for pair in pairs])
    window = min(window_s, len(difference))
    total = np.concatenate([[0], np.cumsum(difference)])
    worse = np.flatnonzero(total[window:] - total[:-window] >= 0)
    if not worse.size:
        return 0
    begin = int(worse[-1]) + 1
    if begin > len(difference) - window:
        return None
    return -(-begin // decision_interval_s)
