"""What the study on the RESCO benchmark is: every number of it."""

from __future__ import annotations

from typing import Literal, Self

from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator

from dmil.controllers.tabular.settings import DualMemorySettings, SarsaSettings
from dmil.experiments.checks import SET_BY_THE_STUDY, check_left_open, distinct
from dmil.scenarios.resco import PREFIX, RESCO

NETWORKS = tuple(name.removeprefix(PREFIX) for name in RESCO)
"""All networks of the benchmark."""
CALIBRATED = "queue-calibrated"
"""Name of the queue simulator with numbers measured in SUMO."""


class RescoStudySettings(BaseModel):
    """The study on the RESCO benchmark (protocol: Ault and Sharon 2021; controllers ours)."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    scenarios: tuple[str, ...] = Field(
        NETWORKS, min_length=1, description="Networks of RESCO, without the resco/ before them."
    )
    seeds: int = Field(5, ge=1, description="Runs per controller; seeds 0, 1, …")
    first_seed: int = Field(0, ge=0, description="First of the seeds.")
    episodes: int = Field(
        100, ge=1, description="Training runs of each learner; their seeds are never test seeds."
    )
    horizon_s: int | None = Field(
        None, ge=20, description="Length of a run in s; by default RESCO's hour."
    )
    resample: bool = Field(
        False,
        description="Judge every seed on another day drawn from the recorded vehicles, each "
        "departing a little sooner or later; RESCO has one day.",
    )
    train_in: Literal["queue", "sumo"] = Field(
        "queue", description="Simulator that learners train in; they are judged in SUMO either way."
    )
    judge: Literal["sumo", "sumo-meso"] = Field(
        "sumo",
        description="SUMO's model that controllers are judged in. The calibration always measures "
        "the microscopic one, and does not fit the mesoscopic.",
    )
    calibrate: bool = Field(
        True,
        description="Measure in one SUMO run per network what the queue simulator should use, and "
        "train with it.",
    )
    emissions: bool = Field(True, description="Have SUMO compute CO2 and fuel.")
    reward: str = Field("diffusion", description="What learners get.")
    sarsa: SarsaSettings = Field(
        SarsaSettings(epsilon=0.1), description="Non-memory agent, exact states."
    )
    dual_memory: DualMemorySettings = Field(
        DualMemorySettings(epsilon=0.1),
        description="Memory-based agent; classes and communication are the study's.",
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
