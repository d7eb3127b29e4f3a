"""A trial's columns, and what a run leaves behind: rows for the tables of results."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields
from typing import Any

from dmil.controllers import MemoryUse
from dmil.controllers.variants import Variant
from dmil.network import RoadNetwork
from dmil.results.metrics import METRICS
from dmil.simulation import Measures
from dmil.training import Run

Row = dict[str, Any]
SIMULATOR = "queue"
"""Where runs happen, if nothing else is said."""


@dataclass(frozen=True, slots=True)
class TrialResult:
    """Rows for the tables of results (`dmil.results.schema`) that a trial gave."""

    trial: Any
    runs: list[Row]
    series: list[Row]
    episodes: list[Row] = field(default_factory=list)
    lookups: list[Row] = field(default_factory=list)
    timings: list[Row] = field(default_factory=list)


def columns_of(trial: Any) -> Row:
    """Return a trial's fields as columns of the table of runs: a variant is its label."""
    values = {each.name: getattr(trial, each.name) for each in fields(trial)}
    return {name: v.label if isinstance(v, Variant) else v for name, v in values.items()}


def measures_row(measures: Measures, memory: MemoryUse) -> Row:
    """Return a run's totals as columns of the table of runs (specification, §3)."""
    row: Row = {}
    for name, metric in METRICS.items():
        if metric.stored:
            source = memory if metric.memory else measures
            value = getattr(source, name.removesuffix("_per_agent"))
            unknown = (metric.sumo_only or metric.cityflow_only) and math.isnan(value)
            row[name] = None if unknown else value
    return row


def run_row(run: Run, network: RoadNetwork) -> Row:
    """Return a run's totals with the memory at its end, that of an intersection, too."""
    row = measures_row(run.measures, run.memory[-1])
    return row | {"bytes_per_intersection": row["bytes_total"] / len(network.intersections)}
