"""What a run leaves behind: rows for the tables of results."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

from dmil.controllers import MemoryUse
from dmil.results.metrics import METRICS
from dmil.simulation import Measures

Row = dict[str, Any]
SIMULATOR = "queue"
"""Where runs happen, if nothing else is said."""


@dataclass(frozen=True, slots=True)
class TrialResult:
    """Rows for the tables of results.

    Attributes
    ----------
    trial: data class
        Which; see `dmil.experiments.study.Study`.
    runs, series, episodes, lookups, timings: lists of rows
        See `dmil.results.schema`.
    """

    trial: Any
    runs: list[Row]
    series: list[Row]
    episodes: list[Row] = field(default_factory=list)
    lookups: list[Row] = field(default_factory=list)
    timings: list[Row] = field(default_factory=list)


def measures_row(measures: Measures, memory: MemoryUse) -> Row:
    """Return a run's totals as columns of the table of runs (specification, §3)."""
    row: Row = {}
    for name, metric in METRICS.items():
        if metric.stored:
            source = memory if metric.memory else measures
            value = getattr(source, name.removesuffix("_per_agent"))
            row[name] = None if metric.sumo_only and math.isnan(value) else value
    return row
