"""Whether a fast simulator ranks controllers as SUMO does, before and after calibration."""

from __future__ import annotations

from typing import Any

import numpy as np
import polars as pl
from numpy.typing import NDArray

from dmil.analysis.panel import Values
from dmil.seeding import stream
from dmil.statistics import interval_levels, mean_interval
from dmil.studies.resco.contenders import JUDGES, QUEUES, Judged

METRICS = ("delay_s", "travel_time_s")
RESAMPLES = 2_000
BEFORE, AFTER = QUEUES

_TIE = 1e-9
_ADDED = ("contenders", "pairs", "clear_pairs", "ranks", "clear")
"""What is found of a network and added up over networks."""
_SCHEMA: dict[str, Any] = {
    **dict.fromkeys(("metric", "simulator", "scenario"), pl.String),
    **dict.fromkeys(("contenders", "pairs", "clear_pairs"), pl.Int64),
} | {
    f"{name}{end}": pl.Float64
    for name in ("tau", "clear_tau", "gain", "difference", "distance")
    for end in ("", "_low", "_high")
}


def agreement(runs: Judged) -> pl.DataFrame:
    """Return how far the queue simulator agrees with SUMO (ours; τ-b: Kendall, 1945).

    Controllers are ranked by their means over seeds, within each network; the pooled τ counts the
    pairs of all networks, and only pairs within one. Intervals are bootstrap intervals over seeds:
    a resample draws the same seeds of a network for all controllers and simulators.

    Returns
    -------
    One row per metric, queue simulator and network, and one for all (``scenario`` null):
    ``contenders`` and ``pairs``; ``tau``; ``clear_tau`` over the ``clear_pairs``, those of which
    SUMO's own paired interval shows which one is better; ``gain``: τ less that of the simulator
    before calibration; ``difference``: median over controllers of mean / SUMO's mean - 1, and
    ``distance``: the median of its absolute values. All with intervals, ``_low`` and ``_high``.
    Empty without SUMO's runs or the queue simulator's.
    """
    rows: list[dict[str, Any]] = []
    simulators = [name for name in QUEUES if name in runs.simulators]
    if runs.judge in JUDGES:
        for metric in METRICS:
            earlier: dict[str | None, Values] = {}
            for simulator in simulators:
                rows += _of_simulator(runs, metric, simulator, earlier)
    return pl.DataFrame(rows, schema=_SCHEMA).with_columns(
        pl.col(name).fill_nan(None) for name, dtype in _SCHEMA.items() if dtype == pl.Float64
    )


def _of_simulator(
    runs: Judged, metric: str, simulator: str, earlier: dict[str | None, Values]
) -> list[dict[str, Any]]:
    """Return the rows of one simulator; ``earlier`` keeps every network's τ before calibration."""
    ours, theirs = (runs.of(metric, simulator=each) for each in (simulator, runs.judge))
    every: list[dict[str, Any]] = []
    for number, scenario in enumerate(runs.scenarios):
        both = ~np.isnan(ours[number]).all(axis=1) & ~np.isnan(theirs[number]).all(axis=1)
        fast, slow = ours[number][both], theirs[number][both]
        used = ~np.isnan(slow).all(axis=0)
        if both.sum() < 2 or not used.any():
            continue
        fast, slow = fast[:, used], slow[:, used]
        weights = _weights(slow.shape[1], scenario)
        x, y = _means(fast, weights), _means(slow, weights)
        clear = _told_apart(slow)
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = x / y - 1.0
        every.append(
            {
                "scenario": scenario,
                "seeds": slow.shape[1],
                "contenders": int(both.sum()),
                "ranks": _ranks(x, y, np.ones_like(clear)),
                "clear": _ranks(x, y, clear),
                "pairs": len(clear),
                "clear_pairs": int(clear.sum()),
                "ratio": ratio,
            }
        )
    if not every:
        return []
    first, *more = every
    pooled = {
        "scenario": None,
        "seeds": min(each["seeds"] for each in every),
        **{name: sum((each[name] for each in more), first[name]) for name in _ADDED},
        "ratio": np.hstack([each["ratio"] for each in every]),
    }
    return [_row(metric, simulator, each, earlier) for each in (*every, pooled)]


def _row(
    metric: str, simulator: str, found: dict[str, Any], earlier: dict[str | None, Values]
) -> dict[str, Any]:
    seeds, scenario = found["seeds"], found["scenario"]
    tau = _tau(found["ranks"])
    row = {"metric": metric, "simulator": simulator, "scenario": scenario}
    row |= {name: found[name] for name in ("contenders", "pairs", "clear_pairs")}
    row |= _with_interval("tau", tau, seeds)
    row |= _with_interval("clear_tau", _tau(found["clear"]), seeds)
    if simulator == BEFORE:
        earlier[scenario] = tau
    elif scenario in earlier:
        row |= _with_interval("gain", tau - earlier[scenario], seeds)
    ratio = found["ratio"]
    row |= _with_interval("difference", _median(ratio), seeds)
    row |= _with_interval("distance", _median(np.abs(ratio)), seeds)
    return row


def _with_interval(name: str, values: Values, seeds: int) -> dict[str, float]:
    """Return the real value, the first, and the interval of the others."""
    low, high = float("nan"), float("nan")
    drawn = values[1:][~np.isnan(values[1:])]
    if seeds > 1 and len(drawn):
        low, high = (float(end) for end in np.quantile(drawn, interval_levels(seeds)))
    return {name: float(values[0]), f"{name}_low": low, f"{name}_high": high}


def _weights(seeds: int, scenario: str) -> Values:
    """Return how often each resample draws each seed; the first row is the real sample."""
    rng = stream(0, "bootstrap", "agreement", scenario)
    drawn = rng.multinomial(seeds, np.full(seeds, 1 / seeds), RESAMPLES)
    return np.vstack([np.ones(seeds), drawn])


def _means(values: Values, weights: Values) -> Values:
    """Return (resamples, contenders) means of (contenders, seeds), missing runs left out."""
    present = ~np.isnan(values)
    total = weights @ np.where(present, values, 0.0).T
    with np.errstate(divide="ignore", invalid="ignore"):
        means: Values = total / (weights @ present.T.astype(float))
    return means


def _tau(ranks: Values) -> Values:
    """Return τ-b of `_ranks`: 1 the same, -1 the reverse; NaN where one tells nothing apart."""
    agreeing, told_apart, told_apart_by_judge = ranks
    with np.errstate(divide="ignore", invalid="ignore"):
        tau: Values = agreeing / np.sqrt(told_apart * told_apart_by_judge)
    return tau


def _ranks(x: Values, y: Values, counted: NDArray[np.bool_]) -> Values:
    """Compare the ranks of (resamples, contenders) in two simulators, over the counted pairs.

    Returns what τ adds up, (3, resamples), the first of them real: pairs in the same order, pairs
    that either simulator tells apart.
    """
    first, second = np.triu_indices(x.shape[1], 1)
    signs = [_signs(each[:, first], each[:, second]) for each in (x, y)]
    missing = np.isnan(signs[0]) | np.isnan(signs[1]) | ~counted.astype(bool)
    a, b = (np.where(missing, 0.0, sign) for sign in signs)
    return np.array([(one * other).sum(axis=1) for one, other in ((a, b), (a, a), (b, b))])


def _signs(one: Values, other: Values) -> Values:
    # Equal runs can differ by rounding after they were averaged.
    gap = one - other
    return np.where(np.abs(gap) <= _TIE * np.abs(one), 0.0, np.sign(gap))


def _told_apart(values: Values) -> NDArray[np.bool_]:
    """Tell of which pairs of contenders the paired 95 % interval shows the better one."""
    first, second = np.triu_indices(len(values), 1)
    rng = stream(0, "bootstrap", "agreement", "pairs")
    found = mean_interval((values[first] - values[second]).T, rng)
    with np.errstate(invalid="ignore"):
        return np.asarray((found.low > 0) | (found.high < 0))


def _median(values: Values) -> Values:
    """Return the median of (resamples, contenders) over contenders, missing ones left out."""
    known = ~np.isnan(values).all(axis=1)
    median = np.full(len(values), np.nan)
    median[known] = np.nanmedian(values[known], axis=1)
    return median
