"""What the study of capacity is: every number of it."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field, field_validator

from dmil.experiments.checks import distinct
from dmil.scenarios.model import LONGEST_RUN_S
from dmil.seeding import LARGEST_SEED


class CapacityStudySettings(BaseModel):
    """The study of capacity: controllers × networks × seeds, each at the loads it needs (ours)."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    controllers: tuple[str, ...] = Field(
        (),
        description="Controllers, with options as in max-pressure,approaching=true; by default "
        "rules, plans where there are any, and memories of lanes.",
    )
    networks: tuple[str, ...] = Field(
        (),
        description="Networks, each with its highest load, as in grid:5x5*6, cityflow:jinan_3x4*3 "
        "or resco/cologne3*4; by default three grids and every city in the data folder.",
    )
    data: Path | None = Field(
        None,
        description="Folder with one folder per city in CityFlow format (or with a folder "
        "cityflow of these); without it cities are left out. Also set by the variable "
        "DMIL_DATA.",
    )
    simulator: Literal["queue", "sumo"] = Field(
        "queue", description="Where to run: the queue simulator, or SUMO (extra sumo)."
    )
    seeds: int = Field(20, ge=1, description="Runs per controller and load; seeds 0, 1, …")
    first_seed: int = Field(0, ge=0, le=LARGEST_SEED, description="First seed.")
    horizon_s: int = Field(3600, ge=600, le=LONGEST_RUN_S, description="Length of a run in s.")
    levels: int = Field(
        8, ge=2, le=64, description="Loads of the curve, evenly spaced up to the highest."
    )
    halvings: int = Field(
        4, ge=0, le=16, description="Bisections between the last stable level and the next."
    )
    tolerance: float = Field(
        0.02,
        gt=0,
        lt=1,
        description="Growth of the queue that still counts as none, as a share of the arrivals.",
    )
    disturb: bool = Field(True, description="Also run disturbances.")
    disturbed_load: float = Field(
        0.5, gt=0, le=0.75, description="Load of disturbed runs, as a share of the highest."
    )
    training_runs: int = Field(
        3, ge=1, description="Passes over one day before another one, for controllers that learn."
    )
    reward: str = Field("queue", description="Reward of learners.")

    _distinct = field_validator("controllers", "networks")(distinct)
