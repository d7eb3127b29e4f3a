"""Which load each controller holds, and how long vehicles are delayed up to there."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
import polars as pl

from dmil.analysis.estimates import as_column, interval_columns
from dmil.analysis.panel import RunPanel, Values
from dmil.seeding import stream
from dmil.statistics import mean_interval, paired_difference, stability
from dmil.studies.capacity.plan import CAPACITY, REFERENCE
from dmil.studies.capacity.search import highest_stable

METRIC = "delay_s"
_TIE = 1e-9


@dataclass(frozen=True, kw_only=True)
class Growth(RunPanel):
    """All searches; the axes are ``scenario``, ``controller`` and ``seed``.

    Measures are ``capacity``, the highest stable load, and ``bounded``: 0 where the highest load
    that was tried was stable.

    Attributes
    ----------
    rows: polars.DataFrame
        The runs behind it.
    tolerance: float
        Growth that still counts as none.
    """

    rows: pl.DataFrame
    tolerance: float


def searched(runs: pl.DataFrame, axes: Mapping[str, Sequence[Any]], tolerance: float) -> Growth:
    """Return what the searches of a study found; one with a failed run found nothing (ours)."""
    shape = tuple(len(values) for values in axes.values())
    measures = {name: np.full(shape, np.nan) for name in ("capacity", "bounded")}
    number = {name: {each: i for i, each in enumerate(values)} for name, values in axes.items()}
    rows = runs.filter(pl.col("preset") == CAPACITY)
    failed = rows.filter(pl.col("status") != "ok").select(list(axes))
    rows = rows.join(failed, on=list(axes), how="anti", maintain_order="left")
    for key, group in rows.group_by(*axes, maintain_order=True):
        at = tuple(number[name][value] for name, value in zip(axes, key, strict=True))
        loads, growth = group["load"].to_list(), group["growth"].to_list()
        found, at_least = highest_stable(loads, growth, tolerance)
        measures["capacity"][at], measures["bounded"][at] = found, not at_least
    return Growth(axes=axes, measures=measures, rows=rows, tolerance=tolerance)


def capacities(found: Growth) -> pl.DataFrame:
    """Return the capacity of every controller on every network (ours).

    Returns
    -------
    Columns ``scenario``, ``controller``, ``n`` seeds; ``capacity``, the mean over seeds of the
    highest stable load, with ``low`` and ``high`` (95 %); ``veh_per_h``, what that is in vehicles;
    ``unbounded``, seeds in which the highest load was stable; ``difference_pct``, the paired
    relative difference to max-pressure with its interval; ``among_best``: whether the paired
    interval of its difference to the best mean does not show it to be worse (null with one seed).
    """
    frames = []
    per_load = _veh_per_h(found.rows)
    for place in found.axes["scenario"]:
        values = found.of("capacity", scenario=place).T
        own = mean_interval(values, stream(0, "bootstrap", "capacity", place))
        base = found.of("capacity", scenario=place, controller=REFERENCE)[:, None]
        against = stream(0, "bootstrap", "capacity", place, "difference")
        to_reference = paired_difference(values, base, against, relative=True)
        frame = pl.DataFrame(
            {
                "scenario": place,
                "controller": found.axes["controller"],
                "n": own.seeds,
                **interval_columns(own, "capacity"),
                "veh_per_h": own.value * per_load.get(place, np.nan),
                "unbounded": (found.of("bounded", scenario=place) == 0).sum(axis=1),
                **interval_columns(to_reference, "difference_pct", "difference_{}", 100),
                "among_best": _among_best(values, place),
            }
        )
        frames.append(frame.filter(pl.col("n") > 0))
    return pl.concat(frames)


def _among_best(values: Values, place: str) -> pl.Series:
    with np.errstate(invalid="ignore"):
        means = np.where(np.isnan(values).all(axis=0), -np.inf, _means(values))
    best = values[:, [int(np.argmax(means))]]
    gap = paired_difference(values, best, stream(0, "bootstrap", "capacity", place, "best"))
    return as_column(gap.high) >= -_TIE


def _means(values: Values) -> Values:
    present = ~np.isnan(values)
    total = np.where(present, values, 0.0).sum(axis=0)
    return np.asarray(total / np.maximum(present.sum(axis=0), 1))


def _veh_per_h(rows: pl.DataFrame) -> dict[str, float]:
    """Return the vehicles per hour of load 1 on every network."""
    table = rows.group_by("scenario").agg(
        veh_per_h=3600 * pl.col("spawned_veh").sum() / (pl.col("load") * pl.col("horizon_s")).sum()
    )
    return dict(table.iter_rows())


def curves(found: Growth, levels: int) -> pl.DataFrame:
    """Return delay and growth over load, at the levels at which a controller ran in all seeds.

    Returns
    -------
    Columns ``scenario``, ``controller``, ``load``, ``n`` seeds; ``mean``, ``low``, ``high``: the
    delay in s; ``growth``, ``growth_low``, ``growth_high``: see `dmil.statistics.queue_growth`;
    ``verdict``, see `dmil.statistics.stability` (null with one seed); ``difference_pct`` with its
    interval: the delay against max-pressure's on the same vehicles.
    """
    rows, seeds = found.rows, found.axes["seed"]
    frames = [pl.DataFrame(schema=_CURVE)]
    for place, name in product(found.axes["scenario"], found.axes["controller"]):
        own = rows.filter(scenario=place, controller=name)
        complete = int((~np.isnan(found.of("capacity", scenario=place, controller=name))).sum())
        loads = _levels(own, levels, complete)
        if not loads:
            continue
        values = {each: _by_load(own, loads, seeds, each) for each in (METRIC, "growth")}
        base = rows.filter(scenario=place, controller=REFERENCE)
        delay, growth = (
            mean_interval(each, stream(0, "bootstrap", "curves", place, measure))
            for measure, each in values.items()
        )
        against = paired_difference(
            values[METRIC],
            _by_load(base, loads, seeds, METRIC),
            stream(0, "bootstrap", "curves", place, "difference"),
            relative=True,
        )
        ends = zip(growth.low, growth.high, strict=True)
        frame = pl.DataFrame(
            {
                "scenario": place,
                "controller": name,
                "load": loads,
                "n": delay.seeds,
                **interval_columns(delay),
                **interval_columns(growth, "growth", "growth_{}"),
                "verdict": [
                    None if np.isnan(low) else stability(low, high, found.tolerance)
                    for low, high in ends
                ],
                **interval_columns(against, "difference_pct", "difference_{}", 100),
            },
            schema=_CURVE,
        )
        frames.append(frame)
    return pl.concat(frames)


_CURVE: dict[str, Any] = {
    "scenario": pl.String,
    "controller": pl.String,
    "load": pl.Float64,
    "n": pl.Int64,
    **dict.fromkeys(("mean", "low", "high", "growth", "growth_low", "growth_high"), pl.Float64),
    "verdict": pl.String,
    **dict.fromkeys(("difference_pct", "difference_low", "difference_high"), pl.Float64),
}


def _levels(own: pl.DataFrame, levels: int, complete: int) -> list[float]:
    """Return the levels at which a controller ran in all seeds of which a search is known.

    The loads of bisections lie between levels, and differ from seed to seed.
    """
    counts = own.group_by("load").len().sort("load")
    step = own["load"].min()  # the first level is run first, in every search
    found = []
    for load, count in counts.iter_rows():
        level = load / float(step)  # type: ignore[arg-type]
        if abs(level - round(level)) < _TIE and round(level) <= levels and count == complete:
            found.append(load)
    return found


def _by_load(
    own: pl.DataFrame, loads: Sequence[float], seeds: Sequence[int], measure: str
) -> Values:
    """Return a measure as (seeds, loads); NaN where there is no run."""
    found = np.full((len(seeds), len(loads)), np.nan)
    at = {load: number for number, load in enumerate(loads)}
    row = {seed: number for number, seed in enumerate(seeds)}
    for seed, load, value in own.select("seed", "load", measure).iter_rows():
        if load in at and value is not None:
            found[row[seed], at[load]] = value
    return found
