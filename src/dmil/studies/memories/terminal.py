"""What the study of memories says in a terminal: standing, cells, verdicts."""

from __future__ import annotations

from typing import Any

import polars as pl
from rich import box
from rich.console import Group
from rich.table import Table
from rich.text import Text

from dmil.reports.contenders import controller_name
from dmil.reports.labels import counted
from dmil.studies.memories.names import REFERENCES, cell_label, ranked
from dmil.studies.memories.statements import SUBJECTS
from dmil.studies.memories.tables import MemoriesTables, memories_tables

MOST_SUBJECTS = 4
_COSTS = ("bytes_per_intersection", "us_per_decision", "decisions_until_better")
_COLOURS = {True: "green", False: "red", None: "dim"}
_HEADS = {
    "max_pressure": "max-pressure",
    "longest_queue": "longest queue",
    "approaching": "l. q. + appr.",
    "limit": "planner",
}


tables_of = memories_tables


def in_terminal(tables: MemoriesTables) -> list[Group | list[Text]]:
    """Return the parts that are shown, lines of text as lists."""
    by_cell = [cells_table(tables, subject) for subject in subjects(tables)]
    return [standing_table(tables), *by_cell, claim_lines(tables)]


def as_json(tables: MemoriesTables) -> dict[str, Any]:
    """Return a study of memories as one JSON object (ours)."""
    shown = ("overall", "standing", "cost", "hit_rates", "claims", "failures")
    return {
        "cells": list(tables.runs.cells),
        "seeds": list(tables.runs.seeds),
        **{name: getattr(tables, name).rows(named=True) for name in shown},
    }


def standing_table(tables: MemoriesTables) -> Group:
    """Return how all controllers stand over all cells, the best first."""
    runs = tables.runs
    where = f"{counted(len(runs.cells), 'case')}, {counted(len(runs.seeds), 'seed')}"
    title = Text(f"W over max-pressure's on the same vehicles, {where}", "italic")
    caption = (
        "Interquartile mean ± half of its 95 % interval; share of runs in which it is\n"
        "lower; bytes per intersection, µs per decision (all intersections) and decisions\n"
        "to outperform max-pressure, each in the case with most."
    )
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, padding=0)
    table.add_column("", no_wrap=True, width=27, overflow="ellipsis")
    for head in ("W ratio", "better", "bytes", "µs", "until", "failed"):
        table.add_column(head, justify="right", no_wrap=True)
    costs = {key[0]: rows for key, rows in tables.cost.group_by("controller")}
    table_rows = tables.overall.sort("max_pressure_ratio", nulls_last=True, maintain_order=True)
    for row in table_rows.iter_rows(named=True):
        if row["controller"] not in costs:
            continue
        table.add_row(
            controller_name(row["controller"]),
            _ratio(row),
            _share(row["max_pressure_better"]),
            *_costs(costs[row["controller"]]),
        )
    return Group(title, table, Text(caption, "dim"))


def subjects(tables: MemoriesTables) -> list[str]:
    """Return the controllers that get a table by cells: the best, references aside (ours)."""
    others = ~pl.col("controller").is_in([*REFERENCES, "random"])
    names: list[str] = ranked(tables.overall).filter(others)["controller"].to_list()
    chosen = [name for name in names if name in SUBJECTS]
    few = len(names) <= MOST_SUBJECTS
    return names if few else chosen or names[:1]


def cells_table(tables: MemoriesTables, controller: str) -> Group:
    """Return W of one controller in every cell, and its differences to the references."""
    title = f"{controller_name(controller)}: W in s, paired differences from others in %"
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, padding=0)
    table.add_column("", no_wrap=True)
    for head in ("W", *_HEADS.values()):
        table.add_column(head, justify="right", no_wrap=True)
    rows = tables.standing.filter(pl.col("controller") == controller)
    for row in rows.iter_rows(named=True):
        mean = "–" if row["mean"] is None else f"{row['mean']:.2f}"
        table.add_row(cell_label(row["cell"]), mean, *(_difference(row, each) for each in _HEADS))
    return Group(Text(title, "italic"), table)


def claim_lines(tables: MemoriesTables) -> list[Text]:
    """Return one line per bar and claim that was run: verdict, then the claim."""
    run = tables.claims.filter(pl.col("verdict") != "not run")
    return [
        Text.assemble((row["verdict"], _COLOURS[row["holds"]]), f"  {row['sentence']}")
        for row in run.iter_rows(named=True)
    ]


def _ratio(row: dict[str, Any]) -> str:
    if row["max_pressure_ratio"] is None:
        return "–"
    ends = row["max_pressure_low"], row["max_pressure_high"]
    interval = "" if None in ends else f" ±{(ends[1] - ends[0]) / 2:.3f}".replace("0.", ".")
    return f"{row['max_pressure_ratio']:.3f}{interval}"


def _share(value: float | None) -> str:
    return "" if value is None else f"{100 * value:.0f} %"


def _costs(rows: pl.DataFrame) -> list[str]:
    """Return bytes, µs, decisions until better and failures over all cells of a controller."""
    known = {name: rows[name].drop_nulls().to_list() for name in _COSTS}
    largest, slowest = (max(known[name], default=None) for name in _COSTS[:2])
    until = known["decisions_until_better"]
    overtook = ""
    if rows["learns"].any():
        overtook = f"{len(until)}/{rows.height} cells" if until else "never"
        overtook = f"{max(until):,.0f}" if len(until) == rows.height else overtook
    failed, planned = int(rows["failed"].sum()), int(rows["planned"].sum())
    return [
        f"{largest:,.0f}" if largest else "",
        "" if slowest is None else f"{slowest:,.0f}",
        overtook,
        f"{failed}/{planned}" if failed else "",
    ]


def _difference(row: dict[str, Any], short: str) -> Text:
    value, low, high = (row[f"{short}_{end}"] for end in ("pct", "low", "high"))
    if value is None:
        return Text("–")
    text = Text(f"{value:+.1f}".replace("-", "−"))
    if low is not None:
        text.append(f" ±{(high - low) / 2:.1f}", style="dim")
        text.stylize(_COLOURS[True if high < 0 else False if low > 0 else None], 0, 6)
    return text
