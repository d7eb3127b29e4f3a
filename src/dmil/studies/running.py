"""What all studies share: plan, run in parallel, keep, continue, finish."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from datetime import UTC, datetime
from typing import Any, TypeVar

from dmil.studies.block import BlockResult
from dmil.studies.executors import Executor, LocalExecutor
from dmil.studies.store import StudyStore

Progress = Callable[[int, int], None]
Unit = TypeVar("Unit")


def run_units(
    store: StudyStore,
    plan: Sequence[Unit],
    prepare: Callable[[], Callable[[Unit], BlockResult]],
    *,
    executor: Executor | None,
    progress: Progress | None,
) -> None:
    """Run what a study's folder does not hold yet, keep each unit, and finish the folder (ours).

    Parameters
    ----------
    store
        The open folder.
    plan
        All units of the study.
    prepare
        Called once if there is anything to run; returns what runs one unit.
    executor
        Where runs happen; processes of this machine by default.
    progress
        Called with the finished units and all units, first with those kept from before.
    """
    started, clock = datetime.now(UTC), time.perf_counter()
    tell = progress or (lambda done, total: None)
    if store.complete:
        tell(len(plan), len(plan))
        return
    finished = store.finished()
    todo = [unit for unit in plan if unit not in finished]
    done = len(plan) - len(todo)
    tell(done, len(plan))
    if todo:
        for result in (executor or LocalExecutor()).map(prepare(), todo):
            store.keep(result)
            done += 1
            tell(done, len(plan))
    identity: dict[str, Any] = store.identity
    store.finish(
        {
            "study": identity["study"],
            "configuration": identity["configuration"],
            "started": started.isoformat(timespec="seconds"),
            "finished": datetime.now(UTC).isoformat(timespec="seconds"),
            "wall_s": round(time.perf_counter() - clock, 3),
            "blocks_kept_from_before": len(finished),
        }
    )
