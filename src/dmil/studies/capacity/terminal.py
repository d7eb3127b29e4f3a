"""What the study of capacity says in a terminal: capacities, then disturbances."""

from __future__ import annotations

from typing import Any

from rich import box
from rich.console import Group
from rich.table import Table
from rich.text import Text

from dmil.analysis.panel import rows_by
from dmil.reports.contenders import controller_name
from dmil.reports.labels import counted
from dmil.studies.capacity.disturbed import INCIDENT, SURGE
from dmil.studies.capacity.names import DISTURBANCE_LABELS, place_label
from dmil.studies.capacity.recoveries import UNDISTURBED
from dmil.studies.capacity.tables import CapacityTables, capacity_tables

_NAME_WIDTH = 18
_HEADS = {UNDISTURBED: "none", **DISTURBANCE_LABELS}
_SHORT = {
    "lane closed": "lane",
    "dead detectors": "dead",
    "failing detectors": "failing",
    "noisy counts": "noise",
}

tables_of = capacity_tables


def in_terminal(tables: CapacityTables) -> list[Group | list[Text]]:
    """Return the parts that are shown, lines of text as lists."""
    parts: list[Group | list[Text]] = [capacity_table(tables)]
    return parts + [
        disturbance_table(tables, place)
        for place in tables.networks
        if (tables.disturbances["scenario"] == place).any()
    ]


def as_json(tables: CapacityTables) -> dict[str, Any]:
    """Return a study of capacity as one JSON object (ours)."""
    shown = ("capacities", "curves", "disturbances", "failures")
    return {
        "networks": list(tables.networks),
        "controllers": list(tables.controllers),
        "seeds": list(tables.seeds),
        **{name: getattr(tables, name).rows(named=True) for name in shown},
    }


def capacity_table(tables: CapacityTables) -> Group:
    """Return the capacity of every controller on every network."""
    title = Text(
        f"Highest stable load, times the demand, {counted(len(tables.seeds), 'seed')}", "italic"
    )
    caption = "Mean ± half of its 95 % interval. *: not shown to hold less than the best."
    if (tables.capacities["unbounded"] > 0).any():
        caption += "\n≥: in some seeds the highest load that was tried was stable."
    entries = rows_by(tables.capacities, "scenario", "controller")
    table = _table([place_label(place) for place in tables.networks])
    for name in tables.controllers:
        row = [_capacity(entries.get((place, name))) for place in tables.networks]
        table.add_row(controller_name(name), *row)
    return Group(title, table, Text(caption, "dim"))


def disturbance_table(tables: CapacityTables, place: str) -> Group:
    """Return the delay of every controller under every disturbance of one network."""
    own = tables.disturbances.filter(scenario=place)
    entries = rows_by(own, "controller", "disturbance")
    load = own["load"][0]
    title = Text(f"Delay in s on {place_label(place)} at load {load:g}, disturbed", "italic")
    caption = "Below: time to recover in s; >: some runs do not recover before their end."
    table = _table([_SHORT.get(label, label) for label in _HEADS.values()])
    for name in tables.controllers:
        if (name, UNDISTURBED) in entries:
            row = [_disturbed(entries.get((name, each)), each) for each in _HEADS]
            table.add_row(controller_name(name), *row)
    return Group(title, table, Text(caption, "dim"))


def _table(heads: list[str]) -> Table:
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, padding=0)
    table.add_column("", width=_NAME_WIDTH, overflow="fold")
    for head in heads:
        table.add_column(head, justify="right", no_wrap=True)
    return table


def _capacity(row: dict[str, Any] | None) -> Text:
    if row is None or row["capacity"] is None:
        return Text("–")
    text = Text("≥" if row["unbounded"] else "")
    text.append(f"{row['capacity']:.2f}" + ("*" if row["among_best"] else " "))
    if row["low"] is not None:
        text.append(f"\n±{(row['high'] - row['low']) / 2:.2f} ", style="dim")
    return text


def _disturbed(row: dict[str, Any] | None, disturbance: str) -> Text:
    if row is None:
        return Text("–")
    text = Text(f"{row['delay_s']:.1f}")
    if disturbance in (INCIDENT, SURGE) and row["recovery_s"] is not None:
        over = ">" if row["lasting"] else ""
        text.append(f"\n{over}{row['recovery_s']:.0f} s", style="dim")
    return text
