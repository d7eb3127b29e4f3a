"""What the paper's study says in a terminal: the headline table, and verdicts."""

from __future__ import annotations

from typing import Any

import polars as pl
from rich import box
from rich.table import Table
from rich.text import Text

from dmil.analysis.panel import rows_by
from dmil.studies.paper.cells import BASELINES
from dmil.studies.paper.published import PAPER_COLUMNS, scenario_label
from dmil.studies.paper.tables import PaperTables, paper_tables

_SHORT = {"Complex + communication": "Complex+comm."}
_COLOURS = {"holds": "green", "does not hold": "red", "depends": "yellow"}
CELL_COLUMNS = (
    "preset",
    "reward",
    "controller",
    "embedding",
    "communication",
    "epsilon",
    "n",
    "w_over_vc_mean",
    "w_over_vc_sd",
    "vc_mean",
    "entries_mean",
)


tables_of = paper_tables


def in_terminal(tables: PaperTables) -> list[Table | list[Text]]:
    """Return the parts that are shown, lines of text as lists."""
    preset = tables.cells.presets[-1]
    return [headline_table(tables, preset), claim_lines(tables.claims, preset)]


def as_json(tables: PaperTables) -> dict[str, Any]:
    """Return cells and claims."""
    cells = [
        {"grid": row["scenario"].removeprefix("grid:")} | {name: row[name] for name in CELL_COLUMNS}
        for row in tables.summary.iter_rows(named=True)
    ]
    return {"cells": cells, "claims": _claim_rows(tables.claims)}


def headline_table(tables: PaperTables, preset: str) -> Table:
    """Return W/V_c of the largest grid: rewards by columns of the paper, and the baselines."""
    cells = tables.cells
    scenario = cells.scenarios[-1]
    rows = tables.paper.filter((pl.col("preset") == preset) & (pl.col("scenario") == scenario))
    entries = rows_by(rows, "reward", "column")
    seeds = f"{len(cells.seeds)} seeds" if len(cells.seeds) > 1 else "1 seed"
    table = Table(
        title=f"W/V_c in s per vehicle, {scenario_label(scenario)}, preset {preset}, {seeds}",
        caption=Text("mean ± sd over seeds, below it [the paper's mean]; lower is better", "dim"),
        box=box.SIMPLE_HEAD,
        title_justify="left",
        caption_justify="left",
        show_edge=False,
        padding=0,
    )
    table.add_column("", no_wrap=True)
    for column in PAPER_COLUMNS:
        table.add_column(_SHORT.get(column, column), justify="right")
    for reward in dict.fromkeys(reward for reward, _ in entries if reward):
        found = [entries.get((reward, column)) for column in PAPER_COLUMNS]
        table.add_row(reward, *(_entry(row) for row in found))
    table.add_section()
    for name in BASELINES:
        row = entries.get((None, name))
        if row is not None:
            table.add_row(name, _entry(row))
    return table


def _entry(row: dict[str, Any] | None) -> Text:
    if row is None:
        return Text("–")
    ours = "–" if row["mean"] is None else f"{row['mean']:.3f}"
    if row["sd"] is not None:
        ours += f" ± {row['sd']:.3f}"
    return Text(ours if row["paper_mean"] is None else f"{ours}\n[{row['paper_mean']:.2f}]")


def claim_lines(judged: pl.DataFrame, preset: str) -> list[Text]:
    """Return one line per claim: how it ends, the claim, the verdict where it says more."""
    rows = judged.filter(pl.col("preset") == preset)
    width = max((len(outcome) for outcome in rows["outcome"]), default=0)
    lines = [Text(f"Claims, preset {preset}", style="bold")]
    for row in rows.iter_rows(named=True):
        line = Text()
        line.append(f"{row['outcome']:{width}}", style=_COLOURS.get(row["outcome"], "dim"))
        ours = " (ours)" if row["source"] == "ours" else ""
        place = f"{row['place']}, " if row["source"] == "table" else ""
        line.append(f"  {place}{row['sentence']}{ours}")
        if row["verdict"] != row["outcome"]:
            line.append(f" [{row['verdict']}]", style="dim")
        lines.append(line)
    return lines


def _claim_rows(judged: Any) -> list[dict[str, Any]]:
    return [
        {
            "id": row["id"],
            "preset": row["preset"],
            "claim": row["sentence"],
            "source": row["source"],
            "holds": row["holds"],
            "outcome": row["outcome"],
            "evidence": {
                "verdict": row["verdict"],
                "rule": row["rule"],
                "summary": row["summary"],
                "comparisons": row["evidence"],
            },
        }
        for row in judged.iter_rows(named=True)
    ]
