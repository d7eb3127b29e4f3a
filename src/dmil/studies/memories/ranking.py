"""How every controller stands: in each cell, and over all of them."""

from __future__ import annotations

from typing import Final

import numpy as np
import polars as pl

from dmil.seeding import stream
from dmil.statistics import (
    Estimate,
    mean_interval,
    paired_difference,
    probability_of_improvement,
    signed_rank_tests,
)
from dmil.studies.memories.arranged import WAIT, Arranged, Values
from dmil.studies.memories.names import REFERENCES

IQM: Final = "interquartile mean"


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
        values = runs.task(WAIT, number)
        here = runs.planned[number].any(axis=-1)
        rng = stream(0, "bootstrap", "memories", cell)
        means = mean_interval(values, rng)
        middle = mean_interval(values, rng, summary=IQM)
        columns: dict[str, object] = {
            "n": pl.Series(means.seeds),
            "mean": _series(means.value),
            **_interval(middle, "iqm", ""),
            **{
                name: _series(_mean(runs.task(name, number)))
                for name in ("delay_s", "travel_time_s", "mean_queue_veh", "throughput_veh_per_h")
            },
        }
        for reference, short in REFERENCES.items():
            columns |= _against(values, runs.number(reference), short, cell)
        frame = pl.DataFrame(
            {"cell": [cell] * len(runs.controllers), "controller": list(runs.controllers)} | columns
        )
        frames.append(frame.filter(pl.Series(here)))
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
        "controller": list(runs.controllers),
        "cells": runs.planned.any(axis=2).sum(axis=0),
        "n": (~np.isnan(runs.measures[WAIT])).sum(axis=(0, 2)),
    }
    for reference, short in REFERENCES.items():
        tasks = ratios(runs, reference)
        ones = [np.where(np.isnan(task), np.nan, 1.0) for task in tasks]
        rng = stream(0, "bootstrap", "memories", "overall", reference)
        found = mean_interval(tasks, rng, summary=IQM)
        better = probability_of_improvement(tasks, ones, rng)
        p = _holm(tasks, ones, runs.number(reference))
        columns |= _interval(found, f"{short}_ratio", f"{short}_")
        columns |= _interval(better, f"{short}_better", f"{short}_better_")
        columns[f"{short}_p"] = _series(p)
    table = pl.DataFrame(columns)
    itself = {
        name: pl.when(pl.col("controller") == reference).then(None).otherwise(pl.col(name))
        for reference, short in REFERENCES.items()
        for name in (f"{short}_better", f"{short}_better_low", f"{short}_better_high")
    }
    return table.with_columns(**itself)


def ratios(runs: Arranged, reference: str) -> list[Values]:
    """Return for every cell (seeds, controllers) waiting over the reference's (ours)."""
    base = runs.of(WAIT, reference)
    found = []
    for number in range(len(runs.cells)):
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = runs.task(WAIT, number) / base[number][:, None]
        found.append(np.where(np.isfinite(ratio), ratio, np.nan))
    return found


def _against(values: Values, reference: int | None, short: str, cell: str) -> dict[str, object]:
    base = np.full_like(values, np.nan) if reference is None else values[:, [reference]]
    base = np.broadcast_to(base, values.shape)
    rng = stream(0, "bootstrap", "memories", cell, short)
    difference = paired_difference(values, base, rng, relative=True)
    percent = Estimate(
        100 * difference.value, 100 * difference.low, 100 * difference.high, difference.seeds
    )
    better = probability_of_improvement(values, base, rng)
    return {
        **_interval(percent, f"{short}_pct", f"{short}_"),
        **_interval(better, f"{short}_better", f"{short}_better_"),
        f"{short}_p": _series(_holm([values], [base], reference)),
    }


def _holm(values: list[Values], base: list[Values], itself: int | None) -> Values:
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
    return found


def _interval(found: Estimate, value: str, before: str) -> dict[str, pl.Series]:
    return {
        value: _series(found.value),
        f"{before}low": _series(found.low),
        f"{before}high": _series(found.high),
    }


def _series(values: Values) -> pl.Series:
    return pl.Series(values, dtype=pl.Float64).fill_nan(None)


def _mean(values: Values) -> Values:
    present = ~np.isnan(values)
    with np.errstate(invalid="ignore"):
        mean: Values = np.where(present, values, 0.0).sum(axis=0) / present.sum(axis=0)
    return mean
