"""The paper's table beside ours for other papers: LaTeX."""

from __future__ import annotations

from itertools import product

import polars as pl

from dmil.analysis.panel import ordered, rows_by
from dmil.reports.files import latex
from dmil.reports.labels import controller_label
from dmil.studies.paper.cells import REWARD_ORDER
from dmil.studies.paper.published import PAPER_COLUMNS, scenario_label

_BASELINES = ("longest-queue-first", "max-pressure")


def paper_table_latex(table: pl.DataFrame, preset: str) -> str:
    r"""Return the paper's table beside ours as a LaTeX tabular (needs booktabs).

    Each entry is ours, mean \pm sd, with the paper's mean in brackets.
    """
    chosen = table.filter(pl.col("preset") == preset)
    entries = rows_by(chosen, "scenario", "reward", "column")
    parts = []
    for scenario in chosen["scenario"].unique(maintain_order=True):
        label = scenario_label(scenario).replace("×", r"$\times$").replace("_", r"\_")
        rewards = chosen.filter(pl.col("scenario") == scenario)["reward"].drop_nulls()
        found = []
        for reward in ordered(rewards.unique().to_list(), REWARD_ORDER):
            places = [*product([reward], PAPER_COLUMNS), *product([None], _BASELINES)]
            found.append([label, reward, *(_entry(entries.get((scenario, *p))) for p in places)])
        parts.append(found)
    notes = [f"W/V_c, preset {preset}: mean \\pm sd over seeds [paper, Table II]"]
    heads = ["Grid", "Reward", *PAPER_COLUMNS, *map(controller_label, _BASELINES)]
    return latex(notes, heads, *parts, left=2)


def _entry(row: dict[str, object] | None) -> str:
    if row is None:
        return "--"
    text = "--" if row["mean"] is None else f"{row['mean']:.3f}"
    if row["sd"] is not None:
        text += f" $\\pm$ {row['sd']:.3f}"
    if row["paper_mean"] is not None:
        text += f" [{row['paper_mean']:.2f}]"
    return text
