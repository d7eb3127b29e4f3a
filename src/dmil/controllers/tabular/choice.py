"""ε-greedy choice, compiled; the draws come in as arrays."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from dmil.compilation import kernel

DRAWS = 3
"""Uniform draws per agent and decision: whether to explore, which action, which of equal ones."""


@kernel
def uniform_action(draw: float, count: int) -> int:
    """Turn a uniform draw in [0, 1) into an action."""
    return int(draw * count)


@kernel
def explores(draws: npt.NDArray[np.float64], epsilon: float) -> bool:
    """Tell whether this decision is a random one, by ``draws``, (3,) float64."""
    return bool(draws[0] < epsilon)


@kernel
def unseen_action(fallback: int, draw: float, count: int) -> int:
    """Return what is done in an unseen state: the fallback, or if it is below 0 a random action."""
    return fallback if fallback >= 0 else uniform_action(draw, count)


@kernel
def greedy_action(
    value: npt.NDArray[np.float64], image: npt.NDArray[np.int32], count: int, draw: float
) -> int:
    """Return an action of the highest value, equal ones at random, untried zeros included.

    Parameters
    ----------
    value: (actions,) float64
        Values in the orientation of the stored key.
    image: (actions,) int32
        Place in ``value`` of each action.
    """
    best, ties = value[image[0]], 0
    for action in range(count):
        if value[image[action]] > best:
            best, ties = value[image[action]], 1
        elif value[image[action]] == best:
            ties += 1
    wanted = uniform_action(draw, ties)
    for action in range(count):
        if value[image[action]] == best:
            if wanted == 0:
                return action
            wanted -= 1
    return 0
