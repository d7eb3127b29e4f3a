"""Rewards: what an agent gets for one decision interval, from what was seen before and after.

A reward is a function of two observations and the network that returns one number per intersection;
write another one and name it ``package.module:function`` wherever a reward is asked for.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from dmil.arrays import FloatArray, IntArray
from dmil.compilation import allocating_kernel
from dmil.errors import InputError, unknown_name
from dmil.importing import import_object
from dmil.interpretations import mark
from dmil.network import RoadNetwork
from dmil.simulation import Observation
from dmil.simulation.pressure import movement_pressure

RELAXATION_VEH = 1.1
TOLERATED_VEH = 10.0
"""Both of the paper's default reward (§VI), see `RewardConstants`."""


class RewardConstants(BaseModel):
    """Numbers of the default reward (paper, Eq. 1)."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    relaxation_veh: float = Field(
        RELAXATION_VEH,
        ge=0,
        description="α, growth of a queue in one decision interval that is still rewarded "
        f"{mark('reward_constants.relaxation_veh')}; of the reward default.",
    )
    tolerated_veh: float = Field(
        TOLERATED_VEH,
        ge=0,
        description="θ, growth beyond α that is not yet punished "
        f"{mark('reward_constants.tolerated_veh')}; of the reward default.",
    )

    @property
    def changed(self) -> dict[str, float]:
        """Those that are not the paper's."""
        return self.model_dump(exclude_defaults=True)


PAPER_CONSTANTS = RewardConstants()


class Reward(Protocol):
    """One number per intersection for what happened between two decisions."""

    def __call__(self, before: Observation, after: Observation, network: RoadNetwork) -> FloatArray:
        """Return the rewards.

        Parameters
        ----------
        before, after
            Observations at consecutive decisions.
        network
            The roads.

        Returns
        -------
        reward: (intersections,) float64
        """


def default(before: Observation, after: Observation, network: RoadNetwork) -> FloatArray:
    """Return the movements that grew by at most α minus those by at least α+θ (paper, §III)."""
    return DefaultReward()(before, after, network)


@dataclass(frozen=True, slots=True)
class DefaultReward:
    """The default reward with constants of its own (paper, §III).

    Parameters
    ----------
    constants
        α and θ.
    """

    constants: RewardConstants = PAPER_CONSTANTS

    def __call__(self, before: Observation, after: Observation, network: RoadNetwork) -> FloatArray:
        """Return the movements that grew by at most α minus those by at least α+θ."""
        alpha, theta = self.constants.relaxation_veh, self.constants.tolerated_veh
        counts = network.movement_count
        return _default(before.queue_veh, after.queue_veh, counts, alpha, alpha + theta)


def diffusion(before: Observation, after: Observation, network: RoadNetwork) -> FloatArray:
    """Return −mean(sign(d)·d²) of the growths d over all movements (paper, §VI-A)."""
    return _diffusion(before.queue_veh, after.queue_veh, network.movement_count)


def entropy(before: Observation, after: Observation, network: RoadNetwork) -> FloatArray:
    """Return w(after) − w(before) with w(s) = −Σ s·ln s, 0·ln 0 = 0 (paper, §VI-A).

    The counts are not normalised to a distribution, as printed: normalising them breaks it.
    """
    return _entropy(before.queue_veh, after.queue_veh)


def queue(before: Observation, after: Observation, network: RoadNetwork) -> FloatArray:
    """Return minus the vehicles queued (ours)."""
    reward: FloatArray = -after.queue_veh.sum(axis=1, dtype=np.float64)
    return reward


def pressure(before: Observation, after: Observation, network: RoadNetwork) -> FloatArray:
    """Return minus the absolute pressure of the intersection (after PressLight, Wei et al. 2019).

    PressLight divides the counts by what a lane can hold; here they are vehicles.
    """
    reward: FloatArray = -np.abs(movement_pressure(after.queue_veh, network).sum(axis=1))
    return reward


REWARDS: dict[str, Reward] = {
    "default": default,
    "diffusion": diffusion,
    "entropy": entropy,
    "queue": queue,
    "pressure": pressure,
}
"""The named rewards."""


def checked_reward(
    reward: Reward, before: Observation, after: Observation, network: RoadNetwork
) -> FloatArray:
    """Return the reward of an interval as (intersections,) float64 (ours).

    Raises
    ------
    InputError
        If it is not one finite number per intersection.
    """
    found = np.asarray(reward(before, after, network), np.float64)
    count = len(network.intersections)
    if found.shape != (count,) or not np.isfinite(found).all():
        raise InputError(
            f"the reward at {after.time_s} s has shape {found.shape} and values "
            f"{found.ravel()[:3]}…",
            where="reward",
            expected=f"one finite number for each of the {count} intersections",
        )
    return found


def make_reward(name: str, constants: RewardConstants = PAPER_CONSTANTS) -> Reward:
    """Return a reward by its name or by the import path ``package.module:function`` (ours).

    Parameters
    ----------
    name
        Of `REWARDS`, or the path.
    constants
        Numbers of the reward ``default``.

    Raises
    ------
    InputError
        If there is none, or it has no constants and other ones than the paper's are given.
    """
    if constants.changed:
        if name == "default":
            return DefaultReward(constants)
        check_constants([name], constants)
    if ":" in name:
        own = import_object(name, "reward")
        if not callable(own):
            raise InputError(
                f"it is a {type(own).__name__}",
                where=f"reward '{name}'",
                expected="a function of two observations and the network",
            )
        reward: Reward = own
        return reward
    if name not in REWARDS:
        raise unknown_name("reward", name, REWARDS)
    return REWARDS[name]


def check_constants(names: Iterable[str], constants: RewardConstants) -> None:
    """Check that one of some rewards uses the constants that differ from the paper's (ours).

    Raises
    ------
    InputError
        If none does.
    """
    if constants.changed and "default" not in names:
        raise InputError(
            f"{', '.join(constants.changed)} is given, but the reward is {' or '.join(names)}",
            where="reward_constants",
            expected="the reward 'default', the only one with constants",
            mend="leave them out, or choose that reward",
        )


@allocating_kernel
def _default(
    before: IntArray, after: IntArray, movements: IntArray, rewarded: float, punished: float
) -> FloatArray:
    reward = np.zeros(before.shape[0])
    for i in range(before.shape[0]):
        for j in range(movements[i]):
            growth = after[i, j] - before[i, j]
            if growth <= rewarded:
                reward[i] += 1.0
            elif growth >= punished:
                reward[i] -= 1.0
    return reward


@allocating_kernel
def _diffusion(before: IntArray, after: IntArray, movements: IntArray) -> FloatArray:
    reward = np.zeros(before.shape[0])
    for i in range(before.shape[0]):
        for j in range(movements[i]):
            growth = float(after[i, j] - before[i, j])
            reward[i] -= growth * abs(growth)
        reward[i] /= movements[i]
    return reward


@allocating_kernel
def _entropy(before: IntArray, after: IntArray) -> FloatArray:
    reward = np.zeros(before.shape[0])
    for i in range(before.shape[0]):
        for j in range(before.shape[1]):
            if after[i, j] > 1:
                reward[i] -= after[i, j] * np.log(after[i, j])
            if before[i, j] > 1:
                reward[i] += before[i, j] * np.log(before[i, j])
    return reward
