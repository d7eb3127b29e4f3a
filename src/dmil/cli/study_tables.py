"""What a study says in a terminal: the paper's table beside ours, and a line for each claim."""

from __future__ import annotations

from typing import Any

import polars as pl
from rich import box
from rich.table import Table
from rich.text import Text

from dmil.analysis import Tables
from dmil.analysis.cells import BASELINES
from dmil.analysis.paper import PAPER_COLUMNS, scenario_label

_SHORT = {"Complex + communication": "Complex+comm."}
_COLOURS = {True: "green", False: "red", None: "dim"}


def headline_table(tables: Tables, preset: str) -> Table:
    """Return W/V_c of the largest grid: rewards by columns of the paper, and the baselines.

    Parameters
    ----------
    tables
        The study.
    preset
        Preset to show.
    """
    cells = tables.cells
    scenario = cells.scenarios[-1]
    rows = tables.paper.filter((pl.col("preset") == preset) & (pl.col("scenario") == scenario))
    entries = {(row["reward"], row["column"]): row for row in rows.iter_rows(named=True)}
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
    """Return one line per claim: verdict, then the claim.

    Parameters
    ----------
    judged
        Claims with verdicts.
    preset
        Preset to show.
    """
    rows = judged.filter(pl.col("preset") == preset)
    width = max((len(verdict) for verdict in rows["verdict"]), default=0)
    lines = [Text(f"Claims, preset {preset}", style="bold")]
    for row in rows.iter_rows(named=True):
        line = Text()
        line.append(f"{row['verdict']:{width}}", style=_COLOURS[row["holds"]])
        ours = " (ours)" if row["source"] == "ours" else ""
        line.append(f"  {row['sentence']}{ours}")
        lines.append(line)
    return lines
