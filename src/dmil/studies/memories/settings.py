"""What the study of memories is: every number of it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, Field, field_validator

from dmil.experiments.checks import distinct
from dmil.scenarios.model import LONGEST_RUN_S
from dmil.seeding import LARGEST_SEED

REWARD = "queue"


class MemoriesStudySettings(BaseModel):
    """The study of memories: controllers × networks and demands × seeds (ours)."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    controllers: tuple[str, ...] = Field(
        (),
        description="Controllers, with options as in max-pressure,approaching=true; by default all "
        "that make sense.",
    )
    ablations: tuple[str, ...] = Field(
        (),
        description="More controllers, which the report shows in a table of their own; by default "
        "factored memory without one ingredient each, or nobody beside chosen controllers; "
        "'none': nobody.",
    )
    cells: tuple[str, ...] = Field(
        (),
        description="Networks with demand, as in grid:5x5*3 (three times the vehicles) or "
        "cityflow:jinan_3x4; by default ten on grids and every city in the folder of data.",
    )
    data: Path | None = Field(
        None,
        description="Folder with a folder per city in CityFlow's format (or with a folder cityflow "
        "of these); without it those cities are left out. The variable DMIL_DATA does the same.",
    )
    seeds: int = Field(30, ge=1, description="Runs per controller and cell; seeds 0, 1, …")
    first_seed: int = Field(0, ge=0, le=LARGEST_SEED, description="First of the seeds.")
    episodes: int = Field(
        5,
        ge=1,
        description="Training runs of those that are trained; their chance is never a test's.",
    )
    horizon_s: int = Field(3600, ge=20, le=LONGEST_RUN_S, description="Length of a run in s.")
    deep: bool = Field(True, description="Whether deep rivals run, too (extra deep).")
    reward: str = Field(REWARD, description="What learners get.")
    rewards: dict[str, str] = Field(
        {"sarsa": "diffusion", "dual-memory": "diffusion"},
        description="Controllers that get another reward.",
    )
    untrained: tuple[str, ...] = Field(
        ("factored", "lookahead"),
        description="Learners that begin with the test: they learn from its first second.",
    )
    tuned: dict[str, dict[str, Any]] = Field(
        {},
        description="Controllers, with or without options, to options that dmil tune has found.",
    )
    tuning: tuple[dict[str, Any], ...] = Field(
        (), description="How these were found, for the report: budget, best against defaults."
    )

    _distinct = field_validator("controllers", "ablations", "cells")(distinct)
