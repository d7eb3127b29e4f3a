"""What the study of protocols is: every number of it."""

from __future__ import annotations

from pathlib import Path

from pydantic import BaseModel, ConfigDict, Field, field_validator

from dmil.experiments.checks import distinct
from dmil.scenarios.model import LONGEST_RUN_S
from dmil.seeding import LARGEST_SEED
from dmil.studies.protocols.recipes import HORIZON_S, PROTOCOLS
from dmil.studies.protocols.rule import NAME

CONTROLLERS = (
    NAME,
    "fixed-cycle",
    "max-pressure",
    "max-pressure,approaching=true",
    "longest-queue-first,approaching=true",
    "factored",
    "lookahead",
    "combined",
)


class ProtocolsStudySettings(BaseModel):
    """The study of protocols: methods × published recipes × cities (ours)."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    protocols: tuple[str, ...] = Field(
        tuple(PROTOCOLS), min_length=1, description="Protocols by name."
    )
    cities: tuple[str, ...] = Field(
        (), description="Recorded days by name, such as JN1; by default all there are."
    )
    controllers: tuple[str, ...] = Field(
        CONTROLLERS, min_length=1, description="Controllers, untrained, with options."
    )
    data: Path | None = Field(
        None, description="Folder with one folder per city in CityFlow format. Also DMIL_DATA."
    )
    seeds: int = Field(
        6, ge=1, description="Days: seed 0 is the recorded one, others have moved departures."
    )
    first_seed: int = Field(0, ge=0, le=LARGEST_SEED, description="First seed.")
    shift_s: int = Field(30, ge=0, description="Maximum move of a departure in s.")
    horizon_s: int = Field(HORIZON_S, ge=20, le=LONGEST_RUN_S, description="Length of a run in s.")
    queue: bool = Field(True, description="Run the same protocols in the queue simulator, too.")

    _distinct = field_validator("protocols", "cities", "controllers")(distinct)
