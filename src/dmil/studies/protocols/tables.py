"""The tables of the study of protocols."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import polars as pl

from dmil.analysis.panel import check_success
from dmil.controllers import RECOMMENDED
from dmil.results import Results
from dmil.seeding import stream
from dmil.statistics import mean_interval
from dmil.studies.protocols.plan import CITYFLOW, QUEUE
from dmil.studies.protocols.published import COUNTERPART, PUBLISHED
from dmil.studies.protocols.recipes import (
    AT_LANES,
    HORIZON_S,
    LLMLIGHT,
    PROTOCOLS,
    WHOLE_TRIP,
)
from dmil.studies.protocols.rule import NAME

RULE, METHOD = NAME, RECOMMENDED
"""What a difference of methods is taken between; both fixed before the runs."""
KEYS = ["preset", "scenario", "simulator", "controller"]
_TEXTS = dict.fromkeys(("preset", "scenario"), pl.String)
_OURS: dict[str, Any] = (
    dict.fromkeys((*KEYS, "measure"), pl.String)
    | {"same_recipe": pl.Boolean, "recorded_s": pl.Float64, "days": pl.Int64}
    | dict.fromkeys(("mean_s", "low_s", "high_s"), pl.Float64)
)
_PUBLISHED: dict[str, Any] = (
    _TEXTS | {"method": pl.String} | dict.fromkeys(("published_s", "ours_s"), pl.Float64)
)
_SPLIT: dict[str, Any] = _TEXTS | dict.fromkeys(
    ("method_s", "interval_and_phases_s", "measure_s"), pl.Float64
)
_AGREEMENT: dict[str, Any] = (
    _TEXTS | {"controllers": pl.Int64} | dict.fromkeys(("error_pct", "tau"), pl.Float64)
)


@dataclass(frozen=True)
class ProtocolsTables:
    """All tables of the study.

    Attributes
    ----------
    ours: pl.DataFrame
        For every protocol, city, simulator and controller: the measure of the protocol on the
        recorded day, and over the other days the mean with its interval.
    published: pl.DataFrame
        Published figures, and ours of the same rule where there is one.
    split: pl.DataFrame
        Three differences, each with all else equal: of methods, of interval and phases, of
        measures.
    agreement: pl.DataFrame
        The queue simulator against CityFlow by whole-trip travel time: error and Kendall's τ.
    """

    ours: pl.DataFrame
    published: pl.DataFrame
    split: pl.DataFrame
    agreement: pl.DataFrame


def protocols_tables(results: Results) -> ProtocolsTables:
    """Make all tables (ours).

    Raises
    ------
    InputError
        No run succeeded.
    """
    runs = results.query("select * from runs")
    check_success(runs, results)
    return tables_of_runs(runs.filter(pl.col("status") == "ok"))


def tables_of_runs(runs: pl.DataFrame) -> ProtocolsTables:
    """Make all tables of runs that succeeded (ours)."""
    ours = _ours(runs)
    return ProtocolsTables(ours, _published(ours), _split(runs), _agreement(runs))


def _ours(runs: pl.DataFrame) -> pl.DataFrame:
    rng, rows = stream(0, "bootstrap", "protocols"), []
    for key, group in runs.group_by(KEYS, maintain_order=True):
        wanted = PROTOCOLS[str(key[0])].measure
        # The queue simulator does not know lanes: there the whole trip stands in.
        measure = wanted if group[wanted].null_count() == 0 else WHOLE_TRIP
        recorded = group.filter(pl.col("seed") == 0)[measure].to_list()
        others = group.filter(pl.col("seed") > 0)[measure].to_numpy()
        row: dict[str, Any] = dict(zip(KEYS, key, strict=True)) | {
            "measure": measure,
            # A shorter run is another recipe.
            "same_recipe": key[2] == CITYFLOW and (group["horizon_s"] == HORIZON_S).all(),
            "recorded_s": recorded[0] if recorded else None,
            "days": len(others),
        }
        if len(others):
            row["mean_s"] = float(others.mean())
        if len(others) > 1:
            found = mean_interval(others.reshape(-1, 1), rng)
            row |= {"low_s": float(found.low[0]), "high_s": float(found.high[0])}
        rows.append(dict.fromkeys(_OURS) | row)
    return pl.DataFrame(rows, schema=_OURS)


def _published(ours: pl.DataFrame) -> pl.DataFrame:
    same = ours.filter("same_recipe")
    figures = {
        (row["preset"], row["scenario"], row["controller"]): row["recorded_s"]
        for row in same.iter_rows(named=True)
    }
    rows = [
        {
            "preset": protocol,
            "scenario": city,
            "method": method,
            "published_s": value,
            "ours_s": figures.get((protocol, city, COUNTERPART.get(method, ""))),
        }
        for (protocol, method), of_cities in PUBLISHED.items()
        for city, value in of_cities.items()
        if not same.filter(preset=protocol, scenario=city).is_empty()
    ]
    return pl.DataFrame(rows, schema=_PUBLISHED)


def _split(runs: pl.DataFrame) -> pl.DataFrame:
    means = (
        runs.filter(pl.col("simulator") == CITYFLOW)
        .group_by("preset", "scenario", "controller", maintain_order=True)
        .agg(pl.col(AT_LANES).mean(), pl.col(WHOLE_TRIP).mean())
    )
    known = {(r["preset"], r["scenario"], r["controller"]): r for r in means.iter_rows(named=True)}
    rows = [
        {
            "preset": protocol,
            "scenario": city,
            "method_s": _less(known.get((protocol, city, METHOD)), rule),
            "interval_and_phases_s": _less(rule, known.get((LLMLIGHT, city, RULE))),
            "measure_s": rule[AT_LANES] - rule[WHOLE_TRIP],
        }
        for (protocol, city, controller), rule in known.items()
        if controller == RULE
    ]
    return pl.DataFrame(rows, schema=_SPLIT)


def _less(one: Mapping[str, Any] | None, other: Mapping[str, Any] | None) -> float | None:
    return None if one is None or other is None else float(one[AT_LANES] - other[AT_LANES])


def _agreement(runs: pl.DataFrame) -> pl.DataFrame:
    means = runs.group_by(KEYS, maintain_order=True).agg(pl.col(WHOLE_TRIP).mean())
    queue, judged = (
        means.filter(pl.col("simulator") == name).drop("simulator") for name in (QUEUE, CITYFLOW)
    )
    # Both in the order of the runs, so that the bytes do not depend on a hash.
    pairs = judged.join(queue, on=KEYS[:2] + KEYS[3:], suffix="_queue", maintain_order="left")
    rows = []
    for (protocol, city), group in pairs.group_by("preset", "scenario", maintain_order=True):
        ratios = (group[f"{WHOLE_TRIP}_queue"] / group[WHOLE_TRIP]).to_numpy()
        rows.append(
            {
                "preset": protocol,
                "scenario": city,
                "controllers": group.height,
                "error_pct": 100 * (float(np.median(ratios)) - 1),
                "tau": _tau(group[WHOLE_TRIP].to_list(), group[f"{WHOLE_TRIP}_queue"].to_list()),
            }
        )
    return pl.DataFrame(rows, schema=_AGREEMENT)


def _tau(one: Sequence[float], other: Sequence[float]) -> float | None:
    """Return the share of pairs in the same order minus those in the opposite one."""
    first, second = (np.subtract.outer(v, v)[np.triu_indices(len(v), 1)] for v in (one, other))
    return float(np.sign(first * second).mean()) if first.size else None
