"""Closed forms of the comparison ratio ζ = msize of SARSA / msize of dual memory.

Sizes are counted in entries, as in the paper's definition in §V: a row of the Q-table or of
short-term memory has |A| entries, a row of long-term memory three (state, action, value). At the
end are the checks of the numbers that the analysis takes.
"""

from __future__ import annotations

import math
from numbers import Integral, Real
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dmil.errors import InputError, unknown_name

StagingRule = Literal["period", "full"]
"""When short-term memory is staged: every `stage_period` decisions, or as soon as it has that
many rows."""

# 0.07 * 100 is a little more than 7 in binary; a row must not be staged for that.
_ROUNDING = 1e-9


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


def whole_number(name: str, value: object, *, at_least: int) -> int:
    """Check one whole number of this name: InputError if it is none, or below ``at_least``."""
    if isinstance(value, bool) or not isinstance(value, Integral) or int(value) < at_least:
        raise InputError(
            f"found {value!r}", where=name, expected=f"a whole number of at least {at_least}"
        )
    return int(value)


def whole_numbers(name: str, values: ArrayLike, *, at_least: int) -> NDArray[np.float64]:
    """Check an array (any shape) as `whole_number` checks one; float64 for division."""
    expected = f"whole numbers of at least {at_least}"
    try:
        numbers = np.asarray(values)
    except ValueError as error:
        raise InputError("found rows of unequal length", where=name, expected=expected) from error
    if not np.issubdtype(numbers.dtype, np.integer):
        raise InputError(f"found {numbers.dtype} values", where=name, expected=expected)
    if numbers.size and int(numbers.min()) < at_least:
        raise InputError(f"found {int(numbers.min())}", where=name, expected=expected)
    return numbers.astype(np.float64)


def ratio(name: str, value: object) -> float:
    """Check a share: InputError if it is no number, or outside (0, 1]."""
    if isinstance(value, bool) or not isinstance(value, Real) or not 0.0 < float(value) <= 1.0:
        raise InputError(
            f"found {value!r}",
            where=name,
            expected="a number above 0 and at most 1",
            mend="it is the share of short-term rows that is staged",
        )
    return float(value)


def hyperparameters(
    actions: object, staged_ratio: object, stage_period: object
) -> tuple[int, float, int]:
    """Check |A| ≥ 1, 0 < κ ≤ 1 and T ≥ 1 together: InputError if one of them is out of range."""
    return (
        whole_number("actions", actions, at_least=1),
        ratio("staged_ratio", staged_ratio),
        whole_number("stage_period", stage_period, at_least=1),
    )


def check_name(kind: str, name: str, known: tuple[str, ...], *, where: str) -> None:
    """Check that a name is one of a few: UnknownNameError if it is not."""
    if name not in known:
        raise unknown_name(kind, name, known, where=where)


def staged_rows(rows: int, staged_ratio: float) -> int:
    """How many of `rows` short-term rows are staged: ⌈κ·rows⌉ (Algorithm 1, rounding ours).

    Parameters
    ----------
    rows
        Rows in short-term memory.
    staged_ratio
        κ, share that is staged, in (0, 1].

    Returns
    -------
    int
        Between 1 and `rows`; 0 if there is no row.
    """
    return min(rows, max(1, math.ceil(staged_ratio * rows - _ROUNDING)))
