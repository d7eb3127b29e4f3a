"""The bootstrap over seeds, for many columns at once.

The unit of evidence is the seed. All functions take arrays of shape (seeds, columns), one column
for each thing measured; NaN marks a run that is missing. A resample of seeds is a row of weights,
so all means of all resamples of all columns are one matrix product, and both members of a pair
always see the same resampled seeds.

Intervals are percentile intervals at levels expanded for small samples (Hesterberg, 2015, "What
teachers should know about the bootstrap", section 5.2): the plain percentile interval is too narrow
by the factor √((n-1)/n) and by normal in place of t quantiles, which matters with few seeds.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, stdtrit

Values = NDArray[np.float64]

DEFAULT_LEVEL = 0.95
DEFAULT_RESAMPLES = 5_000


@dataclass(frozen=True, slots=True)
class Estimate:
    """An estimate with its interval for each column (ours).

    Parameters
    ----------
    value
        (columns,) point estimates; NaN where there is no data.
    low, high
        (columns,) ends of the interval; NaN where fewer than two seeds are there.
    seeds
        (columns,) number of seeds behind each.
    """

    value: Values
    low: Values
    high: Values
    seeds: NDArray[np.int64]


def mean_interval(
    values: Values,
    rng: np.random.Generator,
    *,
    level: float = DEFAULT_LEVEL,
    resamples: int = DEFAULT_RESAMPLES,
) -> Estimate:
    """Return the mean over seeds and its bootstrap interval.

    Parameters
    ----------
    values
        (seeds, columns); NaN marks a missing run.
    rng
        Source of the resamples.
    level
        Coverage of the interval.
    resamples
        Number of bootstrap resamples.
    """
    return _bootstrap([values], lambda means: means[0], rng, level, resamples)


def paired_difference(
    values: Values,
    reference: Values,
    rng: np.random.Generator,
    *,
    relative: bool = False,
    level: float = DEFAULT_LEVEL,
    resamples: int = DEFAULT_RESAMPLES,
) -> Estimate:
    """Return how the mean of ``values`` differs from that of ``reference`` on the same seeds.

    Only seeds that both have count. Seeds are resampled once for both members of the pair, so what
    they share (the demand) cancels.

    Parameters
    ----------
    values, reference
        (seeds, columns), rows of the same seeds in the same order; NaN marks a missing run.
    rng
        Source of the resamples.
    relative
        Return mean(values) / mean(reference) - 1 in place of the difference.
    level
        Coverage of the interval.
    resamples
        Number of bootstrap resamples.
    """
    if relative:
        return _bootstrap(
            [values, reference], lambda means: means[0] / means[1] - 1.0, rng, level, resamples
        )
    return _bootstrap([values, reference], lambda means: means[0] - means[1], rng, level, resamples)


def paired_ratio_of_ratios(
    values: tuple[Values, Values],
    reference: tuple[Values, Values],
    rng: np.random.Generator,
    *,
    level: float = DEFAULT_LEVEL,
    resamples: int = DEFAULT_RESAMPLES,
) -> Estimate:
    """Return (a / b) / (c / d) - 1 of the means of ``values = (a, b)``, ``reference = (c, d)``.

    It answers whether a change (a in place of b) helps one thing more than another.

    Parameters
    ----------
    values, reference
        Two arrays (seeds, columns) each, rows of the same seeds; NaN marks a missing run.
    rng
        Source of the resamples.
    level
        Coverage of the interval.
    resamples
        Number of bootstrap resamples.
    """
    return _bootstrap(
        [*values, *reference],
        lambda m: (m[0] / m[1]) / (m[2] / m[3]) - 1.0,
        rng,
        level,
        resamples,
    )


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


def _bootstrap(
    arrays: list[Values],
    statistic: Callable[[list[Values]], Values],
    rng: np.random.Generator,
    level: float,
    resamples: int,
) -> Estimate:
    """Bootstrap a statistic of the means of several arrays that share their seeds."""
    if not 0.0 < level < 1.0:
        raise ValueError(f"level is {level}; it must lie between 0 and 1")
    present = ~np.isnan(np.stack(arrays)).any(axis=0)
    seeds = present.sum(axis=0).astype(np.int64)
    value, low, high = (np.full(present.shape[1], np.nan) for _ in range(3))
    # Columns measured on the same seeds share their resamples; mostly that is all of them.
    patterns, member = np.unique(present.T, axis=0, return_inverse=True)
    for index, pattern in enumerate(patterns):
        count = int(pattern.sum())
        if count == 0:
            continue
        columns = member.ravel() == index
        data = [array[np.ix_(pattern, columns)] for array in arrays]
        with np.errstate(invalid="ignore", divide="ignore"):
            value[columns] = statistic([one.mean(axis=0) for one in data])
            if count < 2:
                continue
            weights = rng.multinomial(count, np.full(count, 1 / count), resamples) / count
            drawn = statistic([weights @ one for one in data])
        low[columns], high[columns] = np.quantile(drawn, interval_levels(count, level), axis=0)
    return Estimate(value, low, high, seeds)


def interval_levels(seeds: int, level: float = DEFAULT_LEVEL) -> tuple[float, float]:
    """Return the quantiles that end an interval, expanded for few seeds (Hesterberg, 2015).

    Parameters
    ----------
    seeds
        Number of seeds that a resample draws, at least 2.
    level
        Coverage of the interval.
    """
    tail = float(stdtrit(seeds - 1, (1.0 - level) / 2.0))
    lower = float(ndtr(np.sqrt(seeds / (seeds - 1)) * tail))
    return lower, 1.0 - lower
