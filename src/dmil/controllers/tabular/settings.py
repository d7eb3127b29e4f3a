"""Settings of the tabular learners; the same text is the command line's help."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from dmil.controllers.parameters import GUARD, Settings
from dmil.interpretations import mark

LARGEST_CAPACITY = 100_000
"""Largest cap on a memory: what is allocated at once for every agent."""


class LearnerSettings(Settings):
    """What all tabular learners share."""

    embedding: str = Field(
        default="exact", description="How states share entries: a named embedding."
    )
    scale_levels: int | None = Field(
        default=None,
        ge=1,
        description="B, levels to which an embedding scales counts, if it scales; by default its "
        f"own, 5 {mark('scale_levels')}.",
    )
    tolerance: int | None = Field(
        default=None,
        ge=1,
        description="Largest difference of two queues in one class, for embeddings with a "
        f"tolerance; by default its own, 1 vehicle {mark('tolerance')}.",
    )
    epsilon: float = Field(
        default=0.6, ge=0, le=1, description=f"Probability of a random action, ε {mark('epsilon')}."
    )
    epsilon_decay: float = Field(
        default=1.0,
        gt=0,
        le=1,
        description=f"Factor on ε after every decision; below 1 {mark('epsilon_decay')}.",
    )
    learning_rate: float = Field(
        default=0.1, ge=0, le=1, description=f"Step of the SARSA update {mark('learning_rate')}."
    )
    discount: float = Field(default=0.95, ge=0, le=1, description=f"γ {mark('discount')}.")
    communication: bool = Field(
        default=False,
        description="Whether the central unit averages the memories of equal agents "
        f"{mark('communication')}.",
    )
    communication_period_s: int = Field(
        default=100,
        ge=1,
        description="T: time between meetings with the central unit "
        f"{mark('communication_period_s')}.",
    )
    trigger: Literal["period", "entries", "values", "staging"] = Field(
        default="period",
        description="When the agents of a shape meet the central unit: a period of T "
        f"{mark('trigger')}, "
        "new entries, changes of values, or staging (ours; the paper's future work).",
    )
    trigger_entries: float = Field(
        default=6.0,
        gt=0,
        allow_inf_nan=False,
        description="Trigger entries: rows stored anew since the last meeting, in the Q-table or "
        "short-term memory, mean over the agents (ours).",
    )
    trigger_change: float = Field(
        default=3.5,
        gt=0,
        allow_inf_nan=False,
        description="Trigger values: |ΔQ| of all writes since the last meeting added up, mean over "
        "the agents; it has the unit of the reward (ours).",
    )
    communication_delay_s: int = Field(
        default=0,
        ge=0,
        description="Delay of the central unit's answer; the next meeting waits for it (ours; the "
        "paper's future work).",
    )
    message_loss: float = Field(
        default=0.0,
        ge=0,
        lt=1,
        description="Probability that a message to the central unit, or its answer, is lost "
        "(ours).",
    )
    announced: bool = Field(
        default=False,
        description="Whether states also count approaching vehicles and those announced by "
        "neighbours (ours; the paper's future work).",
    )
    learning: bool = Field(
        default=True, description="Whether it learns; off for a frozen evaluation."
    )
    guard: bool = Field(default=True, description=GUARD)
    unseen: Literal["random", "longest-queue", "nearest"] = Field(
        default="random",
        description=f"Action in an unseen state: random {mark('unseen')}, that of "
        "longest-queue-first, or that of the nearest known class.",
    )


class SarsaSettings(LearnerSettings):
    """The non-memory agent (paper, §IV-C)."""

    trigger: Literal["period", "entries", "values"] = Field(
        default="period",
        description="When the agents of a shape meet the central unit: a period of T "
        f"{mark('trigger')}, "
        "new entries, or changes of values (ours; the paper's future work).",
    )
    trigger_entries: float = Field(
        default=0.25,
        gt=0,
        allow_inf_nan=False,
        description="Trigger entries: rows stored anew since the last meeting, mean over the "
        "agents (ours).",
    )
    shared: bool = Field(
        default=False,
        description="One table for all agents of a shape, as for the dummy agent of the training "
        "phase.",
    )


class DualMemorySettings(LearnerSettings):
    """The memory-based agent (paper, Algorithms 1–3)."""

    embedding: str = Field(
        default="complex", description="How states share entries: a named embedding."
    )
    epsilon: float = Field(
        default=0.4, ge=0, le=1, description=f"Probability of a random action, ε {mark('epsilon')}."
    )
    sent: Literal["long", "short", "both"] = Field(
        default="long",
        description="Which memory agents send to the central unit "
        f"{mark('sent')}; short-term rows come back "
        "as if they were learned then.",
    )
    trigger_share: float = Field(
        default=0.25,
        gt=0,
        le=1,
        description="Trigger staging: fraction of agents that have staged since the last meeting "
        "(ours).",
    )
    short_capacity: int = Field(
        default=16,
        ge=1,
        description="m_s: rows of short-term memory, which stages when full "
        f"{mark('short_capacity')}.",
    )
    staged_ratio: float = Field(
        default=0.5,
        gt=0,
        le=1,
        description=f"κ: fraction of the rows staged {mark('staged_ratio')}.",
    )
    staging: Literal["value", "visits"] = Field(
        default="value",
        description="Stage the rows with the highest Q (Algorithm 1) or most visits (text).",
    )
    stage_period: int = Field(
        default=0,
        ge=0,
        description="T_stage of the analysis: stage after so many learning decisions, or earlier "
        "when full; 0: only when full.",
    )
    least_tried: int = Field(
        default=1,
        ge=1,
        description="Actions of a class that must have been tried before short-term memory uses "
        f"or stages the best of them {mark('least_tried')}.",
    )
    long_capacity: int = Field(
        default=0,
        ge=0,
        le=LARGEST_CAPACITY,
        description="Maximum rows of an agent's long-term memory: when full, the less frequent of "
        "two classes is dropped; 0: no cap.",
    )
    significance: float = Field(
        default=0.1,
        ge=0,
        description="A Q is significantly better if above old + this·|old| "
        f"{mark('significance')}.",
    )
