"""What the commands of all studies share: how a study is run here, and what is said meanwhile."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from pydantic import BaseModel, Field

from dmil.cli.application import StoppedError
from dmil.cli.parameters import Option
from dmil.cli.terminal import Progress, progress, say, waiting
from dmil.compilation import is_cold
from dmil.studies import Executor, make_executor


class RunningParameters(BaseModel):
    """How a study is run here."""

    jobs: int | None = Field(
        None, ge=1, description="Parallel processes; by default one per core. Same results."
    )
    executor: str = Field(
        "local", description="Where runs happen: local (processes) or ray (extra 'ray')."
    )
    ray_address: str | None = Field(
        None, description="Address of a Ray cluster; without it Ray is started here."
    )
    report: bool = Field(True, description="Whether to write the report, too.")

    def make_executor(self) -> Executor:
        """Make what runs it."""
        return make_executor(self.executor, jobs=self.jobs, address=self.ray_address)


RUNNING = (
    Option("out", "--out", "Running", "DIR"),
    Option("jobs", "--jobs", "Running"),
    Option("executor", "--executor", "Running"),
    Option("ray_address", "--ray-address", "Running", "ADDRESS"),
    Option("report", "--report", "Output"),
)


def run_here(run_study: Callable[..., None], settings: Any) -> None:
    """Run a study with progress; Ctrl-C ends it with what is finished (ours).

    Parameters
    ----------
    run_study
        Takes settings and folder, and the keywords executor and progress.
    settings
        Running parameters with ``study`` and ``out``.

    Raises
    ------
    StoppedError
        At Ctrl-C.
    """
    executor = settings.make_executor()
    with progress("blocks", first_word="starting") as advance:
        try:
            run_study(settings.study, settings.out, executor=executor, progress=_telling(advance))
        except KeyboardInterrupt:
            raise StoppedError(
                f"what is finished is kept in {settings.out}; the same command continues"
            ) from None


def _telling(advance: Progress) -> Progress:
    """Say what happens before the first block is finished, where it takes a while."""
    begun: list[bool] = []

    def tell(done: int, total: int) -> None:
        if not begun:
            begun.append(True)
            if done == total:
                say(f"The folder holds this study complete, all {total} blocks: nothing to run.")
                return
            if is_cold():
                say("First start: the kernels are compiled once, which takes about half a minute.")
        advance(done, total)

    return tell


def report_of(folder: Path, tables: Any) -> Path:
    """Write a study's report, and return its page (ours).

    Parameters
    ----------
    folder
        The study.
    tables
        Its tables.
    """
    from dmil.reports import write_report

    with waiting("writing the report"):
        return write_report(folder, tables=tables)
