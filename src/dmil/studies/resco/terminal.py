"""What the study on the RESCO benchmark says in a terminal: delays beside published numbers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import polars as pl
from rich import box
from rich.console import Group
from rich.table import Table
from rich.text import Text

from dmil.analysis.panel import rows_by
from dmil.studies.resco.contenders import JUDGES
from dmil.studies.resco.published import published_by, published_learners
from dmil.studies.resco.tables import RescoTables, published_table, resco_tables

_SHORT_NAMES = {
    "longest-queue-first": "longest queue",
    ",approaching=true": " +a",
    "dual-memory": "dual",
    "communication": "comm.",
}
_SHORT_NETWORKS = {"cologne": "col.", "ingolstadt": "ing.", "arterial": "art."}
_WIDTH = 80
_NAME_WIDTH = 20


tables_of = resco_tables


def in_terminal(tables: RescoTables) -> list[Group | list[Text]]:
    """Return the parts that are shown, lines of text as lists."""
    parts: list[Group | list[Text]] = [resco_table(tables)]
    if tables.locks["locked"].sum():
        parts.append(locks_table(tables))
    if tables.training.height:
        parts.append(training_lines(tables))
    return [*parts, agreement_lines(tables)]


def resco_table(tables: RescoTables) -> Group:
    """Return the average delay where controllers are judged: controllers down, networks across.

    Below a median stand half the width of the 95 % interval of the interquartile mean and, in
    brackets, what was published for the same kind of controller; an asterisk marks those not shown
    to be worse than the best.
    """
    runs = tables.judged
    seeds = f"{len(runs.seeds)} seeds" if len(runs.seeds) > 1 else "1 seed"
    title = Text(f"Average delay in s per vehicle, in {runs.judge}, {seeds}", "italic")
    caption = (
        "Median, ± half of the 95 % interval of the interquartile mean, [published].\n"
        "Lower is better."
    )
    if tables.headline["among_best"].any():
        caption += "\n* not shown to be worse than the best"
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, padding=0)
    table.add_column("", no_wrap=True)
    for name in _network_names(runs.scenarios):
        table.add_column(name, justify="right", no_wrap=True)
    entries = rows_by(tables.headline, "contender", "scenario")
    for name in runs.names:
        row = [_delay(entries.get((name, scenario))) for scenario in runs.scenarios]
        table.add_row(_short_name(name), *row)
    table.add_section()
    for method, values in published_learners(runs.scenarios):
        shown = ["–" if value is None else f"[{_short(value.best_s)}]" for value in values]
        table.add_row(f"published {method}", *shown, style="dim")
    return Group(title, table, Text(caption, "dim"))


def locks_table(tables: RescoTables) -> Group:
    """Return in how many runs junctions locked, protocol below protocol, where some did."""
    found = tables.locks
    some = found.group_by("scenario").agg(pl.col("locked").sum()).filter(pl.col("locked") > 0)
    scenarios = [name for name in tables.judged.scenarios if name in some["scenario"]]
    protocols = found["simulator"].unique(maintain_order=True).to_list()
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, padding=0)
    table.add_column("", no_wrap=True)
    for name in _network_names(scenarios):
        table.add_column(name, justify="right", no_wrap=True)
    entries = rows_by(found, "contender", "scenario", "simulator")
    for name in tables.judged.names:
        row = []
        for scenario in scenarios:
            each = (entries.get((name, scenario, protocol)) for protocol in protocols)
            row.append("\n".join(f"{one['locked']}/{one['n']}" if one else "–" for one in each))
        table.add_row(_short_name(name), *row)
    title = Text(f"Runs in which a junction locked, in {', below in '.join(protocols)}", "italic")
    return Group(title, table)


def training_lines(tables: RescoTables) -> list[Text]:
    """Return best episode and mean of the last ten of what was trained in SUMO, beside IDQN's."""
    lines = []
    for row in tables.training.filter(pl.col("trained_in").is_in(JUDGES)).iter_rows(named=True):
        theirs = published_by(row["scenario"]).get("IDQN")
        beside = "" if theirs is None else f" [IDQN {theirs.best_s:.1f}, {theirs.last_s:.1f}]"
        lines.append(
            Text(
                f"{_short_name(row['contender'])} trained in {row['trained_in']} on "
                f"{row['scenario'].rpartition('/')[2]}: best episode {row['best']:.1f} s, last ten "
                f"{row['last']:.1f} s{beside}"
            )
        )
    return lines


def agreement_lines(tables: RescoTables) -> list[Text]:
    """Return how far the queue simulator ranks controllers as SUMO does, a line each."""
    lines = []
    pooled = tables.agreement.filter(
        (pl.col("metric") == "delay_s") & pl.col("scenario").is_null() & pl.col("tau").is_not_null()
    )
    for row in pooled.iter_rows(named=True):
        ends = row["tau_low"], row["tau_high"]
        interval = "" if None in ends else f" [{ends[0]:.2f}, {ends[1]:.2f}]"
        line = Text(f"{row['simulator']} against {tables.judged.judge}: ")
        line.append(f"Kendall's τ {row['tau']:.2f}{interval}", style="bold")
        line.append(f", delays {100 * row['difference']:+.0f} %".replace("-", "−"))
        lines.append(line)
    return lines


def as_json(tables: RescoTables) -> dict[str, Any]:
    """Return a study on the RESCO benchmark as one JSON object."""
    runs = tables.judged
    return {
        "judge": runs.judge,
        "trained_in": runs.trained_in,
        "scenarios": list(runs.scenarios),
        "seeds": list(runs.seeds),
        "delay": tables.headline.drop("metric", "simulator").rows(named=True),
        "overall": tables.overall.rows(named=True),
        "locks": tables.locks.rows(named=True),
        "training": tables.training.rows(named=True),
        "agreement": tables.agreement.rows(named=True),
        "published": published_table().rows(named=True),
    }


def _network_names(scenarios: Sequence[str]) -> list[str]:
    """Return names of networks, in short where the width of a terminal asks for it."""
    names = [name.rpartition("/")[2] for name in scenarios]
    if _NAME_WIDTH + sum(1 + len(name) for name in names) <= _WIDTH:
        return names
    for long, short in _SHORT_NETWORKS.items():
        names = [name.replace(long, short) for name in names]
    return names


def _short_name(name: str) -> str:
    for long, short in _SHORT_NAMES.items():
        name = name.replace(long, short)
    return name


def _delay(row: dict[str, Any] | None) -> Text:
    if row is None:
        return Text("–")
    text = Text(_short(row["median"]) + ("*" if row["among_best"] else " "))
    if row["iqm_low"] is not None:
        text.append(f"\n±{_short((row['iqm_high'] - row['iqm_low']) / 2)} ", style="dim")
    if row["published_s"] is not None:
        text.append(f"\n[{_short(row['published_s'])}]", style="dim")
    return text


def _short(value: float) -> str:
    """Return a number of three or four digits: eight networks have to fit into a line."""
    return f"{value:.1f}" if value < 99.95 else f"{value:.0f}"
