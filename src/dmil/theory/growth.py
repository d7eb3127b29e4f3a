"""Closed forms of the comparison ratio ζ = msize of SARSA / msize of dual memory.

Sizes are counted in entries, as in the paper's definition in §V: a row of the Q-table or of
short-term memory has |A| entries, a row of long-term memory three (state, action, value).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dmil.theory.parameters import hyperparameters, whole_number, whole_numbers


class Ratios(NamedTuple):
    """ζ right after a staging (`zeta1`) and right before one (`zeta2`); shape of the input."""

    zeta1: NDArray[np.float64]
    zeta2: NDArray[np.float64]


def worst_case(actions: int, staged_ratio: float, stage_period: int, stagings: ArrayLike) -> Ratios:
    """Comparison ratio when every decision meets a state never met before (paper, Lemma 1).

    ζ1 = (nT+1)|A| / (|A| + 3nκT) at decision nT and ζ2 = nT|A| / (T|A| + 3(n−1)κT) at decision
    nT − 1. Both tend to |A|/(3κ).

    Parameters
    ----------
    actions
        |A|, number of actions, at least 1.
    staged_ratio
        κ, share of short-term rows that is staged, in (0, 1].
    stage_period
        T, decisions between two stagings, at least 1.
    stagings
        n, number of stagings so far, whole numbers of at least 1, any shape.

    Returns
    -------
    Ratios
        ζ1 and ζ2, each of the shape of `stagings`.

    Raises
    ------
    InputError
        A parameter is out of range.

    Notes
    -----
    κT is taken as it is, as in the paper. `memory_sizes` and `size_bounds` stage whole rows,
    ⌈κT⌉: they agree with this where κT is a whole number.
    """
    actions, staged_ratio, stage_period = hyperparameters(actions, staged_ratio, stage_period)
    n = whole_numbers("stagings", stagings, at_least=1)
    staged = staged_ratio * stage_period
    zeta1 = (n * stage_period + 1) * actions / (actions + 3 * n * staged)
    zeta2 = n * stage_period * actions / (stage_period * actions + 3 * (n - 1) * staged)
    return Ratios(np.asarray(zeta1), np.asarray(zeta2))


def best_case(
    actions: int, stage_period: int, distinct_states: ArrayLike, *, as_printed: bool = False
) -> Ratios:
    """Comparison ratio when no new state is met any more and all are staged (paper, Lemma 2).

    ζ1 = M|A| / (|A| + 3M) right after a staging and ζ2 = M|A| / (min(T, M)|A| + 3M) right before
    one. Since m_L ≤ M, any trajectory that has met M states has at least ζ2.

    Parameters
    ----------
    actions
        |A|, number of actions, at least 1.
    stage_period
        T, decisions between two stagings, at least 1.
    distinct_states
        M, number of classes met, whole numbers of at least 1, any shape.
    as_printed
        Take T for min(T, M), as the paper prints it.

    Returns
    -------
    Ratios
        ζ1 and ζ2, each of the shape of `distinct_states`.

    Raises
    ------
    InputError
        A parameter is out of range.

    Notes
    -----
    Differs from the paper: short-term memory holds distinct states, so never more than M. For
    M > T, which the proof of Lemma 2 asks, both are the same, and so are the thresholds on M.
    """
    actions = whole_number("actions", actions, at_least=1)
    stage_period = whole_number("stage_period", stage_period, at_least=1)
    m = whole_numbers("distinct_states", distinct_states, at_least=1)
    short_term = np.full_like(m, stage_period) if as_printed else np.minimum(m, stage_period)
    zeta1 = m * actions / (actions + 3 * m)
    zeta2 = m * actions / (short_term * actions + 3 * m)
    return Ratios(np.asarray(zeta1), np.asarray(zeta2))


def worst_case_limit(actions: int, staged_ratio: float) -> float:
    """|A|/(3κ), to which ζ1 and ζ2 of the worst case tend as the stagings go on (ours).

    Parameters
    ----------
    actions
        |A|, number of actions, at least 1.
    staged_ratio
        κ, share of short-term rows that is staged, in (0, 1].

    Raises
    ------
    InputError
        A parameter is out of range.
    """
    actions, staged_ratio, _ = hyperparameters(actions, staged_ratio, 1)
    return actions / (3 * staged_ratio)


def enough_states(actions: int, stage_period: int) -> float:
    """T|A|/(|A|−3): from this many distinct states on, ζ ≥ 1 on any trajectory.

    The condition for Lemma 3 in the paper's Remark in §V, where it stands for M, all states of a
    run; at a decision the states met so far count (proof ours). Infinite for |A| ≤ 3.

    Parameters
    ----------
    actions
        |A|, number of actions, at least 1.
    stage_period
        T, decisions between two stagings, at least 1.

    Raises
    ------
    InputError
        A parameter is out of range.
    """
    actions = whole_number("actions", actions, at_least=1)
    stage_period = whole_number("stage_period", stage_period, at_least=1)
    return stage_period * actions / (actions - 3) if actions > 3 else float("inf")
