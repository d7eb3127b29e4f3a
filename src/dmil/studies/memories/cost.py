"""Cost of every controller, memory, time, decisions to outperform max-pressure; learning curves."""

from __future__ import annotations

import warnings

import numpy as np
import polars as pl

from dmil.analysis.estimates import interval_columns, learning_curve
from dmil.analysis.panel import Values
from dmil.results import Results
from dmil.seeding import stream
from dmil.studies.memories.arranged import WAIT, Arranged
from dmil.studies.memories.names import MAX_PRESSURE, with_cell

_MEASURED = (
    ("entries_per_agent", "entries_per_agent", np.nanmean),
    ("entries_total", "entries_total", np.nanmean),
    ("bytes_per_intersection", "bytes_per_intersection", np.nanmean),
    ("bytes_largest", "bytes_per_intersection", np.nanmax),
    ("us_per_decision", "us_per_decision", np.nanmedian),
)
"""Columns of `cost`: of which measure, and how it is summarised over seeds."""
_CURVE: dict[str, type[pl.DataType]] = {
    "cell": pl.String,
    "controller": pl.String,
    "run": pl.Int64,
    "test": pl.Boolean,
    **dict.fromkeys(("mean", "low", "high", "base"), pl.Float64),
}


def cost(runs: Arranged) -> pl.DataFrame:
    """Return what every controller costs in every cell (ours).

    Returns
    -------
    Per cell and controller: means over seeds of ``entries_per_agent``, ``entries_total`` and
    ``bytes_per_intersection``, of the latter also the largest (``bytes_largest``);
    ``us_per_decision``, median over seeds, for all intersections at once; of learners ``overtook``,
    the share of seeds in which it became better than max-pressure, and ``decisions_until_better``,
    the median over seeds (infinite where it never did; null if that is the median); runs
    ``planned``, ``failed`` in whatever way, and ``diverged``.
    """
    frames = []
    for number, cell in enumerate(runs.cells):
        until = runs.of("decisions_until_better", cell=cell).T
        ok = (runs.planned & ~runs.failed)[number].T
        finished = np.where(np.isnan(until) & ok, np.inf, until)
        known = ok.any(axis=0) & runs.learns
        with np.errstate(invalid="ignore"):
            overtook = (np.isfinite(finished) & ok).sum(axis=0) / ok.sum(axis=0)
        median = _over_seeds(np.nanmedian, finished)
        measured = {
            name: _over_seeds(summary, runs.of(measure, cell=cell).T)
            for name, measure, summary in _MEASURED
        }
        columns = {
            "cell": [cell] * len(runs.controllers),
            "controller": runs.controllers,
            "learns": runs.learns,
            **measured,
            "overtook": np.where(known, overtook, np.nan),
            "decisions_until_better": np.where(known & np.isfinite(median), median, np.nan),
            "planned": runs.planned[number].sum(axis=1),
            "failed": runs.failed[number].sum(axis=1),
            "diverged": runs.diverged[number].sum(axis=1),
        }
        frames.append(pl.DataFrame(columns).filter(pl.col("planned") > 0).fill_nan(None))
    return pl.concat(frames)


def hit_rates(results: Results) -> pl.DataFrame:
    """Return from where every controller's look-ups were answered (ours).

    Returns
    -------
    Columns ``cell``, ``controller``, ``source``, ``share`` of all look-ups of all seeds; empty if
    no controller counts them.
    """
    rows = results.query(
        "select scenario, load, controller, source, sum(lookups)::bigint as lookups"
        " from lookups group by all order by all"
    )
    return (
        with_cell(rows)
        .with_columns(share=pl.col("lookups") / pl.col("lookups").sum().over("cell", "controller"))
        .select("cell", "controller", "source", "share")
        .fill_nan(None)
    )


def _over_seeds(summary: object, values: Values) -> Values:
    """Summarise over seeds what is there; NaN where nothing is."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # of columns without any run
        found: Values = summary(values, axis=0)  # type: ignore[operator]
    return found


def learning_curves(results: Results, runs: Arranged) -> pl.DataFrame:
    """Return the waiting in every hour of training and in the test, over seeds (ours).

    Returns
    -------
    Columns ``cell``, ``controller``, ``run`` (number of the episode from 1; the test is the last),
    ``test`` (whether it is), ``mean``, ``low``, ``high`` in s, and ``base``, the mean of
    max-pressure in the test.
    """
    episodes = results.query(
        "select scenario, load, controller, seed, episode + 1 as run, wait_per_spawned_s, false as"
        " test from episodes"
    )
    tests = results.query(
        f"""
        select r.scenario, r.load, r.controller, r.seed,
          coalesce(cast(r.training_s / r.horizon_s as bigint), 0) + 1 as run, r.{WAIT}, true as test
        from runs r where r.status = 'ok' and r.reward is not null
        """
    )
    rows = pl.concat([episodes, tests.select(episodes.columns)], how="vertical_relaxed")
    rows = with_cell(rows)
    base = runs.of(WAIT, controller=MAX_PRESSURE)
    frames = []
    for number, cell in enumerate(runs.cells):
        for controller in runs.controllers:
            own = rows.filter(pl.col("cell") == cell, pl.col("controller") == controller)
            if own.is_empty():
                continue
            rng = stream(0, "bootstrap", "memories", "learning")
            numbers, _, found = learning_curve(own, "run", WAIT, rng)
            known = base[number][~np.isnan(base[number])]
            last = own.filter(pl.col("test"))["run"].max()
            columns = {
                "cell": cell,
                "controller": controller,
                "run": numbers,
                "test": [each == last for each in numbers],
                **interval_columns(found),
                "base": float(known.mean()) if known.size else None,
            }
            frames.append(pl.DataFrame(columns, schema=_CURVE))
    return pl.concat(frames) if frames else pl.DataFrame(schema=_CURVE)


def memory_courses(results: Results, runs: Arranged) -> pl.DataFrame:
    """Return true bytes per intersection over the hours of a learner's life (ours).

    Returns
    -------
    Columns ``cell``, ``controller``, ``hour`` (training first, then the test), ``bytes``, mean over
    seeds.
    """
    size = dict(zip(runs.cells, runs.intersections, strict=True))
    rows = results.query(
        """
        with tested as (
          select scenario, load, controller, seed, horizon_s, coalesce(training_s, 0) as before_s
          from runs where status = 'ok' and reward is not null
        )
        select scenario, load, controller, hour, avg(bytes_total) as bytes from (
          select scenario, load, controller, (episode + 1) * horizon_s / 3600.0 as hour, bytes_total
          from episodes join tested using (scenario, load, controller, seed)
          union all
          select scenario, load, controller, (before_s + time_s) / 3600.0 as hour, bytes_total
          from series join tested using (scenario, load, controller, seed)
        ) group by all order by all
        """
    )
    return (
        with_cell(rows)
        .with_columns(bytes=pl.col("bytes") / pl.col("cell").replace_strict(size, default=None))
        .select("cell", "controller", "hour", "bytes")
        .filter(pl.col("bytes") > 0)
    )
