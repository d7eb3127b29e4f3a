"""Settings of the deep controllers; this module does not load torch."""

from __future__ import annotations

from pydantic import Field

from dmil.controllers.episodic.by_shape import SharedSettings


class DeepSettings(SharedSettings):
    """What all deep controllers share."""

    phase: bool = Field(
        default=False, description="Whether the phase shown is an input, one per phase."
    )
    hidden: int = Field(default=64, ge=1, description="Neurons in each of the two hidden layers.")
    learning_rate: float = Field(
        default=1e-3, gt=0, allow_inf_nan=False, description="Learning rate of Adam."
    )
    discount: float = Field(default=0.95, ge=0, lt=1, description="γ.")
    reward_scale: float = Field(
        default=0.1,
        gt=0,
        allow_inf_nan=False,
        description="Factor on rewards: the Huber loss bounds a step, so values in the hundreds "
        "would take very long to reach.",
    )
    batch_size: int = Field(default=32, ge=1, description="Transitions per update.")
    buffer_capacity: int = Field(
        default=50_000,
        ge=1,
        description="Capacity of the replay buffer; the oldest transition is dropped.",
    )
    train_every: int = Field(
        default=1, ge=1, description="Decisions, each for all intersections, per update."
    )


class DqnSettings(DeepSettings):
    """Deep Q-network."""

    target_period: int = Field(
        default=500, ge=1, description="Updates between refreshes of the target network."
    )


class PrioritisedSettings(DqnSettings):
    """Deep Q-network with prioritised replay."""

    priority_exponent: float = Field(
        default=0.6, ge=0, le=1, description="α: 0 samples uniformly, 1 in proportion to |δ|."
    )
    priority_floor: float = Field(
        default=1e-6,
        gt=0,
        description="Added to |δ|, so that every transition can be sampled again.",
    )
    weight_first: float = Field(
        default=0.4,
        ge=0,
        le=1,
        description="Initial β: how far importance weights correct the bias.",
    )
    weight_last: float = Field(default=1.0, ge=0, le=1, description="Final β.")


class HindsightSettings(DqnSettings):
    """Deep Q-network with goals and hindsight replay."""

    goal_veh: int = Field(
        default=2, ge=0, description="g: longest queue that it tries not to exceed."
    )
    relabelled: int = Field(
        default=4,
        ge=0,
        description="k: relabelled transitions per original one.",
    )


class VdnSettings(DqnSettings):
    """Value decomposition network."""


class NecSettings(DeepSettings):
    """Neural episodic control."""

    hidden: int = Field(default=64, ge=1, description="Neurons in the one hidden layer.")
    embedding: int = Field(default=32, ge=1, description="Numbers in an embedding.")
    steps: int = Field(default=10, ge=1, description="N of N-step returns, in decisions.")
    neighbours: int = Field(
        default=50, ge=1, description="Nearest entries in the weighted mean of a look-up."
    )
    softening: float = Field(
        default=1e-3, gt=0, allow_inf_nan=False, description="δ of the weights 1/(‖h − h_i‖² + δ)."
    )
    value_rate: float = Field(
        default=0.1, ge=0, le=1, description="α: learning rate of known entries."
    )
    capacity: int = Field(
        default=10_000,
        ge=1,
        description="Entries per phase and shape; the least recently returned one is dropped.",
    )
