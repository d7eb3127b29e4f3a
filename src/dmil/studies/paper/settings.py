"""What the paper's study is: every number of it, with where it comes from.

Marks in the descriptions: [P] stated by the paper, [A] assumed because it is the only reading tried
that gives the paper's magnitudes, [F] fitted to the paper's table.
"""

from __future__ import annotations

from typing import Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator

from dmil.controllers.tabular.settings import DualMemorySettings, SarsaSettings
from dmil.demand import Ties
from dmil.experiments.checks import check_left_open, distinct
from dmil.interpretations import mark
from dmil.network.grid import ENTRY_LINK_TIME_S, LINK_TIME_S
from dmil.rewards import PAPER_CONSTANTS, RewardConstants
from dmil.scenarios.demand_changes import DemandChanges
from dmil.scenarios.model import HIGHEST_LOAD, LONGEST_RUN_S
from dmil.scenarios.recipe import DynamicsChanges, GridChanges, ScenarioRecipe, TimingChanges
from dmil.seeding import LARGEST_SEED

PresetName = Literal["literal", "decaying", "matched"]
ComplexReading = Literal["complex", "complex-scaled"]
NoMemory = Literal["exact", "simple", "complex", "complex-scaled"]


class Preset(BaseModel):
    """One reading of what the paper leaves open."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    epsilon_decay: float = Field(
        1.0,
        gt=0,
        le=1,
        description="Factor on ε after every decision of the test; below 1 "
        f"{mark('epsilon_decay')}.",
    )
    training_factor: int = Field(
        1,
        ge=1,
        description="Length of the training phase, in test runs; above 1 "
        f"{mark('training_factor')}.",
    )
    no_memory_embedding: NoMemory = Field(
        "exact",
        description="Classes of the agent that the table calls 'No Memory'; except exact "
        f"{mark('no_memory_embedding')}.",
    )


PRESETS: dict[str, Preset] = {
    "literal": Preset(),
    "decaying": Preset(epsilon_decay=0.95),
    "matched": Preset(epsilon_decay=0.95, training_factor=10, no_memory_embedding="simple"),
}
"""The paper taken literally, with an ε that decays, and as its magnitudes are best met."""


def _instead_of_preset(name: str) -> Any:
    """Offer a field of the presets for all of them: the same limits and text, no default."""
    original = Preset.model_fields[name]
    text = (original.description or "").rstrip(".")
    field: Any = Field(None, description=f"{text}; instead of what the presets say.")
    field.metadata = list(original.metadata)
    return field


class PaperStudySettings(BaseModel):
    """The study of the paper (§VI; specification, §7)."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    presets: tuple[PresetName, ...] = Field(
        ("literal", "decaying", "matched"), min_length=1, description="Presets to run."
    )
    epsilon_decay: float | None = _instead_of_preset("epsilon_decay")
    training_factor: int | None = _instead_of_preset("training_factor")
    no_memory_embedding: NoMemory | None = _instead_of_preset("no_memory_embedding")
    grids: tuple[str, ...] = Field(
        ("1x1", "3x3", "5x5"), min_length=1, description="Grids, ROWSxCOLUMNS [P]."
    )
    seeds: int = Field(30, ge=1, description=f"Runs per case; seeds 0, 1, … {mark('seeds')}.")
    first_seed: int = Field(0, ge=0, le=LARGEST_SEED, description="First seed.")
    horizon_s: int = Field(
        300,
        ge=20,
        le=LONGEST_RUN_S,
        description=f"Length of a test run in s {mark('horizon_s')}.",
    )
    load: float = Field(
        1.0,
        gt=0,
        le=HIGHEST_LOAD,
        allow_inf_nan=False,
        description="Factor on the paper's arrival rates.",
    )
    ties: Ties = Field(
        "straight",
        description="Choice between equally short routes: straight (straight on first, which "
        "gives one route per pair of nodes) or coin (a fair coin at every choice, drawn in "
        f"advance) {mark('ties')}.",
    )
    rewards: tuple[str, ...] = Field(
        ("default", "diffusion", "entropy"), min_length=1, description="Rewards [P]."
    )
    reward_constants: RewardConstants = Field(
        PAPER_CONSTANTS, description="Constants of the reward default [P]."
    )
    complex_readings: tuple[ComplexReading, ...] = Field(
        ("complex", "complex-scaled"),
        min_length=1,
        description="Readings of the complex classes; the first is used in the paper's table, the "
        "others for comparison: complex adds rotation and scale to simple, as the text says, "
        "complex-scaled applies simple's tolerance after scaling only "
        f"{mark('complex_readings')}.",
    )
    training_epsilon: float = Field(
        0.1, ge=0, le=1, description=f"ε_train of the dummy agent {mark('training_epsilon')}."
    )
    equal_epsilon: bool = Field(
        True, description="Also run SARSA with the memory-based agents' ε: all at equal ε."
    )
    variant_seeds: int = Field(
        10,
        ge=0,
        description="Seeds for runs, on the largest grid, of the paper's future work: other "
        "triggers, messages, delays, losses, predictions from neighbours; 0: none.",
    )
    variant_factor: int = Field(
        6, ge=1, description="How many times longer these runs are: half an hour by default."
    )
    sarsa: SarsaSettings = Field(
        SarsaSettings(),
        description="Non-memory agent; the study sets embedding, communication and ε decay.",
    )
    dual_memory: DualMemorySettings = Field(
        DualMemorySettings(), description="Memory-based agent; likewise."
    )
    timing: TimingChanges = Field(
        TimingChanges(decision_interval_s=10),
        description="Signal timing; the decision interval is t_a "
        f"{mark('timing.decision_interval_s')}.",
    )
    dynamics: DynamicsChanges = Field(
        DynamicsChanges(saturation_flow_veh_per_s=1.0),
        description="Queue dynamics; the saturation flow is v*.",
    )
    demand: DemandChanges = Field(
        DemandChanges(), description="Random arrivals in place of the paper's."
    )
    grid: GridChanges = Field(
        GridChanges(link_time_s=LINK_TIME_S, entry_link_time_s=ENTRY_LINK_TIME_S),
        description="Links of the grids.",
    )

    _distinct = field_validator("presets", "grids", "rewards", "complex_readings")(distinct)

    @model_validator(mode="after")
    def _only_what_the_study_leaves_open(self) -> Self:
        check_left_open(sarsa=self.sarsa, dual_memory=self.dual_memory)
        return self

    @model_validator(mode="after")
    def _no_memory_is_run(self) -> Self:
        run = ("exact", "simple", self.complex_readings[0])
        if self.no_memory_embedding not in (None, *run):
            raise ValueError(
                f"no_memory_embedding is {self.no_memory_embedding}, which is not run: choose "
                f"one of {', '.join(run)}"
            )
        return self

    def preset(self, name: str) -> Preset:
        """Return a preset with what stands in place of its values in this study (ours).

        Parameters
        ----------
        name
            One of `PRESETS`.
        """
        given = {field: getattr(self, field) for field in Preset.model_fields}
        changes = {field: value for field, value in given.items() if value is not None}
        return PRESETS[name].model_copy(update=changes)

    def recipe(self, scenario: str) -> ScenarioRecipe:
        """Return what a scenario of the study is made from (ours).

        Parameters
        ----------
        scenario
            Its name, such as grid:5x5.
        """
        names = ("horizon_s", "load", "ties", "timing", "dynamics", "demand", "grid")
        return ScenarioRecipe(scenario=scenario, **{name: getattr(self, name) for name in names})
