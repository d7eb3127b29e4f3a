"""Tables of the study of memories for READMEs and papers: Markdown and LaTeX."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import polars as pl

from dmil.analysis.claims import difference_text
from dmil.analysis.panel import rows_by
from dmil.reports.files import latex
from dmil.studies.memories.names import REFERENCES, cell_label, controller_name
from dmil.studies.memories.statements import SUBJECT
from dmil.studies.memories.tables import MemoriesTables

_REFERENCE_HEADS = {
    "max_pressure": "against max-pressure",
    "longest_queue": "against longest queue",
    "approaching": "against longest queue + approaching",
    "limit": "against the planner",
}


def standing_markdown(tables: MemoriesTables) -> str:
    """Return W of the references and of the first subject in every cell, as Markdown."""
    head, *rows = ("| " + " | ".join(row) + " |" for row in _headline(tables))
    rule = "|-|" + "-:|" * (head.count(" | "))
    return "\n".join([head, rule, *rows, ""])


def standing_latex(tables: MemoriesTables) -> str:
    r"""Return W of the references and of the first subject in every cell, as a LaTeX tabular."""
    head, *rows = ([_safe(cell) for cell in row] for row in _headline(tables))
    notes = ["W in s: mean over seeds; paired differences in %, 95 % interval"]
    return latex(notes, head, rows)


def _headline(tables: MemoriesTables) -> list[list[str]]:
    """Return heads and rows: the subject is factored memory, or the best there is."""
    runs = tables.runs
    known = tables.overall.filter(
        ~pl.col("controller").is_in(list(REFERENCES)), pl.col("max_pressure_ratio").is_not_null()
    ).sort("max_pressure_ratio", maintain_order=True)
    names = known["controller"].to_list()
    subject = SUBJECT if SUBJECT in names else names[0] if names else None
    references = [name for name in REFERENCES if name in runs.controllers]
    entries = rows_by(tables.standing, "cell", "controller")
    shown = [*references, *([subject] if subject else [])]
    head = ["W in s", *(controller_name(name) for name in shown)]
    if subject:
        head += [_REFERENCE_HEADS[REFERENCES[name]] for name in references]
    rows = [head]
    for cell in runs.cells:
        row = [cell_label(cell), *(_mean(entries.get((cell, name))) for name in shown)]
        if subject:
            own = entries.get((cell, subject))
            row += [_difference(own, REFERENCES[name]) for name in references]
        rows.append(row)
    return rows


def _mean(row: Mapping[str, Any] | None) -> str:
    return "–" if row is None or row["mean"] is None else f"{row['mean']:.2f}"


def _difference(row: Mapping[str, Any] | None, short: str) -> str:
    if row is None or row[f"{short}_pct"] is None:
        return "–"
    return difference_text(*(row[f"{short}_{end}"] for end in ("pct", "low", "high")))


def _safe(text: str) -> str:
    text = text.replace("%", r"\%").replace("_", r"\_").replace("×", r"$\times$")
    return text.replace("−", "$-$").replace("–", "--").replace("ε", r"$\varepsilon$")
