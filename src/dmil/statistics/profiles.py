"""Performance profiles: which share of the runs is at least as good as each score."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dmil.statistics.bootstrap import DEFAULT_LEVEL, Tasks, all_tasks, mean_interval

Values = NDArray[np.float64]


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
