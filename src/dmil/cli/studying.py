"""How a study is run from the command line, and what is said meanwhile."""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import Any

import typer
from pydantic import BaseModel, Field

from dmil.cli.application import FAILED
from dmil.cli.choices import stopping
from dmil.cli.parameters import JOBS, Option, options, split
from dmil.cli.terminal import Progress, print_json, progress, say, show, show_lines, waiting
from dmil.compilation import is_cold
from dmil.experiments.study import Study, run_study
from dmil.parallel import Executor, make_executor
from dmil.results import Results
from dmil.studies.registry import terminal_of

DATA_VARIABLE = "DMIL_DATA"
NO_CITIES = (
    "Recorded cities are left out, since no data folder was given. Add --data DIR, or set "
    f"{DATA_VARIABLE}, to a folder with one folder per city in CityFlow format."
)


class RunningParameters(BaseModel):
    """How a study is run here."""

    jobs: int | None = JOBS
    executor: str = Field(
        "local", description="Where to run: local (processes) or ray (extra 'ray')."
    )
    ray_address: str | None = Field(
        None, description="Address of a Ray cluster; by default Ray is started locally."
    )
    report: bool = Field(True, description="Also write the report.")

    def make_executor(self) -> Executor:
        """Make what runs it."""
        return make_executor(self.executor, jobs=self.jobs, address=self.ray_address)


RUNNING = (
    *options("Running", "out DIR; jobs; executor; ray_address ADDRESS"),
    Option("report", "--report", "Output"),
)


def run_and_show(study: Study[Any], settings: Any, as_json: bool) -> None:
    """Run a study with progress, write its report, and say what came out.

    Ctrl-C ends it with what is finished, by a `StoppedError`.
    """
    started = time.perf_counter()
    _run(study, settings)
    terminal = terminal_of(study.name)
    with Results(settings.out) as results:
        tables = terminal.tables_of(results)
        counts = results.query("select count(*) n, count(*) filter (status <> 'ok') f from runs")
        failures = results.query("select controller, status from runs where status <> 'ok' limit 1")
    page = _report_of(settings.out, tables) if settings.report else None
    wall_s = round(time.perf_counter() - started, 3)
    count, failed = counts.row(0)
    if as_json:
        ending = {"wall_s": wall_s, "runs": count, "failed": failed}
        print_json(terminal.as_json(tables) | ending | {"out": settings.out, "report": page})
    else:
        for part in terminal.in_terminal(tables):
            if isinstance(part, list):
                show_lines(part)
            else:
                show(part, "")
        where = page or f"dmil report {settings.out}"
        show("", f"{count} runs, {wall_s:.1f} s", f"Report: {where}")
    if failed:
        controller, status = failures.row(0)
        say(f"{failed} runs failed, the first ({controller}) with: {status}")
        raise typer.Exit(FAILED)


def _run(study: Study[Any], settings: Any) -> None:
    executor = settings.make_executor()
    kept = f"finished runs are kept in {settings.out}; repeat the command to continue"
    with stopping(kept), progress("blocks", first_word="starting") as advance:
        run_study(study, settings.out, executor=executor, progress=_telling(advance))


def _telling(advance: Progress) -> Progress:
    """Say what happens before the first block is finished, where it takes a while."""
    begun: list[bool] = []

    def tell(done: int, total: int) -> None:
        if not begun:
            begun.append(True)
            if done == total:
                say(
                    f"This study is already complete in the folder, all {total} blocks: nothing to "
                    "run."
                )
                return
            if is_cold():
                say("First start: compiling the kernels once, about half a minute.")
        advance(done, total)

    return tell


def _report_of(folder: Path, tables: Any) -> Path:
    from dmil.studies.report import write_report

    with waiting("writing the report"):
        return write_report(folder, tables=tables)


def folder_field(name: str) -> Any:
    """Return the field of a study's folder, by default of that name."""
    text = "Folder for results and report; a study started there is resumed."
    return Field(Path(name), description=text)


def variants(text: str) -> list[str]:
    """Split at commas, but not before the options of a controller."""
    found: list[str] = []
    for part in split(text):
        if "=" in part and found:
            found[-1] += f",{part}"
        else:
            found.append(part)
    return found


def data_folder(given: Path | None) -> Path | None:
    """Return the folder of recorded cities: the one given, or that of the environment variable."""
    named = os.environ.get(DATA_VARIABLE)
    return Path(named) if given is None and named else given
