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
        description="Controllers, with options as in max-pressure,approaching=true; by default "
        "all applicable ones.",
    )
    ablations: tuple[str, ...] = Field(
        (),
        description="Ablations, which the report shows in a separate table; by default factored "
        "memory without one component each, or none if controllers are chosen; 'none': none.",
    )
    cells: tuple[str, ...] = Field(
        (),
        description="Networks with demand, as in grid:5x5*3 (three times the vehicles) or "
        "cityflow:jinan_3x4; by default ten on grids and every city in the data folder.",
    )
    data: Path | None = Field(
        None,
        description="Folder with one folder per city in CityFlow format (or with a folder "
        "cityflow of these); without it cities are left out. Also set by the variable "
        "DMIL_DATA.",
    )
    seeds: int = Field(30, ge=1, description="Runs per controller and case; seeds 0, 1, …")
    first_seed: int = Field(0, ge=0, le=LARGEST_SEED, description="First seed.")
    episodes: int = Field(
        5,
        ge=1,
        description="Training runs of learners; their random numbers differ from all tests.",
    )
    horizon_s: int = Field(3600, ge=20, le=LONGEST_RUN_S, description="Length of a run in s.")
    deep: bool = Field(True, description="Also run deep rivals (extra deep).")
    reward: str = Field(REWARD, description="Reward of learners.")
    rewards: dict[str, str] = Field(
        {"sarsa": "diffusion", "dual-memory": "diffusion"},
        description="Controllers with another reward.",
    )
    untrained: tuple[str, ...] = Field(
        ("factored", "lookahead", "combined"),
        description="Untrained learners: they learn from the first second of the test.",
    )
    tuned: dict[str, dict[str, Any]] = Field(
        {},
        description="Controllers, with or without options, to the options found by dmil tune.",
    )
    tuning: tuple[dict[str, Any], ...] = Field(
        (), description="How these were found, for the report: budget, best against defaults."
    )

    _distinct = field_validator("controllers", "ablations", "cells")(distinct)
