"""The report of an ablation: its figure, one page, its tables as files."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from dmil.analysis.panel import rows_by
from dmil.reports.export import Figure, csv, latex
from dmil.reports.html import check_preset, configuration_rows, environment, shared_values
from dmil.reports.labels import interval, short_label, signed
from dmil.results import Results
from dmil.studies.ablation.figures import figures_of_study
from dmil.studies.ablation.names import cell_label
from dmil.studies.ablation.plan import PRESET
from dmil.studies.ablation.tables import AblationTables, ablation_tables

CSV = "delays", "differences", "locks", "failures"


class AblationReport:
    """What the report of an ablation is made of: a `dmil.studies.registry.Report`."""

    def __init__(
        self, results: Results, tables: AblationTables | None = None, preset: str | None = None
    ) -> None:
        check_preset(preset, PRESET)
        self._results = results
        self._tables = tables or ablation_tables(results)

    def tables(self) -> dict[str, str | bytes]:
        """Return the tables' files by name."""
        made = self._tables
        return {
            **{f"tables/{name}.csv": csv(getattr(made, name)) for name in CSV},
            "tables/differences.md": differences_markdown(made),
            "tables/differences.tex": differences_latex(made),
        }

    def figures(self) -> Iterator[Figure]:
        """Yield the figure."""
        yield from figures_of_study(self._tables)

    def pages(self, figures: list[Figure]) -> dict[str, str]:
        """Return the page by its name."""
        templates = environment(__package__)
        templates.filters |= {"cell": cell_label}
        values = shared_values(self._results, figures) | self._values()
        return {"report.html": templates.get_template("page.html.j2").render(values)}

    def _values(self) -> dict[str, Any]:
        made, runs = self._tables, self._tables.runs
        configuration = self._results.manifest.get("configuration", {})
        return {
            "cells": runs.cells,
            "seeds": runs.seeds,
            "controllers": runs.controllers,
            "changes": runs.changes,
            "delays": rows_by(made.delays, "cell", "controller"),
            "differences": rows_by(made.differences, "cell", "controller", "change"),
            "locks": made.locks.rows(named=True),
            "failures": made.failures.rows(named=True),
            "configuration": configuration_rows(configuration),
        }


REPORT = AblationReport
"""What makes the report of such a study."""


def differences_markdown(tables: AblationTables) -> str:
    """Return what every part changes in every case, in %, as Markdown."""
    parts = []
    for name, head, rows in _by_controller(tables):
        lines = ["| " + " | ".join(row) + " |" for row in (head, *rows)]
        rule = "|-|" + "-:|" * (len(head) - 1)
        parts += [f"**{short_label(name)}**", "", lines[0], rule, *lines[1:], ""]
    return "\n".join(parts)


def differences_latex(tables: AblationTables) -> str:
    r"""Return what every part changes in every case, in %, as a LaTeX tabular."""
    found = list(_by_controller(tables))
    notes = ["difference in delay in %: interquartile mean of paired differences, 95 % interval"]
    parts = [
        [[_safe(cell) for cell in row] for row in ([short_label(name), *[""] * (len(head) - 1)],)]
        + [[_safe(cell) for cell in row] for row in rows]
        for name, head, rows in found
    ]
    return latex(notes, [_safe(cell) for cell in found[0][1]], *parts)


def _by_controller(tables: AblationTables) -> Iterator[tuple[str, list[str], list[list[str]]]]:
    """Yield every controller, with heads and rows: its delay in s, then changes in %."""
    runs = tables.runs
    usual = rows_by(tables.delays, "cell", "controller")
    changed = rows_by(tables.differences, "cell", "controller", "change")
    head = ["", *map(cell_label, runs.cells)]
    for name in runs.controllers:
        rows = [["as it is, s", *(_delay(usual.get((cell, name))) for cell in runs.cells)]]
        for change in runs.changes:
            found = [changed.get((cell, name, change)) for cell in runs.cells]
            if any(found):
                rows.append([change, *map(_difference, found)])
        yield name, head, rows


def _delay(row: dict[str, Any] | None) -> str:
    if row is None or row["delay_s"] is None:
        return ""
    return f"{row['delay_s']:.1f}" + _locked(row)


def _difference(row: dict[str, Any] | None) -> str:
    if row is None or row["pct"] is None:
        return "–"
    if row["alike"] == 1.0:
        return "0"
    ends = interval(row["pct_low"], row["pct_high"], 1)
    return f"{signed(row['pct'])} {ends}".rstrip() + _locked(row)


def _locked(row: dict[str, Any]) -> str:
    return f" ({row['locked']} locked)" if row["locked"] else ""


def _safe(text: str) -> str:
    return (
        text.replace("%", r"\%").replace("_", r"\_").replace("×", r"$\times$").replace("−", "$-$")
    )
