"""The report of the study of capacity."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import polars as pl

from dmil.analysis.panel import rows_by
from dmil.reports.contenders import controller_name
from dmil.reports.export import Figure, csv
from dmil.reports.html import check_preset, configuration_rows, environment, shared_values
from dmil.results import Results
from dmil.studies.capacity.disturbed import PASSING
from dmil.studies.capacity.figures import figures_of_study
from dmil.studies.capacity.names import DISTURBANCE_LABELS, EXPLAINED, place_label
from dmil.studies.capacity.plan import CAPACITY, REFERENCE
from dmil.studies.capacity.recoveries import UNDISTURBED
from dmil.studies.capacity.tables import CapacityTables, capacity_tables

CSV = ("capacities", "curves", "disturbances", "courses", "failures")


class CapacityReport:
    """What the report of the study of capacity is made of: a `dmil.studies.registry.Report`."""

    def __init__(
        self, results: Results, tables: CapacityTables | None = None, preset: str | None = None
    ) -> None:
        check_preset(preset, CAPACITY)
        self._results = results
        self._tables = tables or capacity_tables(results)
        self._configuration = results.manifest.get("configuration", {})

    def tables(self) -> dict[str, str | bytes]:
        """Return the tables' files by name."""
        return {f"tables/{name}.csv": csv(getattr(self._tables, name)) for name in CSV}

    def figures(self) -> Iterator[Figure]:
        """Yield the figures as they are made."""
        yield from figures_of_study(self._tables, self._configuration["horizon_s"])

    def pages(self, figures: list[Figure]) -> dict[str, str]:
        """Return the page by its name."""
        templates = environment(__package__)
        templates.filters |= {"controller": controller_name, "place": place_label}
        values = shared_values(self._results, figures) | self._values()
        return {"report.html": templates.get_template("page.html.j2").render(values)}

    def _values(self) -> dict[str, Any]:
        made = self._tables
        disturbed = made.disturbances
        return {
            "networks": made.networks,
            "controllers": made.controllers,
            "seeds": made.seeds,
            "capacity": rows_by(made.capacities, "scenario", "controller"),
            "best": best_of(made),
            "curves": made.curves.rows(named=True),
            "disturbed": rows_by(disturbed, "scenario", "controller", "disturbance"),
            "load": dict(disturbed.select("scenario", "load").unique().iter_rows()),
            "undisturbed": UNDISTURBED,
            "disturbances": DISTURBANCE_LABELS,
            "passing": PASSING,
            "explained": EXPLAINED,
            "reference": REFERENCE,
            "failures": made.failures.rows(named=True),
            "settings": self._configuration,
            "configuration": configuration_rows(self._configuration),
        }


def best_of(tables: CapacityTables) -> dict[str, list[str]]:
    """Return the controllers of every network that are not shown to hold less than the best."""
    chosen = tables.capacities.filter(pl.col("among_best"))
    return {
        place: chosen.filter(scenario=place)
        .sort("capacity", descending=True)["controller"]
        .to_list()
        for place in tables.networks
    }


REPORT = CapacityReport
"""What makes the report of such a study."""
