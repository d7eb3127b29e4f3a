"""Settings of the rules that have some; the same text is the command line's help."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field


class FixedCycleSettings(BaseModel):
    """A fixed cycle."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    green_s: float | None = Field(
        default=None,
        gt=0,
        allow_inf_nan=False,
        description="Green per phase in s; by default that of the network's program, or else one "
        "decision interval. Rounded up to whole decision intervals.",
    )


class GreedySettings(BaseModel):
    """What controllers that serve the phase of the highest score share."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    approaching: bool = Field(
        default=False,
        description="Whether vehicles that arrive within the decision interval count as queued.",
    )
    hysteresis: float = Field(
        default=0.0,
        ge=0,
        allow_inf_nan=False,
        description="Fraction of the lost time that a switch must make up for: 0 none, 1 all; "
        "without lost time it has no effect.",
    )
    guard: bool = Field(
        default=True,
        description="Whether red counts more, the longer it lasts, where shared lanes were "
        "blocked; false: the published rule.",
    )


class LongestQueueFirstSettings(GreedySettings):
    """Longest queue first."""


class MaxPressureSettings(GreedySettings):
    """Max-pressure."""
