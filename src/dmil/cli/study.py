"""``dmil study``: many runs, one report."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import typer
from pydantic import Field

from dmil.cli.choices import DEMAND_OPTIONS
from dmil.cli.help import Command, CommandGroup
from dmil.cli.parameters import Option, options, part_of, set_option, settings_command, split
from dmil.cli.study_ablation import ablation
from dmil.cli.study_capacity import CAPACITY_OPTIONS, CapacityParameters, capacity
from dmil.cli.study_protocols import PROTOCOLS_OPTIONS, ProtocolsParameters, protocols
from dmil.cli.studying import (
    NO_CITIES,
    RUNNING,
    RunningParameters,
    data_folder,
    folder_field,
    run_and_show,
    variants,
)
from dmil.cli.terminal import say
from dmil.errors import unknown_name
from dmil.experiments.tuning import load_tuned_folder
from dmil.studies import (
    PRESETS,
    MemoriesStudy,
    PaperStudy,
    PaperStudySettings,
    RescoStudy,
    RescoStudySettings,
)
from dmil.studies.memories import MemoriesStudySettings


class StudyParameters(PaperStudySettings, RunningParameters):
    """The paper's study, and how it is run here."""

    out: Path = folder_field("study")


class RescoParameters(RescoStudySettings, RunningParameters):
    """The study on the RESCO benchmark, and how it is run here."""

    out: Path = folder_field("resco")


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
        "seeds; first_seed; lock_seeds; episodes; horizon_s --steps; resample; train_in; judge; "
        "calibrate; unblocked; emissions; reward; deep; deep_seeds",
    ),
    set_option(
        "Study", help="Value of the study, such as episodes=20.", example="sarsa.learning_rate=0.2"
    ),
    *RUNNING,
)

SMALL: dict[str, Any] = {
    "cells": ("grid:1x1", "grid:3x3*4", "grid:5x5"),
    "seeds": 5,
    "episodes": 2,
    "horizon_s": 1200,
}
"""What --small sets unless it is given."""


class MemoriesParameters(MemoriesStudySettings, RunningParameters):
    """The study of memories, and how it is run here."""

    small: bool = Field(
        False, description="A quick trial: three cases, five seeds, runs of 20 minutes."
    )
    tuned_in: Path | None = Field(
        None, description="Folder of dmil tune: controllers use the options chosen there."
    )
    out: Path = folder_field("memories")

    @property
    def study(self) -> MemoriesStudySettings:
        """What is run, without where and how."""
        values = dict(part_of(self, MemoriesStudySettings))
        if self.small:
            values |= {k: v for k, v in SMALL.items() if k not in self.model_fields_set}
        else:
            values["data"] = data_folder(self.data)
        if self.tuned_in is not None:
            found = load_tuned_folder(self.tuned_in)
            values["tuned"] = {each.label: each.chosen for each in found} | self.tuned
            values["tuning"] = tuple(each.summary() for each in found)
        return MemoriesStudySettings(**values)


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


study.command(cls=Command)(ablation)
study.command(cls=Command)(
    settings_command("study capacity", CapacityParameters, CAPACITY_OPTIONS)(capacity)
)
study.command(cls=Command)(
    settings_command("study protocols", ProtocolsParameters, PROTOCOLS_OPTIONS)(protocols)
)


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

    Eight networks with one hour of recorded or synthetic demand, decisions every 10 s, yellow 3 s
    (arterial4x4: 5 s and 2 s). Rules and memories of lanes run as they are. SARSA and dual memory
    train in the queue simulator, calibrated by one SUMO run per network, and are then frozen and
    evaluated in SUMO on other seeds; with --deep DQN trains in SUMO itself. SUMO is run twice: as
    the benchmark has it, where junctions can lock for good, and with blockers ignored. All are also
    evaluated in the queue simulator: how well the simulators agree is part of the result.

    The metric is the average delay, in s per vehicle: time lost against free flow, plus the wait
    before entering the network. Lower is better. Published numbers are shown for comparison.

    For example:
        dmil study resco
        dmil study resco --scenarios cologne1,ingolstadt1 --seeds 2 --episodes 10 --out small
        dmil study resco --train-in sumo --scenarios cologne8 --out trained-in-sumo
        dmil study resco --deep --scenarios ingolstadt7 --out deep

    It needs the extra sumo: pip install 'dmil[sumo]'. Ctrl-C keeps finished runs; repeat the
    command to continue. The results are byte-identical for any number of processes.
    """
    run_and_show(RescoStudy(part_of(settings, RescoStudySettings)), settings, json)
