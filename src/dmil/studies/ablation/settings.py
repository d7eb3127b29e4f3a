"""What the ablation is: every number of it."""

from __future__ import annotations

from pathlib import Path

from pydantic import BaseModel, ConfigDict, Field, field_validator

from dmil.experiments.checks import distinct
from dmil.scenarios.model import LONGEST_RUN_S
from dmil.seeding import LARGEST_SEED


class AblationStudySettings(BaseModel):
    """The ablation: controllers × parts × networks and demands × seeds (ours)."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    cells: tuple[str, ...] = Field(
        ("grid:3x3", "grid:5x5", "grid:5x5*3"),
        min_length=1,
        description="Networks with demand, as in grid:5x5*3 (three times the vehicles) or "
        "cityflow:jinan_3x4, in the queue simulator; resco/cologne1 and sumo:FILE.sumocfg in SUMO.",
    )
    controllers: tuple[str, ...] = Field(
        ("combined", "factored", "lookahead"),
        min_length=1,
        description="Controllers whose parts are switched; each at least one of them.",
    )
    parts: tuple[str, ...] = Field(
        (), description="Parts that are switched one by one; by default all."
    )
    data: Path | None = Field(
        None,
        description="Folder with one folder per city in CityFlow format (or with a folder "
        "cityflow of these). Also set by the variable DMIL_DATA.",
    )
    seeds: int = Field(20, ge=1, description="Runs per variant and case; seeds 0, 1, …")
    first_seed: int = Field(0, ge=0, le=LARGEST_SEED, description="First seed.")
    horizon_s: int = Field(3600, ge=20, le=LONGEST_RUN_S, description="Length of a run in s.")

    _distinct = field_validator("cells", "controllers", "parts")(distinct)
