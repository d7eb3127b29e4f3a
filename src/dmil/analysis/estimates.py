"""Estimates as columns of a table, curves over time, and how everybody stands to a reference."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
import polars as pl
from numpy.typing import NDArray

from dmil.statistics import Estimate, mean_interval, probability_of_improvement

Values = NDArray[np.float64]
IQM: Final = "interquartile mean"
CURVE_RESAMPLES = 500


def as_column(values: Values) -> pl.Series:
    """Return numbers as a column, nulls for NaN."""
    return pl.Series(values, dtype=pl.Float64).fill_nan(None)


def interval_columns(
    found: Estimate, value: str = "mean", ends: str = "{}", factor: float = 1.0
) -> dict[str, pl.Series]:
    """Return an estimate as three columns.

    ``value`` names that of its values, ``ends`` those of its ends, where ``{}`` stands for low and
    high; the factor is 100 for %.
    """
    named = {value: found.value, ends.format("low"): found.low, ends.format("high"): found.high}
    return {name: as_column(factor * values) for name, values in named.items()}


def percent_columns(name: str, found: Estimate) -> dict[str, pl.Series]:
    """Return an estimate of a relative difference in %, all names ending in ``_pct``."""
    return interval_columns(found, f"{name}_pct", f"{name}_{{}}_pct", 100)


def seed_means(values: Values, axis: int = 0) -> Values:
    """Return means over seeds, runs that are missing left out."""
    present = ~np.isnan(values)
    with np.errstate(invalid="ignore"):
        return np.asarray(np.where(present, values, 0.0).sum(axis=axis) / present.sum(axis=axis))


def by_seed(runs: pl.DataFrame, on: str, measure: str) -> tuple[list[int], Values]:
    """Return the values of a column, ascending, and a measure as (seeds, values).

    Runs are rows with ``seed``, ``on`` (whole numbers, such as episodes) and the measure.
    """
    wide = runs.sort("seed", on).pivot(on=on, index="seed", values=measure).drop("seed")
    numbers = sorted(map(int, wide.columns))
    chosen = wide.select(pl.col(str(n)).cast(pl.Float64).fill_null(np.nan) for n in numbers)
    return numbers, chosen.to_numpy()


def learning_curve(
    runs: pl.DataFrame, on: str, measure: str, rng: np.random.Generator
) -> tuple[list[int], Values, Estimate]:
    """Return what `by_seed` does, and the mean over seeds at each value with its interval."""
    numbers, values = by_seed(runs, on, measure)
    return numbers, values, mean_interval(values, rng, resamples=CURVE_RESAMPLES)


def ratios(tasks: Sequence[Values], bases: Sequence[Values]) -> list[Values]:
    """Return for each task (seeds, columns) over the (seeds, 1) of a reference; NaN over 0."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return [
            np.where(base > 0, task / base, np.nan) for task, base in zip(tasks, bases, strict=True)
        ]


def ranking(
    tasks: Sequence[Values],
    bases: Sequence[Values],
    reference: int | None,
    rng: np.random.Generator,
) -> tuple[list[Values], Estimate, Estimate]:
    """Return how all columns stand to one of them over all tasks (Agarwal et al., NeurIPS 2021).

    Tasks are (seeds, columns) each, lower is better; bases are the (seeds, 1) of the reference,
    whose number is None if it was not run.

    Returns
    -------
    `ratios`; their interquartile mean over tasks and seeds; the share of runs below the reference,
    NaN for itself.
    """
    over = ratios(tasks, bases)
    ratio = mean_interval(over, rng, summary=IQM)
    better = probability_of_improvement(tasks, bases, rng)
    if reference is not None:
        for values in (better.value, better.low, better.high):
            values[reference] = np.nan
    return over, ratio, better
