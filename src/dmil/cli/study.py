"""``dmil study``: many runs, one report; how a study is run here, and what is said meanwhile."""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import Any

import typer
from pydantic import BaseModel, Field

from dmil.cli.application import FAILED
from dmil.cli.choices import DEMAND_OPTIONS, stopping
from dmil.cli.help import Command, CommandGroup
from dmil.cli.parameters import JOBS, Option, options, part_of, set_option, settings_command, split
from dmil.cli.terminal import Progress, print_json, progress, say, show, show_lines, waiting
from dmil.compilation import is_cold
from dmil.errors import unknown_name
from dmil.experiments.study import Study, run_study
from dmil.experiments.tuning import load_tuned_folder
from dmil.parallel import Executor, make_executor
from dmil.results import Results
from dmil.studies import (
    PRESETS,
    MemoriesStudy,
    PaperStudy,
    PaperStudySettings,
    RescoStudy,
    RescoStudySettings,
)
from dmil.studies.memories import MemoriesStudySettings
from dmil.studies.protocols import ProtocolsStudy, ProtocolsStudySettings
from dmil.studies.registry import terminal_of


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


def _folder(name: str) -> Any:
    text = "Folder for results and report; a study started there is resumed."
    return Field(Path(name), description=text)


class StudyParameters(PaperStudySettings, RunningParameters):
    """The paper's study, and how it is run here."""

    out: Path = _folder("study")


class RescoParameters(RescoStudySettings, RunningParameters):
    """The study on the RESCO benchmark, and how it is run here."""

    out: Path = _folder("resco")


def _presets(text: str) -> list[str]:
    if text == "all":
        return list(PRESETS)
    for name in split(text):
        if name not in PRESETS:
            raise unknown_name("preset", name, [*PRESETS, "all"], where="--preset")
    return split(text)


OPTIONS = (
    Option("presets", "--preset", "Study", "NAMES", read=_presets, default="all"),
    *options(
        "Study",
        "grids NAMES; seeds; first_seed; horizon_s --steps; load; rewards NAMES; "
        "equal_epsilon; complex_readings NAMES; variant_seeds",
    ),
    *DEMAND_OPTIONS,
    set_option(
        "Study",
        help="Value of the study, such as training_epsilon=0.2.",
        example="sarsa.learning_rate=0.2",
    ),
    *RUNNING,
)

RESCO_OPTIONS = (
    Option("scenarios", "--scenarios", "Study", "NAMES", read=split),
    *options(
        "Study",
        "seeds; first_seed; episodes; horizon_s --steps; resample; train_in; judge; calibrate; "
        "emissions; reward",
    ),
    set_option(
        "Study", help="Value of the study, such as episodes=20.", example="sarsa.learning_rate=0.2"
    ),
    *RUNNING,
)

DATA_VARIABLE = "DMIL_DATA"
SMALL: dict[str, Any] = {
    "cells": ("grid:1x1", "grid:3x3*4", "grid:5x5"),
    "seeds": 5,
    "episodes": 2,
    "horizon_s": 1200,
}
"""What --small sets unless it is given."""
NO_CITIES = (
    "Recorded cities are left out, since no data folder was given. Add --data DIR, or set "
    f"{DATA_VARIABLE}, to a folder with one folder per city in CityFlow format."
)


class MemoriesParameters(MemoriesStudySettings, RunningParameters):
    """The study of memories, and how it is run here."""

    small: bool = Field(
        False, description="A quick trial: three cases, five seeds, runs of 20 minutes."
    )
    tuned_in: Path | None = Field(
        None, description="Folder of dmil tune: controllers use the options chosen there."
    )
    out: Path = _folder("memories")

    @property
    def study(self) -> MemoriesStudySettings:
        """What is run, without where and how."""
        values = dict(part_of(self, MemoriesStudySettings))
        if self.small:
            values |= {k: v for k, v in SMALL.items() if k not in self.model_fields_set}
        elif self.data is None and os.environ.get(DATA_VARIABLE):
            values["data"] = Path(os.environ[DATA_VARIABLE])
        if self.tuned_in is not None:
            found = load_tuned_folder(self.tuned_in)
            values["tuned"] = {each.label: each.chosen for each in found} | self.tuned
            values["tuning"] = tuple(each.summary() for each in found)
        return MemoriesStudySettings(**values)


def variants(text: str) -> list[str]:
    """Split at commas, but not before the options of a controller."""
    found: list[str] = []
    for part in split(text):
        if "=" in part and found:
            found[-1] += f",{part}"
        else:
            found.append(part)
    return found


MEMORIES_OPTIONS = (
    Option("controllers", "--controllers", "Study", "NAMES", read=variants, default="all"),
    Option("ablations", "--ablations", "Study", "NAMES", read=variants, default="factored's"),
    Option("cells", "--cells", "Study", "NAMES", read=split, default="all"),
    *options(
        "Study",
        "data DIR; seeds; first_seed; episodes; horizon_s --steps; deep; reward; "
        "tuned_in --tuned FOLDER; small",
    ),
    *RUNNING,
)


class ProtocolsParameters(ProtocolsStudySettings, RunningParameters):
    """The study of protocols, and how it is run here."""

    out: Path = _folder("protocols")


PROTOCOLS_OPTIONS = (
    Option("protocols", "--protocols", "Study", "NAMES", read=split),
    Option("cities", "--cities", "Study", "NAMES", read=split, default="all"),
    Option("controllers", "--controllers", "Study", "NAMES", read=variants),
    *options("Study", "data DIR; seeds; first_seed; shift_s; horizon_s --steps; queue"),
    *RUNNING,
)


study = typer.Typer(cls=CommandGroup, add_completion=False, invoke_without_command=True)


@study.callback()
def _studies(ctx: typer.Context) -> None:
    """Run a whole study and write its report.

    A study runs many controllers on many seeds, stores every run in a folder (Parquet tables, see
    docs/results.md) and turns them into one page of figures, tables and verdicts.

        dmil study paper --help
    """
    if ctx.invoked_subcommand is None:
        ctx.get_help()


@study.command(cls=Command)
@settings_command("study memories", MemoriesParameters, MEMORIES_OPTIONS)
def memories(settings: MemoriesParameters, json: bool) -> None:
    """Run the study of memories: every controller, on grids and cities, under one protocol.

    Rules without memory, the memories that the paper names (SARSA, dual memory, replay, episodic
    control, pattern maps, team values), factored memory and lookahead, on one, nine and 25
    intersections at several loads, and on recorded cities. Learners that need it are trained on
    vehicles that no test uses; then all meet the same vehicles in the same seed.

    The metric is W: the mean wait per vehicle, in s, over an hour. Lower is better. Differences are
    paired, with 95 % intervals over seeds. Also: the bytes and time that a memory takes, and the
    decisions until it outperforms max-pressure.

    For example:
        dmil study memories --data data
        dmil study memories --no-deep --cells grid:5x5,grid:5x5*3 --out two-cells
        dmil study memories --controllers factored,max-pressure,max-pressure,approaching=true
        dmil study memories --small --out trial

    Ctrl-C keeps finished runs; repeat the command to continue. All results except times are
    byte-identical for any number of processes.
    """
    chosen = settings.study
    if chosen.data is None and not chosen.cells:
        say(NO_CITIES)
    run_and_show(MemoriesStudy(chosen), settings, json)


@study.command(cls=Command)
@settings_command("study paper", StudyParameters, OPTIONS)
def paper(settings: StudyParameters, json: bool) -> None:
    """Run the paper's study: 24 architectures of memory and reward, and the baselines.

    Each preset is one reading of what the paper leaves open: literal (as written), decaying (ε
    falls during a run), matched (closest to the paper's magnitudes). In each, all architectures and
    baselines meet the same vehicles in the same seed.

    The metric is W/V_c: the mean wait per vehicle, in s, divided by the vehicles that reached their
    destination by the end of the run. Lower is better. The report compares it with the paper's
    Table II, longest-queue-first and max-pressure, and gives a verdict on each of the paper's
    claims, computed from these runs.

    For example:
        dmil study paper
        dmil study paper --preset literal --grids 1x1,3x3 --seeds 5 --out trial
        dmil study paper --steps 3600 --out long
        dmil study paper --executor ray --ray-address auto --seeds 1000 --out large

    Ctrl-C keeps finished runs; repeat the command to continue. The results are byte-identical for
    any number of processes and interruptions. Settings without an option, such as the size of
    short-term memory, go into a file: --print-config shows all. Marks: [P] stated by the paper, [A]
    assumed because no other reading tried gives its magnitudes, [F] fitted to its table.
    """
    run_and_show(PaperStudy(part_of(settings, PaperStudySettings)), settings, json)


@study.command(cls=Command)
@settings_command("study resco", RescoParameters, RESCO_OPTIONS)
def resco(settings: RescoParameters, json: bool) -> None:
    """Run the study on the RESCO benchmark: real roads, evaluated in SUMO.

    Eight networks with one hour of recorded or synthetic demand, decisions every 10 s, yellow 3 s.
    SARSA and dual memory train in the queue simulator, calibrated by one SUMO run per network, are
    then frozen and evaluated in SUMO on other seeds, against the network's own program, SUMO's
    actuated control, longest-queue-first, max-pressure and random. All are also evaluated in the
    queue simulator: how well the simulators agree is part of the result.

    The metric is the average delay, in s per vehicle: time lost against free flow, plus the wait
    before entering the network. Lower is better. Published numbers are shown for comparison.

    For example:
        dmil study resco
        dmil study resco --scenarios cologne1,ingolstadt1 --seeds 2 --episodes 10 --out small
        dmil study resco --train-in sumo --scenarios cologne8 --out trained-in-sumo

    It needs the extra sumo: pip install 'dmil[sumo]'. Ctrl-C keeps finished runs; repeat the
    command to continue. The results are byte-identical for any number of processes.
    """
    run_and_show(RescoStudy(part_of(settings, RescoStudySettings)), settings, json)


@study.command(cls=Command)
@settings_command("study protocols", ProtocolsParameters, PROTOCOLS_OPTIONS)
def protocols(settings: ProtocolsParameters, json: bool) -> None:
    """Run methods under published protocols, each an exact recipe, on recorded cities.

    A protocol fixes interval, clearance and its kind, phases, begin and measure. A published figure
    stands beside ours under the same recipe only; that it is the same, their max-pressure shows,
    run here. The report also splits gains: method, interval and phases, measure.

    For example:
        dmil study protocols --data data
        dmil study protocols --protocols llmlight-30-5-4 --cities JN1,HZ1 --seeds 1 --no-queue

    Without CityFlow's module its protocols run in the queue simulator, which the report says.
    Ctrl-C keeps finished runs; repeat the command to continue.
    """
    chosen = part_of(settings, ProtocolsStudySettings)
    if chosen.data is None and os.environ.get(DATA_VARIABLE):
        chosen = chosen.model_copy(update={"data": Path(os.environ[DATA_VARIABLE])})
    run_and_show(ProtocolsStudy(chosen), settings, json)
