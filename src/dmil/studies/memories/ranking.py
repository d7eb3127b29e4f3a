"""How controllers stand to references, in every cell and over all, and what ingredients bring."""

from __future__ import annotations

import numpy as np
import polars as pl

from dmil.analysis.estimates import (
    IQM,
    Values,
    as_column,
    interval_columns,
    ranking,
    ratios,
    seed_means,
)
from dmil.seeding import stream
from dmil.statistics import (
    mean_interval,
    paired_difference,
    performance_profile,
    probability_of_improvement,
    signed_rank_tests,
)
from dmil.studies.memories.arranged import WAIT, Arranged
from dmil.studies.memories.names import MAX_PRESSURE, REFERENCES
from dmil.studies.memories.statements import SUBJECT

THRESHOLDS = np.geomspace(0.5, 10.0, 100)
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


def standing(runs: Arranged) -> pl.DataFrame:
    """Return how long vehicles wait under every controller in every cell (ours).

    Returns
    -------
    Per cell and controller: ``n`` seeds, ``mean``, the interquartile mean ``iqm`` with ``low`` and
    ``high``, and the means of other measures; then for each reference R (max_pressure,
    longest_queue, approaching, limit) the paired difference of means in %, ``R_pct`` with
    ``R_low`` and ``R_high``, the probability of improvement ``R_better`` with interval, and
    ``R_p``, Wilcoxon's p-value corrected for all controllers of the cell (Holm).
    """
    frames = []
    for number, cell in enumerate(runs.cells):
        values = runs.of(WAIT, cell=cell).T
        rng = stream(0, "bootstrap", "memories", cell)
        means = mean_interval(values, rng)
        middle = mean_interval(values, rng, summary=IQM)
        columns: dict[str, object] = {
            "cell": [cell] * len(runs.controllers),
            "controller": runs.controllers,
            "n": means.seeds,
            "mean": as_column(means.value),
            **interval_columns(middle, "iqm"),
            **{
                name: as_column(seed_means(runs.of(name, cell=cell).T))
                for name in ("delay_s", "travel_time_s", "mean_queue_veh", "throughput_veh_per_h")
            },
        }
        for reference, short in REFERENCES.items():
            columns |= _against(runs, values, reference, short, cell)
        frames.append(pl.DataFrame(columns).filter(runs.planned[number].any(axis=-1)))
    return pl.concat(frames)


def overall(runs: Arranged) -> pl.DataFrame:
    """Return how every controller stands against the references over all cells (ours).

    Returns
    -------
    Per controller: ``cells``, ``n`` runs; for each reference R: ``R_ratio``, the interquartile mean
    over cells and seeds of its waiting over the reference's on the same vehicles, with ``R_low``
    and ``R_high`` (stratified bootstrap), ``R_better`` with interval and ``R_p`` as in `standing`.
    """
    columns: dict[str, object] = {
        "controller": runs.controllers,
        "cells": runs.planned.any(axis=2).sum(axis=0),
        "n": (~np.isnan(runs.measures[WAIT])).sum(axis=(0, 2)),
    }
    for reference, short in REFERENCES.items():
        number = runs.number("controller", reference)
        rng = stream(0, "bootstrap", "memories", "overall", reference)
        over, ratio, better = ranking(*_tasks(runs, reference), number, rng)
        ones = [np.where(np.isnan(task), np.nan, 1.0) for task in over]
        columns |= interval_columns(ratio, f"{short}_ratio", f"{short}_{{}}")
        columns |= interval_columns(better, f"{short}_better", f"{short}_better_{{}}")
        columns[f"{short}_p"] = _holm(over, ones, number)
    return pl.DataFrame(columns)


def ratios_to(runs: Arranged, reference: str) -> list[Values]:
    """Return for every cell (seeds, controllers) waiting over the reference's (ours)."""
    return ratios(*_tasks(runs, reference))


def _tasks(runs: Arranged, reference: str) -> tuple[list[Values], list[Values]]:
    """Return waiting in every cell, (seeds, controllers) and the (seeds, 1) of the reference."""
    base = runs.of(WAIT, controller=reference)
    base = np.where(base > 0, base, np.nan)
    return [runs.of(WAIT, cell=cell).T for cell in runs.cells], [each[:, None] for each in base]


def _against(
    runs: Arranged, values: Values, reference: str, short: str, cell: str
) -> dict[str, object]:
    base = np.broadcast_to(runs.of(WAIT, cell=cell, controller=reference)[:, None], values.shape)
    rng = stream(0, "bootstrap", "memories", cell, short)
    difference = paired_difference(values, base, rng, relative=True)
    better = probability_of_improvement(values, base, rng)
    return {
        **interval_columns(difference, f"{short}_pct", f"{short}_{{}}", 100),
        **interval_columns(better, f"{short}_better", f"{short}_better_{{}}"),
        f"{short}_p": _holm([values], [base], runs.number("controller", reference)),
    }


def _holm(values: list[Values], base: list[Values], itself: int | None) -> pl.Series:
    """Return the corrected p-value of each controller; that of the reference itself is no test."""
    count = values[0].shape[1]
    others = [number for number in range(count) if number != itself]
    found = np.full(count, np.nan)
    if others:
        tests = signed_rank_tests(
            [task[:, others] for task in values],
            [task[:, others] for task in base],
        )
        found[others] = tests.p_holm
    return as_column(found)


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
