"""The study's tables for other programs and other papers: CSV and LaTeX."""

from __future__ import annotations

import polars as pl

from dmil.analysis.panel import ordered
from dmil.reports.files import csv
from dmil.reports.labels import controller_label
from dmil.studies.paper.cells import REWARD_ORDER
from dmil.studies.paper.published import PAPER_COLUMNS, scenario_label

_BASELINES = ("longest-queue-first", "max-pressure")


def evidence_csv(claims: pl.DataFrame) -> str:
    """Return the evidence of all claims, one comparison a row."""
    table = claims.select("preset", "id", "evidence").explode("evidence").drop_nulls("evidence")
    return csv(table.unnest("evidence"))


def paper_table_latex(table: pl.DataFrame, preset: str) -> str:
    r"""Return the paper's table beside ours as a LaTeX tabular (needs booktabs).

    Each entry is ours, mean \pm sd, with the paper's mean in brackets.
    """
    chosen = table.filter(pl.col("preset") == preset)
    entries = {
        (row["scenario"], row["reward"], row["column"]): row for row in chosen.iter_rows(named=True)
    }
    heads = [*PAPER_COLUMNS, *(controller_label(name) for name in _BASELINES)]
    lines = [
        f"% W/V_c, preset {preset}: mean \\pm sd over seeds [paper, Table II]",
        r"\begin{tabular}{ll" + "r" * len(heads) + "}",
        r"\toprule",
        " & ".join(["Grid", "Reward", *heads]) + r" \\",
    ]
    for scenario in chosen["scenario"].unique(maintain_order=True):
        lines.append(r"\midrule")
        rewards = chosen.filter(pl.col("scenario") == scenario)["reward"].drop_nulls()
        for reward in ordered(rewards.unique().to_list(), REWARD_ORDER):
            cells = [_entry(entries.get((scenario, reward, name))) for name in PAPER_COLUMNS]
            cells += [_entry(entries.get((scenario, None, name))) for name in _BASELINES]
            label = scenario_label(scenario).replace("×", r"$\times$").replace("_", r"\_")
            lines.append(" & ".join([label, reward, *cells]) + r" \\")
    return "\n".join([*lines, r"\bottomrule", r"\end{tabular}", ""])


def _entry(row: dict[str, object] | None) -> str:
    if row is None:
        return "--"
    text = "--" if row["mean"] is None else f"{row['mean']:.3f}"
    if row["sd"] is not None:
        text += f" $\\pm$ {row['sd']:.3f}"
    if row["paper_mean"] is not None:
        text += f" [{row['paper_mean']:.2f}]"
    return text
