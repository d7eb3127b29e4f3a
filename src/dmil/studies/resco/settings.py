"""What the study on the RESCO benchmark is: every number of it."""

from __future__ import annotations

from typing import Literal, Self

from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator

from dmil.controllers.tabular.settings import DualMemorySettings, SarsaSettings
from dmil.experiments.checks import SET_BY_THE_STUDY, check_left_open, distinct
from dmil.scenarios.names import PREFIX, RESCO

NETWORKS = tuple(name.removeprefix(PREFIX) for name in RESCO)
"""All networks of the benchmark."""
CALIBRATED = "queue-calibrated"
"""Name of the queue simulator with numbers measured in SUMO."""


class RescoStudySettings(BaseModel):
    """The study on the RESCO benchmark (protocol: Ault and Sharon 2021; controllers ours)."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    scenarios: tuple[str, ...] = Field(
        NETWORKS, min_length=1, description="RESCO networks, without the prefix resco/."
    )
    seeds: int = Field(5, ge=1, description="Runs per controller; seeds 0, 1, …")
    first_seed: int = Field(0, ge=0, description="First seed.")
    episodes: int = Field(100, ge=1, description="Training runs per learner, never on test seeds.")
    horizon_s: int | None = Field(
        None, ge=20, description="Length of a run in s; by default RESCO's hour."
    )
    resample: bool = Field(
        False,
        description="Evaluate every seed on a day resampled from the recorded vehicles, with "
        "slightly shifted departures; RESCO has one day.",
    )
    train_in: Literal["queue", "sumo"] = Field(
        "queue", description="Simulator for training; evaluation is in SUMO either way."
    )
    judge: Literal["sumo", "sumo-meso"] = Field(
        "sumo",
        description="SUMO model for evaluation. The calibration always measures the microscopic "
        "one and is not valid for the mesoscopic.",
    )
    calibrate: bool = Field(
        True,
        description="Calibrate the queue simulator by one SUMO run per network, and train with it.",
    )
    emissions: bool = Field(True, description="Have SUMO compute CO2 and fuel.")
    reward: str = Field("diffusion", description="Reward of learners.")
    sarsa: SarsaSettings = Field(
        SarsaSettings(epsilon=0.1, guard=False), description="Non-memory agent, exact states."
    )
    dual_memory: DualMemorySettings = Field(
        DualMemorySettings(epsilon=0.1, guard=False),
        description="Memory-based agent; the study sets classes and communication.",
    )

    _distinct = field_validator("scenarios")(distinct)

    @model_validator(mode="after")
    def _only_what_the_study_leaves_open(self) -> Self:
        check_left_open(
            SET_BY_THE_STUDY - {"epsilon_decay"}, sarsa=self.sarsa, dual_memory=self.dual_memory
        )
        return self

    @property
    def training_simulator(self) -> str:
        """Name of the simulator that learners train in, as the results call it."""
        if self.train_in == "sumo":
            return self.judge
        return CALIBRATED if self.calibrate else "queue"

    @property
    def simulators(self) -> tuple[str, ...]:
        """Names of the simulators that every controller is evaluated in."""
        return (self.judge, *((CALIBRATED,) if self.calibrate else ()), "queue")
