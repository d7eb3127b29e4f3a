"""What an ablation says in a terminal: what every part changes, and which runs locked."""

from __future__ import annotations

from typing import Any

from rich import box
from rich.console import Group
from rich.table import Table
from rich.text import Text

from dmil.analysis.panel import rows_by
from dmil.reports.labels import counted, short_label, signed
from dmil.studies.ablation.names import cell_label
from dmil.studies.ablation.tables import AblationTables, ablation_tables

MOST_LOCKS = 10


tables_of = ablation_tables


def in_terminal(tables: AblationTables) -> list[Group | list[Text]]:
    """Return the parts that are shown, lines of text as lists."""
    runs = tables.runs
    return [*(cell_table(tables, cell) for cell in runs.cells), lock_lines(tables)]


def as_json(tables: AblationTables) -> dict[str, Any]:
    """Return an ablation as one JSON object (ours)."""
    shown = ("delays", "differences", "locks", "failures")
    return {
        "cells": list(tables.runs.cells),
        "seeds": list(tables.runs.seeds),
        **{name: getattr(tables, name).rows(named=True) for name in shown},
    }


def cell_table(tables: AblationTables, cell: str) -> Group:
    """Return what every part changes in one case: parts down, controllers across."""
    runs = tables.runs
    title = f"{cell_label(cell)}: delay in s, {counted(len(runs.seeds), 'seed')}"
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, padding=0)
    table.add_column("", no_wrap=True)
    for name in runs.controllers:
        table.add_column(short_label(name), justify="right", no_wrap=True)
    usual = rows_by(tables.delays, "cell", "controller")
    table.add_row("as it is", *(_delay(usual[cell, name]) for name in runs.controllers))
    changed = rows_by(tables.differences, "cell", "controller", "change")
    for change in runs.changes:
        rows = [changed.get((cell, name, change)) for name in runs.controllers]
        table.add_row(change, *(_difference(row) for row in rows))
    return Group(Text(title, "italic"), table)


def lock_lines(tables: AblationTables) -> list[Text]:
    """Return one line for each run that locked, the first of many."""
    lines = [
        Text(
            f"locked: {row['controller']}, {row['scenario']}, seed {row['seed']}, "
            f"from {row['locked_from_s']} s"
        )
        for row in tables.locks.head(MOST_LOCKS).iter_rows(named=True)
    ]
    left = tables.locks.height - len(lines)
    return [*lines, Text(f"and {left} more locked runs", "dim")] if left else lines


def _delay(row: dict[str, Any]) -> str:
    shown = "–" if row["delay_s"] is None else f"{row['delay_s']:.2f}"
    return shown + (f" [{row['locked']}]" if row["locked"] else "")


def _difference(row: dict[str, Any] | None) -> Text:
    if row is None or row["delay_s"] is None:
        return Text("–" if row else "")
    if row["alike"] == 1.0:
        return Text("0", "dim")
    text = Text(signed(row["delay_s"], 2))
    if row["low"] is not None:
        colour = "green" if row["high"] < 0 else "red" if row["low"] > 0 else "dim"
        text.stylize(colour)
        text.append(f" ±{(row['high'] - row['low']) / 2:.2f}", "dim")
    if row["locked"]:
        text.append(f" [{row['locked']}]")
    return text
