"""The paired, stratified bootstrap over seeds, for many columns at once.

The unit of evidence is the seed. All functions take arrays of shape (seeds, columns), one column
for each controller or thing measured; NaN marks a run that is missing, all else is finite. In place
of one array they also take a sequence of arrays, one for each task (network, load): then all runs
of all tasks are summed up together, and seeds are resampled within each task (stratified). Where
tasks differ in scale, give them a common one first, such as the ratio to a reference.

A resample of seeds is drawn once and serves all columns and both members of a pair, so what they
share (the demand) cancels. It is a column of counts, so all means of all resamples of all columns
are one matrix product.

Intervals are percentile intervals at levels expanded for small samples (Hesterberg, 2015, "What
teachers should know about the bootstrap", section 5.2): the plain percentile interval is too narrow
by the factor √((n-1)/n) and by normal in place of t quantiles, which matters with few seeds.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dmil.statistics.summaries import RESAMPLED, Summary, Values, wins

Tasks = Values | Sequence[Values]
"""(seeds, columns) of one task, or one such array for each of several tasks."""

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
        (columns,) ends of the interval; NaN where no task has two seeds.
    seeds
        (columns,) number of runs behind each: seeds, summed over tasks.
    """

    value: Values
    low: Values
    high: Values
    seeds: NDArray[np.int64]


def mean_interval(
    values: Tasks,
    rng: np.random.Generator,
    *,
    summary: Summary = "mean",
    level: float = DEFAULT_LEVEL,
    resamples: int = DEFAULT_RESAMPLES,
) -> Estimate:
    """Return the mean, or interquartile mean, over seeds and its bootstrap interval.

    Parameters
    ----------
    values
        (seeds, columns), or one such array for each task; NaN marks a missing run.
    rng
        Source of the resamples.
    summary
        "mean" or "interquartile mean".
    level
        Coverage of the interval.
    resamples
        Number of bootstrap resamples.
    """
    return _bootstrap([values], lambda means: means[0], rng, summary, level, resamples)


def paired_difference(
    values: Tasks,
    reference: Tasks,
    rng: np.random.Generator,
    *,
    relative: bool = False,
    summary: Summary = "mean",
    level: float = DEFAULT_LEVEL,
    resamples: int = DEFAULT_RESAMPLES,
) -> Estimate:
    """Return how the mean of ``values`` differs from that of ``reference`` on the same seeds.

    Only seeds that both have count.

    Parameters
    ----------
    values, reference
        (seeds, columns), rows of the same seeds in the same order, or one such array for each task;
        the reference may have one column for all. NaN marks a missing run.
    rng
        Source of the resamples.
    relative
        Return mean(values) / mean(reference) - 1 in place of the difference.
    summary
        Which mean: "mean" or "interquartile mean" (of each member by itself).
    level
        Coverage of the interval.
    resamples
        Number of bootstrap resamples.
    """

    def difference(means: list[Values]) -> Values:
        return means[0] / means[1] - 1.0 if relative else means[0] - means[1]

    return _bootstrap([values, reference], difference, rng, summary, level, resamples)


def paired_ratio_of_ratios(
    values: tuple[Tasks, Tasks],
    reference: tuple[Tasks, Tasks],
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
        "mean",
        level,
        resamples,
    )


def probability_of_improvement(
    values: Tasks,
    reference: Tasks,
    rng: np.random.Generator,
    *,
    level: float = DEFAULT_LEVEL,
    resamples: int = DEFAULT_RESAMPLES,
) -> Estimate:
    """Return the share of paired runs in which a value is below its reference, equal ones half.

    Agarwal et al., NeurIPS 2021. Differs from the paper: pairs are those of equal seeds, which
    have the same demand, in place of all pairs of a task; a run counts as much in every task.

    Parameters
    ----------
    values, reference
        See `paired_difference`; lower is better.
    rng
        Source of the resamples.
    level
        Coverage of the interval.
    resamples
        Number of bootstrap resamples.
    """
    won = [
        wins(ours, theirs)
        for ours, theirs in zip(all_tasks(values), all_tasks(reference), strict=True)
    ]
    return mean_interval(won, rng, level=level, resamples=resamples)


def _bootstrap(
    members: list[Tasks],
    combine: Callable[[list[Values]], Values],
    rng: np.random.Generator,
    summary: Summary,
    level: float,
    resamples: int,
) -> Estimate:
    """Bootstrap what combines the means of several arrays that share their seeds."""
    if not 0.0 < level < 1.0:
        raise ValueError(f"level is {level}; it must lie between 0 and 1")
    sizes = np.array([len(task) for task in all_tasks(members[0])], np.int64)
    runs = np.broadcast_arrays(*(_all_runs(member) for member in members))
    present = ~np.isnan(np.stack(runs)).any(axis=0)
    value, low, high = (np.full(present.shape[1], np.nan) for _ in range(3))
    # Columns measured on the same seeds share their resamples; mostly that is all of them.
    patterns, column_pattern = np.unique(present.T, axis=0, return_inverse=True)
    for index, pattern in enumerate(patterns):
        if not pattern.any():
            continue
        columns = column_pattern.ravel() == index
        data = [member[np.ix_(pattern, columns)] for member in runs]
        counts, fewest = _resampled(_sizes_within(sizes, pattern), rng, resamples)
        once = np.ones((len(counts), 1))
        with np.errstate(invalid="ignore", divide="ignore"):
            value[columns] = combine([RESAMPLED[summary](each, once) for each in data])[:, 0]
            if not fewest:
                continue
            drawn = combine([RESAMPLED[summary](each, counts) for each in data])
            ends = np.quantile(drawn, interval_levels(fewest, level), axis=1)
        low[columns], high[columns] = ends
    return Estimate(value, low, high, present.sum(axis=0).astype(np.int64))


def all_tasks(values: Tasks) -> Sequence[Values]:
    """Return the array of every task (ours)."""
    return [values] if isinstance(values, np.ndarray) else values


def _all_runs(values: Tasks) -> Values:
    """Return the (runs, columns) of all tasks below one another."""
    tasks = all_tasks(values)
    return np.concatenate(tasks) if tasks else np.empty((0, 0))


def _sizes_within(sizes: NDArray[np.int64], pattern: NDArray[np.bool_]) -> list[int]:
    """Return how many of the runs of a pattern each task has."""
    return [int(part.sum()) for part in np.split(pattern, np.cumsum(sizes)[:-1]) if part.any()]


def _resampled(sizes: list[int], rng: np.random.Generator, resamples: int) -> tuple[Values, int]:
    """Draw seeds within each task; return (runs, resamples) counts, and the fewest seeds.

    The fewest are those of the smallest task that has two or more, 0 if none has: then nothing can
    be resampled.
    """
    several = [size for size in sizes if size > 1]
    if not several:
        return np.ones((sum(sizes), 0)), 0
    counts = [
        np.ones((resamples, 1))
        if size == 1
        else rng.multinomial(size, np.full(size, 1 / size), resamples)
        for size in sizes
    ]
    return np.ascontiguousarray(np.hstack(counts).T, np.float64), min(several)


def interval_levels(seeds: int, level: float = DEFAULT_LEVEL) -> tuple[float, float]:
    """Return the quantiles that end an interval, expanded for few seeds (Hesterberg, 2015).

    Parameters
    ----------
    seeds
        Number of seeds that a resample draws, at least 2.
    level
        Coverage of the interval.
    """
    from scipy.special import ndtr, stdtrit  # a third of a second that few commands need

    tail = float(stdtrit(seeds - 1, (1.0 - level) / 2.0))
    lower = float(ndtr(np.sqrt(seeds / (seeds - 1)) * tail))
    return lower, 1.0 - lower


@dataclass(frozen=True, slots=True)
class Profile:
    """Shares of runs with a score of at most each threshold.

    Attributes
    ----------
    thresholds
        (thresholds,) scores.
    share
        (thresholds, columns) share of the runs, 0 to 1; NaN where a column has no run.
    low, high
        (thresholds, columns) ends of the pointwise interval.
    """

    thresholds: Values
    share: Values
    low: Values
    high: Values


def performance_profile(
    values: Tasks,
    thresholds: Values,
    rng: np.random.Generator,
    *,
    level: float = DEFAULT_LEVEL,
    resamples: int = 2_000,
) -> Profile:
    """Return the share of runs with score ≤ τ, with a pointwise bootstrap band.

    Agarwal et al., NeurIPS 2021, section 4.2 ("score distributions"). Differs from the paper: less
    is better here, so it is the share below and not above τ.

    Parameters
    ----------
    values
        (seeds, columns), or one such array for each task, on a scale that tasks share; NaN marks a
        missing run, infinity one that failed and meets no threshold.
    thresholds
        (thresholds,) scores τ.
    rng
        Source of the resamples.
    level
        Coverage of the interval at each threshold.
    resamples
        Number of bootstrap resamples.
    """
    reached = [_reached(task, thresholds) for task in all_tasks(values)]
    found = mean_interval(reached, rng, level=level, resamples=resamples)
    shape = len(thresholds), len(found.value) // max(len(thresholds), 1)
    return Profile(
        thresholds, found.value.reshape(shape), found.low.reshape(shape), found.high.reshape(shape)
    )


def _reached(task: Values, thresholds: Values) -> Values:
    """Return (seeds, thresholds x columns): 1 where a run is at most a threshold, else 0."""
    reached = np.where(task[:, None, :] <= thresholds[None, :, None], 1.0, 0.0)
    reached[np.isnan(np.broadcast_to(task[:, None, :], reached.shape))] = np.nan
    return reached.reshape(len(task), -1)
