"""Cost of every controller: memory, time, and decisions to outperform max-pressure."""

from __future__ import annotations

import warnings

import numpy as np
import polars as pl

from dmil.analysis.panel import Values
from dmil.results import Results
from dmil.studies.memories.arranged import Arranged
from dmil.studies.memories.names import cell_name


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
        frame = pl.DataFrame(
            {
                "cell": [cell] * len(runs.controllers),
                "controller": runs.controllers,
                "learns": runs.learns,
                "entries_per_agent": _of(runs, cell, "entries_per_agent", np.nanmean),
                "entries_total": _of(runs, cell, "entries_total", np.nanmean),
                "bytes_per_intersection": _of(runs, cell, "bytes_per_intersection", np.nanmean),
                "bytes_largest": _of(runs, cell, "bytes_per_intersection", np.nanmax),
                "us_per_decision": _of(runs, cell, "us_per_decision", np.nanmedian),
                "overtook": np.where(known, overtook, np.nan),
                "decisions_until_better": np.where(known & np.isfinite(median), median, np.nan),
                "planned": runs.planned[number].sum(axis=1),
                "failed": runs.failed[number].sum(axis=1),
                "diverged": runs.diverged[number].sum(axis=1),
            }
        )
        frames.append(frame.filter(pl.col("planned") > 0).fill_nan(None))
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
    cells = [cell_name(*row) for row in rows.select("scenario", "load").rows()]
    return (
        rows.with_columns(cell=pl.Series(cells, dtype=pl.String))
        .with_columns(share=pl.col("lookups") / pl.col("lookups").sum().over("cell", "controller"))
        .select("cell", "controller", "source", "share")
        .fill_nan(None)
    )


def _of(runs: Arranged, cell: str, measure: str, summary: object) -> Values:
    return _over_seeds(summary, runs.of(measure, cell=cell).T)


def _over_seeds(summary: object, values: Values) -> Values:
    """Summarise over seeds what is there; NaN where nothing is."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # of columns without any run
        found: Values = summary(values, axis=0)  # type: ignore[operator]
    return found
