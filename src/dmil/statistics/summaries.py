"""Numbers that sum up runs: mean, interquartile mean, wins, and both means of all resamples.

A resample is a column of counts: how often it drew each run. All resamples of a column of values
are summed up at once, the interquartile mean too: the runs are sorted once, not in every resample.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Values = NDArray[np.float64]
Summary = Literal["mean", "interquartile mean"]

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


def standard_deviation(values: Values) -> Values:
    """Return the sample standard deviation over seeds of (seeds, columns); NaN below two seeds."""
    present = ~np.isnan(values)
    seeds = present.sum(axis=0)
    filled = np.where(present, values, 0.0)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = filled.sum(axis=0) / seeds
        squares = np.where(present, (values - mean) ** 2, 0.0).sum(axis=0)
        deviation: Values = np.sqrt(squares / np.where(seeds > 1, seeds - 1, np.nan))
    return deviation


def resampled_means(values: Values, counts: Values) -> Values:
    """Return the (columns, resamples) mean of every column in every resample (ours).

    Parameters
    ----------
    values
        (runs, columns) without NaN.
    counts
        (runs, resamples): how often each run was drawn; whole numbers, every column with the sum
        ``runs``.
    """
    means: Values = values.T @ counts / len(values)
    return means


def resampled_interquartile_means(values: Values, counts: Values) -> Values:
    """Return what `resampled_means` does, for interquartile means (ours).

    With the runs in order, the counts summed up to each run and cut to the middle half say how much
    of the middle half has come by then; the differences are what each run has of it.
    """
    runs, cut = len(values), int(CUT * len(values))
    found = np.empty((values.shape[1], counts.shape[1]))
    for column, unsorted in enumerate(values.T):
        order = np.argsort(unsorted, kind="stable")
        so_far = np.cumsum(counts[order], axis=0)
        np.clip(so_far, cut, runs - cut, out=so_far)
        shares = np.diff(so_far, axis=0, prepend=float(cut)) / (runs - 2 * cut)
        # Measured from the middle run, so that runs that are all equal give exactly their value.
        middle = unsorted[order[runs // 2]]
        found[column] = middle + (unsorted[order] - middle) @ shares
    return found


RESAMPLED: dict[Summary, Callable[[Values, Values], Values]] = {
    "mean": resampled_means,
    "interquartile mean": resampled_interquartile_means,
}
"""What sums up all resamples, by name."""
