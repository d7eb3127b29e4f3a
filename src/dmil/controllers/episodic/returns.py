"""n-step returns: what followed a state and an action, for all agents at once."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from dmil.arrays import FloatArray

Chosen = tuple[npt.NDArray[Any], ...]


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
        self._discounts = (discount ** np.arange(steps + 1, dtype=np.float64)).tolist()
        self._chosen: list[Chosen] = []
        self._rewards: list[FloatArray] = []

    def choose(self, *chosen: npt.NDArray[Any]) -> None:
        """Note a choice.

        Parameters
        ----------
        chosen: (agents, …) arrays
            What to know of it later, such as states and actions; not changed afterwards.
        """
        self._chosen.append(chosen)

    def reward(
        self, reward: FloatArray, following: FloatArray | float
    ) -> tuple[Chosen, FloatArray] | None:
        """Note the reward of the last choice; return the choice of n decisions ago, and its return.

        Parameters
        ----------
        reward: (agents,) float64
        following: (agents,) float64
            Value of the states now, with which returns go on after n rewards.

        Returns
        -------
        chosen, value
            What was noted then, and Σ γᵏ r_k + γⁿ·following, (agents,) float64; None if there are
            no n rewards yet.
        """
        self._rewards.append(reward.astype(np.float64))
        if len(self._rewards) < self._steps:
            return None
        value = self._discounts[-1] * np.broadcast_to(following, reward.shape)
        # A sum that is no number is the caller's to notice.
        with np.errstate(over="ignore", invalid="ignore"):
            for discount, earned in zip(self._discounts[-2::-1], self._rewards[::-1], strict=True):
                value = value + discount * earned
        self._rewards.pop(0)
        return self._chosen.pop(0), value


def best_tried(value: FloatArray) -> FloatArray:
    """Return the largest value of each state that is not infinite, 0 if there is none (ours).

    Parameters
    ----------
    value: (agents, actions) float64
        Infinite where an action was never tried.
    """
    best = np.where(np.isfinite(value), value, -np.inf).max(axis=1)
    found: FloatArray = np.where(np.isfinite(best), best, 0.0)
    return found
