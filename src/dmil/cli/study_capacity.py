"""``dmil study capacity``: which load each controller holds, and what disturbs it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pydantic import Field

from dmil.cli.parameters import Option, options, part_of, split
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
from dmil.studies.capacity import CapacityStudy, CapacityStudySettings

SMALL: dict[str, Any] = {
    "networks": ("grid:1x1*8", "grid:3x3*6"),
    "seeds": 5,
    "horizon_s": 1800,
    "halvings": 2,
}


class CapacityParameters(CapacityStudySettings, RunningParameters):
    """The study of capacity, and how it is run here."""

    small: bool = Field(
        False, description="A quick trial: two grids, five seeds, runs of half an hour."
    )
    out: Path = folder_field("capacity")

    @property
    def study(self) -> CapacityStudySettings:
        """What is run, without where and how."""
        values = dict(part_of(self, CapacityStudySettings))
        if self.small:
            values |= {k: v for k, v in SMALL.items() if k not in self.model_fields_set}
        values["data"] = data_folder(self.data)
        return CapacityStudySettings(**values)


CAPACITY_OPTIONS = (
    Option("controllers", "--controllers", "Study", "NAMES", read=variants, default="nine"),
    Option("networks", "--networks", "Study", "NAMES", read=split, default="all"),
    *options(
        "Study",
        "data DIR; simulator; seeds; first_seed; horizon_s --steps; levels; halvings; tolerance; "
        "disturb; disturbed_load; training_runs; reward; small",
    ),
    *RUNNING,
)


def capacity(settings: CapacityParameters, json: bool) -> None:
    """Run the study of capacity: which load each controller holds, and what disturbs it.

    For every controller, network and seed the load rises until the queue grows, and bisection finds
    the highest load that stays stable. All controllers meet the same vehicles, and those of a lower
    load are among those of a higher one. Then one load is disturbed: a lane is closed, demand
    surges, detectors are dead, counts err, the day is not the one trained on.

    The metrics are that load (higher is better), the average delay in s per vehicle over the load,
    and the time to recover from a disturbance, with 95 % intervals over seeds.

    For example:
        dmil study capacity --data data
        dmil study capacity --networks grid:5x5*6 --out one
        dmil study capacity --networks resco/cologne3*3 --simulator sumo --seeds 5
        dmil study capacity --small --out trial

    Ctrl-C keeps finished searches; repeat the command to continue. The results are byte-identical
    for any number of processes.
    """
    chosen = settings.study
    if chosen.data is None and not chosen.networks:
        say(NO_CITIES)
    run_and_show(CapacityStudy(chosen), settings, json)
