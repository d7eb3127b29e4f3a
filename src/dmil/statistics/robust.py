"""Summaries over many tasks at once: interquartile mean, improvement, stratified resamples.

A task (a network) has its own seeds, so a resample draws seeds within every task.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from dmil.statistics.bootstrap import DEFAULT_LEVEL, interval_levels

Values = NDArray[np.float64]

CUT = 0.25
"""Share of the runs that the interquartile mean leaves out at either end."""


def interquartile_mean(values: Values) -> Values:
    """Return the mean of the middle half of the last axis (Agarwal et al., NeurIPS 2021).

    Parameters
    ----------
    values
        (..., runs) without NaN.
    """
    runs = values.shape[-1]
    cut = int(CUT * runs)
    middle: Values = np.sort(values, axis=-1)[..., cut : runs - cut].mean(axis=-1)
    return middle


def wins(values: Values, reference: Values) -> Values:
    """Return 1 where a value is the lower of the pair, 0 where it is the higher, 0.5 where equal.

    The mean over paired runs is the probability of improvement (Agarwal et al., NeurIPS 2021, with
    pairs of equal seeds in place of all pairs); NaN where one of the pair is missing.
    """
    won = np.where(values < reference, 1.0, np.where(values > reference, 0.0, 0.5))
    return np.where(np.isnan(values) | np.isnan(reference), np.nan, won)


def stratified(
    tasks: Sequence[Values],
    statistic: Callable[[Values], Values],
    rng: np.random.Generator,
    *,
    level: float = DEFAULT_LEVEL,
    resamples: int = 2_000,
) -> tuple[float, float, float]:
    """Return a statistic of all runs of all tasks with its stratified bootstrap interval.

    Parameters
    ----------
    tasks
        For every task (seeds,) values; NaN marks a missing run.
    statistic
        Of (resamples, runs) along the last axis.
    rng
        Source of the resamples.
    level
        Coverage of the interval.
    resamples
        Number of bootstrap resamples.

    Returns
    -------
    Value, low, high; NaN without runs, and for the interval where every task has fewer than two.
    """
    present = [task[~np.isnan(task)] for task in tasks]
    present = [task for task in present if len(task)]
    if not present:
        return (float("nan"),) * 3
    value = float(statistic(np.concatenate(present)[None, :])[0])
    fewest = min((len(task) for task in present if len(task) > 1), default=0)
    if not fewest:
        return value, float("nan"), float("nan")
    drawn = [task[rng.integers(len(task), size=(resamples, len(task)))] for task in present]
    low, high = np.quantile(statistic(np.hstack(drawn)), interval_levels(fewest, level))
    return value, float(low), float(high)
