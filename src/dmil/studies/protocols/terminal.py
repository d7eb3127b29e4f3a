"""What the study of protocols says in a terminal: methods by cities, published figures below."""

from __future__ import annotations

from typing import Any

import polars as pl
from rich import box
from rich.console import Group
from rich.table import Table
from rich.text import Text

from dmil.analysis.panel import rows_by
from dmil.reports.contenders import controller_name
from dmil.reports.labels import simulator_label
from dmil.results.metrics import METRICS
from dmil.studies.protocols.plan import CITYFLOW
from dmil.studies.protocols.tables import ProtocolsTables, protocols_tables

NAME_WIDTH = 16
"""Least width of the column of names, in characters."""

tables_of = protocols_tables


def in_terminal(tables: ProtocolsTables) -> list[Group | list[Text]]:
    """Return the parts that are shown, lines of text as lists."""
    parts = tables.ours.select("preset", "simulator").unique(maintain_order=True)
    shown: list[Group | list[Text]] = [_table(tables, *part) for part in parts.rows()]
    if CITYFLOW not in parts["simulator"]:
        text = (
            "CityFlow's module is not installed: all ran in the queue simulator, by the whole "
            "trip, and no published figure compares."
        )
        shown.append([Text(text, "yellow")])
    return shown


def as_json(tables: ProtocolsTables) -> dict[str, Any]:
    """Return the study as one JSON object."""
    names = ("ours", "published", "split", "agreement")
    return {name: getattr(tables, name).rows(named=True) for name in names}


def _table(tables: ProtocolsTables, protocol: str, simulator: str) -> Group:
    ours = tables.ours.filter((pl.col("preset") == protocol) & (pl.col("simulator") == simulator))
    cities = ours["scenario"].unique(maintain_order=True).to_list()
    found = rows_by(ours, "controller", "scenario")
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, padding=(0, 0, 0, 1))
    # Names wrap, numbers are shown whole.
    table.add_column("", overflow="fold", min_width=NAME_WIDTH)
    for city in cities:
        table.add_column(city, justify="right", no_wrap=True)
    for name in ours["controller"].unique(maintain_order=True):
        cells = [_cell(found.get((name, city))) for city in cities]
        table.add_row(controller_name(name), *cells)
    known = tables.published.filter(pl.col("preset") == protocol)
    if simulator == CITYFLOW and not known.is_empty():
        figures = rows_by(known, "method", "scenario")
        table.add_section()
        for method in known["method"].unique(maintain_order=True):
            rows = [figures.get((method, city)) for city in cities]
            texts = [f"{row['published_s']:.1f}" if row else "–" for row in rows]
            table.add_row(f"published {method}", *texts, style="dim")
    measure = ours["measure"][0]
    title = Text(
        f"{protocol} in {simulator_label(simulator)}: {METRICS[measure].label}, s", "italic"
    )
    note = "Recorded day; below it the mean of other days ± half of its 95 % interval."
    return Group(title, table, Text(note, "dim"))


def _cell(row: dict[str, Any] | None) -> str:
    if row is None:
        return "–"
    text = "" if row["recorded_s"] is None else f"{row['recorded_s']:.1f}"
    if row["mean_s"] is not None:
        text += ("\n" if text else "") + f"{row['mean_s']:.1f}"
        if row["low_s"] is not None:
            text += f" ±{(row['high_s'] - row['low_s']) / 2:.1f}"
    return text
