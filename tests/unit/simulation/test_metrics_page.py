"""The page about metrics says what the table of metrics says, and leaves none of its counts out."""

from dataclasses import fields
from pathlib import Path

import numpy as np

from dmil.results import RUNS_SCHEMA
from dmil.simulation.definitions import COUNTING, metrics_markdown
from dmil.simulation.measures import METRICS, Measures

PAGE = Path(__file__).parents[3] / "docs" / "metrics.md"


class _Watched:
    """Measures that remember which raw counts were asked for."""

    def __init__(self, measures):
        self._measures, self.asked = measures, set()

    def __getattr__(self, name):
        if name in {field.name for field in fields(Measures)}:
            self.asked.add(name)
            return getattr(self._measures, name)
        return getattr(Measures, name).fget(self)


def counts_of(metric):
    none = np.zeros(0, np.int32)
    watched = _Watched(
        Measures(10, 4, 3, 20.0, 5, 9.0, 90.0, 30.0, 2.0, 7, 1, none, none, 5.0, 6.0)
    )
    metric.of(watched)
    return watched.asked


def test_docs_hold_the_metrics():
    assert PAGE.read_text(encoding="utf-8").endswith(metrics_markdown())


def test_every_metric_is_a_column_of_the_results():
    assert set(METRICS) <= set(RUNS_SCHEMA)


def test_everything_that_a_metric_is_made_of_is_explained():
    asked = set().union(*(counts_of(metric) for metric in METRICS.values()))
    assert {"time_loss_veh_s", "spawned_veh", "co2_g"} <= asked
    assert asked - {"time_s"} <= set(COUNTING)


def test_only_counts_that_exist_are_explained():
    assert set(COUNTING) <= {field.name for field in fields(Measures)}
