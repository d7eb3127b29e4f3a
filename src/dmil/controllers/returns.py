"""n-step returns: what followed a state and an action, for all agents at once."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from dmil.controllers.protocol import FloatArray, IntArray
from dmil.memory.neighbours import KeyArray


class Outcome(NamedTuple):
    """What followed a choice of n decisions ago.

    Attributes
    ----------
    key: (agents, places) float32
        States then.
    action: (agents,) int32
    value: (agents,) float64
        Returns.
    """

    key: KeyArray
    action: IntArray
    value: FloatArray


class ReturnWindow:
    """The last n choices of a run, until their returns are known (Sutton & Barto, §7.1).

    The horizon cuts a task that goes on: the last choices of a run have no return and are not
    remembered.

    Parameters
    ----------
    steps
        n.
    discount
        γ.
    """

    def __init__(self, steps: int, discount: float) -> None:
        self._steps = steps
        self._discounts = discount ** np.arange(steps + 1, dtype=np.float64)
        self._chosen: list[tuple[KeyArray, IntArray]] = []
        self._rewards: list[FloatArray] = []

    def choose(self, key: KeyArray, action: IntArray) -> None:
        """Note a choice.

        Parameters
        ----------
        key: (agents, places) float32
            States, not changed afterwards.
        action: (agents,) int32
        """
        self._chosen.append((key, action))

    def reward(self, reward: FloatArray, following: FloatArray) -> Outcome | None:
        """Note the reward of the last choice; return what is known now of the oldest.

        Parameters
        ----------
        reward: (agents,) float64
        following: (agents,) float64
            Value of the states now, with which returns go on after n rewards.
        """
        self._rewards.append(reward.astype(np.float64))
        if len(self._rewards) < self._steps:
            return None
        value = self._discounts[-1] * following
        for discount, earned in zip(self._discounts[-2::-1], self._rewards[::-1], strict=True):
            value = value + discount * earned
        self._rewards.pop(0)
        return Outcome(*self._chosen.pop(0), value)
