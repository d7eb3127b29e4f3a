"""Every metric of the catalogue stands in schema, rows, docs and tables."""

import math
from dataclasses import fields, replace
from pathlib import Path

import numpy as np

from dmil.controllers import NO_MEMORY
from dmil.experiments.trial import measures_row
from dmil.results import RUNS, metrics
from dmil.results.metrics import METRICS
from dmil.simulation.definitions import COUNTING, metrics_markdown
from dmil.simulation.measures import Measures

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


NONE = np.zeros(0, np.int32)
MEASURES = Measures(10, 4, 3, 20.0, 5, 9.0, 90.0, 30.0, 2.0, 7, 1, NONE, NONE, 5.0, 6.0)
TABLES = ("RUN_TABLE", "COMPARISON_TABLE", "COMPARISON_PAGE", "NETWORK_PAGE", "SCORES", "EPISODE")
NOT_SHOWN = {
    "last_minus_first_s",
    "entering_lanes_s",
    "wait_veh_s",
    "entries_total",
    "messages",
    "exchanged_bytes",
}
"""What results hold for queries alone."""


def counts_of(name):
    watched = _Watched(MEASURES)
    getattr(watched, name)
    return watched.asked


def test_docs_hold_the_metrics():
    assert PAGE.read_text(encoding="utf-8").endswith(metrics_markdown())


def test_every_metric_stands_in_schema_rows_and_docs_in_its_order():
    stored = {name: each for name, each in METRICS.items() if each.stored}
    assert list(measures_row(MEASURES, NO_MEMORY)) == list(stored)
    columns = {column.name: column for column in RUNS}
    assert [name for name in columns if name in METRICS] == list(stored)
    for name, each in stored.items():
        assert (columns[name].unit, columns[name].meaning) == (each.unit, each.meaning)
        assert each.meaning.endswith(".")


def test_every_metric_stands_in_a_table_and_every_table_has_metrics_alone():
    shown = set().union(*(getattr(metrics, name) for name in TABLES))
    assert shown == METRICS.keys() - NOT_SHOWN
    assert all(METRICS[name].better == "less" for name in metrics.COMPARED)


def test_only_what_sumo_alone_knows_is_null_in_the_queue_simulator():
    row = measures_row(replace(MEASURES, co2_g=math.nan, fuel_g=math.nan), NO_MEMORY)
    assert {name for name in row if row[name] is None} == {
        name for name, each in METRICS.items() if each.sumo_only or each.cityflow_only
    }


def test_everything_that_a_metric_is_made_of_is_explained():
    own = [name for name, each in METRICS.items() if each.stored and not each.memory]
    asked = set().union(*map(counts_of, own))
    assert {"time_loss_veh_s", "spawned_veh", "co2_g"} <= asked
    assert asked - {"time_s"} <= set(COUNTING)


def test_only_counts_that_exist_are_explained():
    assert set(COUNTING) <= {field.name for field in fields(Measures)}
