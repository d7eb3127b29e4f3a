"""Every metric of every controller, network and simulator, with intervals over seeds."""

from __future__ import annotations

import numpy as np
import polars as pl

from dmil.analysis.estimates import Values, as_column, interval_columns, seed_means
from dmil.results.metrics import METRICS, SCORES
from dmil.seeding import stream
from dmil.statistics import (
    Estimate,
    interquartile_mean,
    mean_interval,
    paired_difference,
    standard_deviation,
    wins,
)
from dmil.studies.resco.contenders import Judged

FEWEST_FOR_IQM = 8
"""Seeds from which on the interquartile mean of one network says more than the mean."""


def scores(runs: Judged) -> pl.DataFrame:
    """Return every metric of every contender, network and simulator (ours).

    Returns
    -------
    Columns ``scenario``, ``simulator``, those of a contender, ``metric``; ``n`` seeds, ``mean``,
    ``sd``, ``low`` and ``high`` (95 %), ``iqm`` (interquartile mean, from 8 seeds on); the paired
    ``difference`` to max-pressure with its interval; ``share_better``, the share of seeds in which
    it is better than max-pressure, equal ones half; ``among_best``: whether the paired interval of
    its difference to the best mean does not show it to be worse (null with one seed).
    """
    return pl.concat(_of_metric(runs, metric) for metric in SCORES).filter(pl.col("n") > 0)


def _of_metric(runs: Judged, metric: str) -> pl.DataFrame:
    values = runs.measures[metric]
    shape = values.shape[:3]
    columns = values.reshape(-1, values.shape[3]).T
    found = mean_interval(columns, stream(0, "bootstrap", "resco", metric))
    frame = _places(runs).with_columns(
        metric=pl.lit(metric),
        n=pl.Series(found.seeds),
        **interval_columns(found),
        sd=as_column(standard_deviation(columns)),
        iqm=_quartile_means(columns),
    )
    reference = runs.reference
    numbers = np.full(shape[:2], -1 if reference is None else reference)
    difference = _against(values, numbers, metric)
    frame = frame.with_columns(**interval_columns(difference, "difference", "difference_{}"))
    better = METRICS[metric].better
    sign = -1.0 if better == "more" else 1.0
    if better is None or reference is None:
        frame = frame.with_columns(share_better=pl.lit(None, pl.Float64))
    else:
        won = wins(sign * values, sign * values[:, :, [reference]])
        won[:, :, reference] = np.nan
        frame = frame.with_columns(share_better=as_column(seed_means(won, axis=-1).ravel()))
    if better is None:
        return frame.with_columns(among_best=pl.lit(None, pl.Boolean))
    means = sign * found.value.reshape(shape)
    best = np.argmin(np.where(np.isnan(means), np.inf, means), axis=2)
    gap = _against(values, best, metric)
    worst_end = -gap.high if better == "more" else gap.low
    # Where nothing varies the interval has no width; a rounding error is no difference.
    unshown = as_column(worst_end) <= 1e-9
    return frame.with_columns(among_best=unshown)


def _against(values: Values, numbers: np.ndarray, metric: str) -> Estimate:
    """Return the paired difference of every contender to one of each network; -1 is none."""
    missing = np.full((*values.shape[:2], 1, values.shape[3]), np.nan)
    chosen = np.take_along_axis(
        np.concatenate([values, missing], axis=2), numbers[:, :, None, None], axis=2
    )
    seeds = values.shape[3]
    return paired_difference(
        values.reshape(-1, seeds).T,
        np.broadcast_to(chosen, values.shape).reshape(-1, seeds).T,
        stream(0, "bootstrap", "resco", metric, "difference"),
    )


def _places(runs: Judged) -> pl.DataFrame:
    places = pl.DataFrame(
        [(name, simulator) for simulator in runs.simulators for name in runs.scenarios],
        schema=["scenario", "simulator"],
        orient="row",
    )
    return places.join(runs.keys, how="cross", maintain_order="left_right")


def _quartile_means(columns: Values) -> pl.Series:
    found: list[float | None] = []
    for column in columns.T:
        present = column[~np.isnan(column)]
        enough = len(present) >= FEWEST_FOR_IQM
        found.append(float(interquartile_mean(present)) if enough else None)
    return pl.Series(found, dtype=pl.Float64)
