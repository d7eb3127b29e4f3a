"""What disturbances cost: delay, and the time until they are over."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product
from typing import Any

import numpy as np
import polars as pl

from dmil.analysis.estimates import interval_columns, learning_curve
from dmil.analysis.panel import Values, on_axes
from dmil.results import Results
from dmil.seeding import stream
from dmil.statistics import mean_interval, paired_difference
from dmil.studies.capacity.capacities import METRIC
from dmil.studies.capacity.disturbed import (
    CLOSED_S,
    INCIDENT,
    PASSING,
    REFERENCE_OF,
    SURGE,
    SURGE_S,
    begin_s,
)
from dmil.studies.capacity.names import DISTURBANCE_LABELS
from dmil.studies.capacity.plan import DISTURBANCES, REFERENCE

UNDISTURBED = "undisturbed"
VARIANTS = (UNDISTURBED, *DISTURBANCE_LABELS)
LASTS_S = {INCIDENT: CLOSED_S, SURGE: SURGE_S}
_SCHEMA: dict[str, Any] = {
    **dict.fromkeys(("scenario", "controller", "disturbance"), pl.String),
    "load": pl.Float64,
    "n": pl.Int64,
    **{
        f"{name}{end}": pl.Float64
        for name in ("delay_s", "added_s", "difference_pct", "recovery_s")
        for end in ("", "_low", "_high")
    },
    "lasting": pl.Int64,
}
_COURSE: dict[str, Any] = {
    **dict.fromkeys(("scenario", "controller", "disturbance"), pl.String),
    "time_s": pl.Int64,
    **dict.fromkeys(("mean", "low", "high"), pl.Float64),
}


def disturbances(runs: pl.DataFrame, axes: Mapping[str, Sequence[Any]]) -> pl.DataFrame:
    """Return what every disturbance costs every controller (ours).

    Returns
    -------
    Columns ``scenario``, ``controller``, ``disturbance`` (the column ``variant``, or
    ``undisturbed``), ``load``, ``n`` seeds; ``delay_s``; ``added_s``, the paired difference to the
    undisturbed run (other-day: to that on the day trained on); ``difference_pct``, the paired
    relative difference of the delay to max-pressure's under the same disturbance; ``recovery_s``,
    runs that do not recover counted up to their end; all with ``_low`` and ``_high`` (95 %);
    ``lasting``: seeds in which it does not recover.
    """
    own = runs.filter(pl.col("preset") == DISTURBANCES, pl.col("status") == "ok")
    if own.is_empty():
        return pl.DataFrame(schema=_SCHEMA)
    known = own["variant"].fill_null(UNDISTURBED)
    all_axes = {**axes, "variant": list(dict.fromkeys([UNDISTURBED, *sorted(known)]))}
    array = on_axes(own, all_axes, variant=known.to_list())
    delay, recovery, load, horizon = map(array, (METRIC, "recovery_s", "load", "horizon_s"))
    at = {name: number for number, name in enumerate(all_axes["variant"])}
    frames = [pl.DataFrame(schema=_SCHEMA)]
    for (p, place), name in product(enumerate(axes["scenario"]), VARIANTS):
        if name not in at:
            continue
        values, taken = delay[p, :, :, at[name]].T, recovery[p, :, :, at[name]].T
        normal = at.get(REFERENCE_OF.get(name) or UNDISTURBED)
        calm = np.full_like(values, np.nan) if normal is None else delay[p, :, :, normal].T
        end_s = begin_s(int(np.nanmax(horizon))) + LASTS_S.get(name, 0)
        with np.errstate(invalid="ignore"):
            lasting = (taken >= horizon[p, :, :, at[name]].T - end_s).sum(axis=0)
        frame = _frame(place, name, axes["controller"], values, calm, taken).with_columns(
            load=pl.lit(float(np.nanmax(load[p])) if (~np.isnan(load[p])).any() else None),
            lasting=pl.Series(lasting) if name in PASSING else pl.lit(None, pl.Int64),
        )
        kept = frame.filter(pl.col("n") > 0)
        frames.append(kept.select(pl.col(n).cast(dtype) for n, dtype in _SCHEMA.items()))
    return pl.concat(frames)


def _frame(
    place: str,
    name: str,
    controllers: Sequence[str],
    values: Values,
    calm: Values,
    taken: Values,
) -> pl.DataFrame:
    """Return estimates from (seeds, controllers): delay, that without, and time to recover."""
    label = "bootstrap", "disturbances", place, name
    reference = (
        values[:, [controllers.index(REFERENCE)]]
        if REFERENCE in controllers
        else np.full((len(values), 1), np.nan)
    )
    delay = mean_interval(values, stream(0, *label))
    added = paired_difference(values, calm, stream(0, *label, "added"))
    against = paired_difference(values, reference, stream(0, *label, "against"), relative=True)
    over = mean_interval(taken, stream(0, *label, "recovery"))
    return pl.DataFrame(
        {
            "scenario": place,
            "controller": controllers,
            "disturbance": name,
            "n": delay.seeds,
            **interval_columns(delay, "delay_s", "delay_s_{}"),
            **interval_columns(added, "added_s", "added_s_{}"),
            **interval_columns(against, "difference_pct", "difference_pct_{}", 100),
            **interval_columns(over, "recovery_s", "recovery_s_{}"),
        }
    )


def courses(results: Results, axes: Mapping[str, Sequence[Any]]) -> pl.DataFrame:
    """Return how many more vehicles wait than undisturbed, over time, of disturbances that end.

    Returns
    -------
    Columns ``scenario``, ``controller``, ``disturbance``, ``time_s``, ``mean``, ``low``, ``high``:
    the paired difference in vehicles.
    """
    rows = results.query(
        "select scenario, controller, seed, variant, time_s, queue_veh from series"
        f" where preset = '{DISTURBANCES}'"
    )
    key = ["scenario", "controller", "seed", "time_s"]
    calm = rows.filter(pl.col("variant").is_null()).select(*key, calm_veh="queue_veh")
    rows = rows.join(calm, on=key, maintain_order="left").with_columns(
        excess=(pl.col("queue_veh") - pl.col("calm_veh")).cast(pl.Float64)
    )
    frames = [pl.DataFrame(schema=_COURSE)]
    for place, name, variant in product(axes["scenario"], axes["controller"], PASSING):
        own = rows.filter(scenario=place, controller=name, variant=variant)
        if own.is_empty():
            continue
        rng = stream(0, "bootstrap", "courses", place, variant)
        times, _, found = learning_curve(own, "time_s", "excess", rng)
        frame = {"scenario": place, "controller": name, "disturbance": variant, "time_s": times}
        frames.append(pl.DataFrame(frame | interval_columns(found), schema=_COURSE))
    return pl.concat(frames)
