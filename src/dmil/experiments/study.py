"""The one way to run trials: plan, compile, run in parallel, keep, continue, finish."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, ClassVar, Protocol, TypeVar

from pydantic import BaseModel

from dmil.experiments.store import StudyStore
from dmil.experiments.trial import TrialResult
from dmil.experiments.warm_up import compile_kernels
from dmil.parallel import Executor, LocalExecutor
from dmil.version import __version__

Progress = Callable[[int, int], None]
Trial = TypeVar("Trial")


class Store(Protocol[Trial]):
    """Where results stay: a study's folder, a tuning's file, or memory."""

    def left(self, plan: Sequence[Trial]) -> list[Trial]:
        """Return the trials of a plan that are not kept yet."""

    def keep(self, result: Any) -> None:
        """Keep what a trial gave."""


class Kept(dict[Any, Any]):
    """A store in memory: a trial to its result, a tuple that begins with the trial."""

    def left(self, plan: Sequence[Trial]) -> list[Trial]:
        """Return the trials of a plan that are not kept yet."""
        return [trial for trial in plan if trial not in self]

    def keep(self, result: tuple[Any, ...]) -> None:
        """Keep what a trial gave."""
        self[result[0]] = result


class Study(Protocol[Trial]):
    """What a study is: all its trials, and how one of them is run.

    A trial is what is kept as a whole: one run, or several that share their demand or training. It
    is a data class whose fields are columns of the table of runs, and tell trials apart.

    Attributes
    ----------
    name: str
        What its results say they are of.
    settings: pydantic.BaseModel
        Every number of it.
    """

    name: ClassVar[str]

    @property
    def settings(self) -> BaseModel:
        """Every number of the study."""

    def check(self) -> None:
        """Check what workers would find wrong, before anything is written."""

    def configuration(self) -> dict[str, Any]:
        """Return what makes two studies the same, as JSON."""

    def plan(self) -> Sequence[Trial]:
        """Return all trials, in the order in which they are begun."""

    def prepare(self, folder: Path, executor: Executor) -> Callable[[Trial], TrialResult]:
        """Make what all trials need, and return what runs one; it goes to other processes."""


def run_study(
    study: Study[Any],
    folder: Path,
    *,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> None:
    """Run a study into a folder; a folder that holds part of it is continued (specification, §7).

    The results, but for measured times, are the same bytes whatever the executor and however often
    the study was interrupted. If it is interrupted, finished trials are kept.

    Parameters
    ----------
    study
        What to run.
    folder
        Where to; made if missing.
    executor
        Where runs happen; processes of this machine by default.
    progress
        Called with the finished trials and all trials, first with those kept from before.

    Raises
    ------
    InputError
        Something that the study names does not exist, or a run is too short.
    MissingExtraError
        It needs a package that is not installed.
    OutputError
        The folder cannot be used.
    """
    study.check()
    started, clock = datetime.now(UTC), time.perf_counter()
    with StudyStore(folder, identity_of(study)) as store:
        plan = study.plan()
        if store.complete:
            (progress or _silent)(len(plan), len(plan))
            return
        kept = run_trials(
            plan,
            store,
            lambda where: study.prepare(folder, where),
            executor=executor,
            progress=progress,
        )
        store.finish(
            {
                "study": store.identity["study"],
                "configuration": store.identity["configuration"],
                "started": started.isoformat(timespec="seconds"),
                "finished": datetime.now(UTC).isoformat(timespec="seconds"),
                "wall_s": round(time.perf_counter() - clock, 3),
                "blocks_kept_from_before": kept,
            }
        )


def run_trials(
    plan: Sequence[Trial],
    store: Store[Trial],
    prepare: Callable[[Executor], Callable[[Trial], Any]],
    *,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> int:
    """Run the trials of a plan that are not kept yet; keep each result as it comes.

    ``prepare`` makes what runs a trial; it is not called if none is left. Return how many were kept
    before.
    """
    executor, progress = executor or LocalExecutor(), progress or _silent
    todo = store.left(plan)
    before = len(plan) - len(todo)
    progress(before, len(plan))
    if todo:
        compile_kernels(executor)
        for done, result in enumerate(executor.map(prepare(executor), todo), before + 1):
            store.keep(result)
            progress(done, len(plan))
    return before


def identity_of(study: Study[Any]) -> dict[str, Any]:
    """Return what makes two studies the same: configuration and version of the program."""
    return {
        "study": study.name,
        "dmil": __version__,
        "configuration": study.configuration(),
    }


def _silent(done: int, total: int) -> None:
    pass
