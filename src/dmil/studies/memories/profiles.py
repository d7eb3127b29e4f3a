"""Shares of runs that are at least so good, and what ingredients of factored memory bring."""

from __future__ import annotations

import numpy as np
import polars as pl

from dmil.analysis.estimates import IQM
from dmil.seeding import stream
from dmil.statistics import mean_interval, paired_difference, performance_profile
from dmil.studies.memories.arranged import WAIT, Arranged
from dmil.studies.memories.names import MAX_PRESSURE
from dmil.studies.memories.ranking import ratios_to
from dmil.studies.memories.statements import SUBJECT

THRESHOLDS = np.geomspace(0.5, 10.0, 100)


def profiles(runs: Arranged) -> pl.DataFrame:
    """Return the performance profile of every controller over all cells (ours).

    Returns
    -------
    Columns ``controller``, ``ratio`` (of W to max-pressure's on the same vehicles) and ``share``,
    that of runs with at most this ratio, with ``low`` and ``high``. Failed runs reach none.
    """
    tasks = []
    for number, task in enumerate(ratios_to(runs, MAX_PRESSURE)):
        tasks.append(np.where(runs.failed[number].T, np.inf, task))
    if all(np.isnan(task).all() for task in tasks):
        return pl.DataFrame(schema=_PROFILE)
    rng = stream(0, "bootstrap", "memories", "profile")
    found = performance_profile(tasks, THRESHOLDS, rng, resamples=500)
    frames = [
        pl.DataFrame(
            {
                "controller": [name] * len(THRESHOLDS),
                "ratio": THRESHOLDS,
                "share": found.share[:, number],
                "low": found.low[:, number],
                "high": found.high[:, number],
            },
            schema=_PROFILE,
        )
        for number, name in enumerate(runs.controllers)
        if not np.isnan(found.share[:, number]).any()
    ]
    return pl.concat(frames).fill_nan(None) if frames else pl.DataFrame(schema=_PROFILE)


def ablation(runs: Arranged) -> pl.DataFrame:
    """Return how every ablation differs from factored memory as it is (ours).

    Returns
    -------
    Columns ``controller``, ``cell`` (null: over all cells, the interquartile mean of the ratios
    less 1) and the paired difference ``pct`` in % with ``low``, ``high`` and ``n``.
    """
    chosen = [name for name in runs.controllers if name in runs.ablations]
    if not chosen or SUBJECT not in runs.controllers:
        return pl.DataFrame(schema=_ABLATION)
    base = runs.of(WAIT, controller=SUBJECT)
    rows = []
    for name in chosen:
        values = runs.of(WAIT, controller=name)
        ratio = [(one / other)[:, None] for one, other in zip(values, base, strict=True)]
        rng = stream(0, "bootstrap", "memories", "ablation")
        found = mean_interval(ratio, rng, summary=IQM)
        ends = (100 * float(each[0]) - 100 for each in (found.value, found.low, found.high))
        rows.append((name, None, *ends, int(found.seeds[0])))
        for cell, one, other in zip(runs.cells, values, base, strict=True):
            rng = stream(0, "bootstrap", "memories", cell, "ablation")
            found = paired_difference(one[:, None], other[:, None], rng, relative=True)
            ends = (100 * float(each[0]) for each in (found.value, found.low, found.high))
            rows.append((name, cell, *ends, int(found.seeds[0])))
    table = pl.DataFrame(rows, schema=_ABLATION, orient="row").fill_nan(None)
    return table.filter(pl.col("n") > 0)


_PROFILE: dict[str, type[pl.DataType]] = {
    "controller": pl.String,
    **dict.fromkeys(("ratio", "share", "low", "high"), pl.Float64),
}
_ABLATION: dict[str, type[pl.DataType]] = {
    "controller": pl.String,
    "cell": pl.String,
    **dict.fromkeys(("pct", "low", "high"), pl.Float64),
    "n": pl.Int64,
}
