"""``dmil study memories``: every memory under one protocol."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from pydantic import Field

from dmil.cli.parameters import Option, settings_command, split
from dmil.cli.study_running import RUNNING, RunningParameters, run_and_show
from dmil.cli.terminal import say
from dmil.experiments.tuning import load_tuned_folder
from dmil.studies import MemoriesStudy
from dmil.studies.memories import MemoriesStudySettings

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
    out: Path = Field(
        Path("memories"),
        description="Folder for results and report; a study started there is resumed.",
    )

    @property
    def study(self) -> MemoriesStudySettings:
        """What is run, without where and how."""
        names = MemoriesStudySettings.model_fields
        values = {name: getattr(self, name) for name in names}
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


OPTIONS = (
    Option("controllers", "--controllers", "Study", "NAMES", read=variants, default="all"),
    Option("ablations", "--ablations", "Study", "NAMES", read=variants, default="factored's"),
    Option("cells", "--cells", "Study", "NAMES", read=split, default="all"),
    Option("data", "--data", "Study", "DIR"),
    Option("seeds", "--seeds", "Study"),
    Option("first_seed", "--first-seed", "Study"),
    Option("episodes", "--episodes", "Study"),
    Option("horizon_s", "--steps", "Study"),
    Option("deep", "--deep", "Study"),
    Option("reward", "--reward", "Study"),
    Option("tuned_in", "--tuned", "Study", "FOLDER"),
    Option("small", "--small", "Study"),
    *RUNNING,
)


@settings_command("study memories", MemoriesParameters, OPTIONS)
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
    study = settings.study
    if study.data is None and not study.cells:
        say(NO_CITIES)
    run_and_show(MemoriesStudy(study), settings, json)
