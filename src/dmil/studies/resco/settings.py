"""What the study on the RESCO benchmark is: every number of it."""

from __future__ import annotations

from typing import Literal, Self

from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator

from dmil.controllers.deep.settings import DqnSettings
from dmil.controllers.tabular.settings import DualMemorySettings, SarsaSettings
from dmil.experiments.checks import SET_BY_THE_STUDY, check_left_open, distinct
from dmil.scenarios.names import PREFIX, RESCO

NETWORKS = tuple(name.removeprefix(PREFIX) for name in RESCO)
"""All networks of the benchmark."""
CALIBRATED = "queue-calibrated"
"""Name of the queue simulator with numbers measured in SUMO."""
UNBLOCKED = "sumo-unblocked"
"""Name of the protocol in which a junction does not lock for good; SUMO is the same."""
BLOCKER_S = 10
"""In it a vehicle that has stood on a junction for so many seconds blocks nobody any more."""
DQN = DqnSettings(
    approaching=True,
    phase=True,
    discount=0.99,
    buffer_capacity=10_000,
    epsilon_last=0.0,
    exploration_part=0.8,
)
"""The deep rival as RESCO's IDQN where ours has the same number: γ, replay, batch, target network,
learning rate, ε (from 1 to 0 in 80 % of the training). See docs/resco.md for what differs."""


class RescoStudySettings(BaseModel):
    """The study on the RESCO benchmark (protocol: Ault and Sharon 2021; controllers ours)."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    scenarios: tuple[str, ...] = Field(
        NETWORKS, min_length=1, description="RESCO networks, without the prefix resco/."
    )
    seeds: int = Field(5, ge=1, description="Runs per controller; seeds 0, 1, …")
    first_seed: int = Field(0, ge=0, description="First seed.")
    lock_seeds: int = Field(
        20,
        ge=1,
        description="Runs of untrained controllers on the networks of lock_scenarios, if more.",
    )
    lock_scenarios: tuple[str, ...] = Field(
        ("cologne3", "ingolstadt21"),
        description="Networks where junctions lock in some seeds, so that few tell little.",
    )
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
    unblocked: bool = Field(
        True,
        description="Evaluate in SUMO a second time, with --ignore-junction-blocker 10: a vehicle "
        "that has stood on a junction for 10 s blocks nobody any more.",
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

    deep: bool = Field(
        False,
        description="Also train DQN (extra 'deep') in SUMO itself, as the published learners were: "
        "4 to 10 minutes of one core per training.",
    )
    deep_seeds: int = Field(3, ge=1, description="Trainings of DQN; each is judged on some seeds.")
    deep_scenarios: tuple[str, ...] = Field(
        ("cologne1", "ingolstadt1", "ingolstadt7"), description="Networks that DQN is trained on."
    )
    deep_reward: str = Field("queue", description="Reward of DQN.")
    dqn: DqnSettings = Field(DQN, description="DQN; the study sets the length of its schedules.")

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
    def in_sumo(self) -> tuple[str, ...]:
        """Names of the protocols in SUMO; its mesoscopic model knows no blocked junctions."""
        return (self.judge, UNBLOCKED) if self.unblocked and self.judge == "sumo" else (self.judge,)

    @property
    def simulators(self) -> tuple[str, ...]:
        """Names of the simulators that every controller is evaluated in."""
        return (*self.in_sumo, *((CALIBRATED,) if self.calibrate else ()), "queue")

    def seeds_of(self, network: str) -> range:
        """Return the test seeds of a network; learners take the first ``seeds`` of them."""
        more = self.lock_seeds if network in self.lock_scenarios else 0
        return range(self.first_seed, self.first_seed + max(self.seeds, more))
