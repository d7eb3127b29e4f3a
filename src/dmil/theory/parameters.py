"""The numbers the analysis takes, and the ranges in which it means anything."""

from __future__ import annotations

import math
from numbers import Integral, Real
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dmil.errors import InputError, unknown_name

StagingRule = Literal["period", "full"]
"""When short-term memory is staged: every `stage_period` decisions, or as soon as it has that
many rows."""

# 0.07 * 100 is a little more than 7 in binary; a row must not be staged for that.
_ROUNDING = 1e-9


def whole_number(name: str, value: object, *, at_least: int) -> int:
    """Check one whole number.

    Parameters
    ----------
    name
        What the number is, for the message.
    value
        What the user gave.
    at_least
        Smallest value allowed.

    Returns
    -------
    int
        The number.

    Raises
    ------
    InputError
        It is not a whole number, or too small.
    """
    if isinstance(value, bool) or not isinstance(value, Integral) or int(value) < at_least:
        raise InputError(
            f"found {value!r}", where=name, expected=f"a whole number of at least {at_least}"
        )
    return int(value)


def whole_numbers(name: str, values: ArrayLike, *, at_least: int) -> NDArray[np.float64]:
    """Check an array (any shape) of whole numbers; returned as float64 for division.

    Raises
    ------
    InputError
        A value is not a whole number, or too small.
    """
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
    """Check a share in (0, 1].

    Raises
    ------
    InputError
        It is not a number, or outside (0, 1].
    """
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
    """Check |A|, κ and T together.

    Raises
    ------
    InputError
        One of them is out of range: |A| ≥ 1, 0 < κ ≤ 1, T ≥ 1.
    """
    return (
        whole_number("actions", actions, at_least=1),
        ratio("staged_ratio", staged_ratio),
        whole_number("stage_period", stage_period, at_least=1),
    )


def staging_rule(rule: str) -> StagingRule:
    """Check the name of a staging rule.

    Raises
    ------
    UnknownNameError
        It is neither "period" nor "full".
    """
    if rule == "period":
        return "period"
    if rule == "full":
        return "full"
    raise unknown_name("staging rule", rule, ("period", "full"), where="rule")


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
