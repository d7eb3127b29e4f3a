"""The tables of the study of protocols."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import polars as pl

from dmil.analysis.panel import check_success
from dmil.results import Results
from dmil.seeding import stream
from dmil.statistics import mean_interval
from dmil.studies.protocols.published import COUNTERPART, PUBLISHED
from dmil.studies.protocols.recipes import PROTOCOLS
from dmil.studies.protocols.rule import NAME

BASE = "llmlight-30-5-4"
"""Protocol that differences between recipes start from."""
WHOLE_TRIP, AT_LANES = "travel_time_s", "last_minus_first_s"
RULES = ("max-pressure", NAME)
KEYS = ["preset", "scenario", "simulator", "controller"]


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
        What of a gain comes from method, from interval and phases, and from the measure.
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
    runs = runs.filter(pl.col("status") == "ok")
    ours = _ours(runs)
    return ProtocolsTables(ours, _published(ours), _split(runs), _agreement(runs))


def _ours(runs: pl.DataFrame) -> pl.DataFrame:
    rng, rows = stream(0, "bootstrap", "protocols"), []
    for key, group in runs.group_by(KEYS, maintain_order=True):
        protocol, simulator = str(key[0]), str(key[2])
        wanted = PROTOCOLS[protocol].measure
        # The queue simulator does not know lanes: there the whole trip stands in.
        measure = wanted if group[wanted].null_count() == 0 else WHOLE_TRIP
        recorded = group.filter(pl.col("seed") == 0)[measure].to_list()
        others = group.filter(pl.col("seed") > 0)[measure].to_numpy()
        row: dict[str, Any] = dict(zip(KEYS, key, strict=True)) | {
            "measure": measure,
            "same_recipe": simulator == PROTOCOLS[protocol].simulator,
            "recorded_s": recorded[0] if recorded else None,
            "days": len(others),
            "mean_s": None,
            "low_s": None,
            "high_s": None,
        }
        if len(others):
            found = mean_interval(others.reshape(-1, 1), rng)
            row["mean_s"] = float(found.value[0])
            if len(others) > 1:
                row |= {"low_s": float(found.low[0]), "high_s": float(found.high[0])}
        rows.append(row)
    return pl.DataFrame(rows, infer_schema_length=None)


def _published(ours: pl.DataFrame) -> pl.DataFrame:
    rows = []
    for (protocol, method), figures in PUBLISHED.items():
        for city, value in figures.items():
            own = ours.filter(
                (pl.col("preset") == protocol)
                & (pl.col("scenario") == city)
                & (pl.col("controller") == COUNTERPART.get(method, ""))
                & pl.col("same_recipe")
            )["recorded_s"].to_list()
            rows.append(
                {
                    "preset": protocol,
                    "scenario": city,
                    "method": method,
                    "published_s": value,
                    "ours_s": own[0] if own else None,
                }
            )
    return pl.DataFrame(rows, infer_schema_length=None)


def _split(runs: pl.DataFrame) -> pl.DataFrame:
    """Take three differences of means over days, each with all else equal."""
    lanes = runs.filter(pl.col(AT_LANES).is_not_null() & (pl.col("controller") != NAME))
    means = lanes.group_by("preset", "scenario", "controller", maintain_order=True).agg(
        pl.col(AT_LANES).mean(), pl.col(WHOLE_TRIP).mean()
    )
    known = {(r["preset"], r["scenario"], r["controller"]): r for r in means.iter_rows(named=True)}
    rows = []
    for (protocol, city, controller), rule in known.items():
        if controller != "max-pressure":
            continue
        base = known.get((BASE, city, controller))
        here = means.filter((pl.col("preset") == protocol) & (pl.col("scenario") == city))
        best = here.sort(AT_LANES)
        rows.append(
            {
                "preset": protocol,
                "scenario": city,
                "best": best["controller"][0],
                "method_s": best[AT_LANES][0] - rule[AT_LANES],
                "interval_and_phases_s": rule[AT_LANES] - base[AT_LANES] if base else None,
                "measure_s": rule[AT_LANES] - rule[WHOLE_TRIP],
            }
        )
    schema = {"preset": pl.String, "scenario": pl.String, "best": pl.String} | dict.fromkeys(
        ("method_s", "interval_and_phases_s", "measure_s"), pl.Float64
    )
    return pl.DataFrame(rows, schema=schema)


def _agreement(runs: pl.DataFrame) -> pl.DataFrame:
    means = runs.group_by(KEYS, maintain_order=True).agg(pl.col(WHOLE_TRIP).mean())
    queue = means.filter(pl.col("simulator") == "queue").drop("simulator")
    judged = means.filter(pl.col("simulator") != "queue").drop("simulator")
    pairs = judged.join(queue, on=["preset", "scenario", "controller"], suffix="_queue")
    rows = []
    for (protocol, city), group in pairs.group_by("preset", "scenario", maintain_order=True):
        ratio = (group[f"{WHOLE_TRIP}_queue"] / group[WHOLE_TRIP]).median()
        assert isinstance(ratio, float)
        rows.append(
            {
                "preset": protocol,
                "scenario": city,
                "controllers": group.height,
                "error_pct": 100 * (ratio - 1),
                "tau": _tau(group[WHOLE_TRIP].to_list(), group[f"{WHOLE_TRIP}_queue"].to_list()),
            }
        )
    schema = {"preset": pl.String, "scenario": pl.String, "controllers": pl.Int64} | dict.fromkeys(
        ("error_pct", "tau"), pl.Float64
    )
    return pl.DataFrame(rows, schema=schema)


def _tau(one: Sequence[float], other: Sequence[float]) -> float | None:
    """Return the share of pairs in the same order minus those in the opposite one."""
    first, second = (np.subtract.outer(v, v)[np.triu_indices(len(v), 1)] for v in (one, other))
    return float(np.sign(first * second).mean()) if first.size else None
