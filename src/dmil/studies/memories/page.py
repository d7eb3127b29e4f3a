"""The report of the study of memories: its figures, one page, its tables as files."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import polars as pl

from dmil.analysis.claims import FEWEST_SEEDS, difference_text
from dmil.analysis.panel import rows_by
from dmil.experiments.cells import CITY
from dmil.reports.contenders import controller_name
from dmil.reports.export import Figure, csv, evidence_csv, latex
from dmil.reports.html import check_preset, configuration_rows, environment, shared_values
from dmil.results import Results
from dmil.studies.memories.figures import DARK, figures_of_study
from dmil.studies.memories.names import REFERENCES, cell_label, ranked
from dmil.studies.memories.statements import SUBJECT, SUBJECTS
from dmil.studies.memories.tables import MemoriesTables, memories_tables

PRESET = "memories"
CSV = "standing", "overall", "cost", "hit_rates", "learning", "ablation", "claims", "failures"
SECTIONS = {
    "bars": "The bars",
    "limits": "The limit",
    "rivals": "Claims on the other memories",
}
_REFERENCE_HEADS = {
    "max_pressure": "against max-pressure",
    "longest_queue": "against longest queue",
    "approaching": "against longest queue + approaching",
    "limit": "against the planner",
}


class MemoriesReport:
    """What the report of the study of memories is made of: a `dmil.studies.registry.Report`."""

    def __init__(
        self, results: Results, tables: MemoriesTables | None = None, preset: str | None = None
    ) -> None:
        check_preset(preset, PRESET)
        self._results = results
        self._tables = tables or memories_tables(results)

    def tables(self) -> dict[str, str | bytes]:
        """Return the tables' files by name."""
        made = self._tables
        return {
            **{f"tables/{name}.csv": csv(getattr(made, name)) for name in CSV},
            "tables/standing.md": standing_markdown(made),
            "tables/standing.tex": standing_latex(made),
            "tables/claims_evidence.csv": evidence_csv(made.claims),
        }

    def figures(self) -> Iterator[Figure]:
        """Yield the figures as they are made."""
        yield from figures_of_study(self._tables)

    def pages(self, figures: list[Figure]) -> dict[str, str]:
        """Return the page by its name."""
        templates = environment(__package__)
        templates.filters |= {
            "cell": cell_label,
            "controller": controller_name,
            "percent": lambda value: None if value is None else 100 * value,
        }
        shown = [figure for figure in figures if figure.section != DARK]
        values = shared_values(self._results, shown) | self._values()
        return {"report.html": templates.get_template("page.html.j2").render(values)}

    def _values(self) -> dict[str, Any]:
        made, runs = self._tables, self._tables.runs
        configuration = self._results.manifest.get("configuration", {})
        kept = [name for name in runs.controllers if name not in runs.ablations]
        overall = made.overall.filter(pl.col("controller").is_in(kept)).sort(
            "max_pressure_ratio", nulls_last=True, maintain_order=True
        )
        rates = made.hit_rates.group_by("controller", "source", maintain_order=True).agg(
            pl.col("share").mean()
        )
        return {
            "cells": runs.cells,
            "seeds": runs.seeds,
            "few_seeds": FEWEST_SEEDS,
            "controllers": overall["controller"].to_list(),
            "ablations": runs.ablations,
            "overall": overall.rows(named=True),
            "standing": rows_by(made.standing, "cell", "controller"),
            "cost": rows_by(made.cost, "cell", "controller"),
            "costs": _costs(made.cost),
            "ablation": rows_by(made.ablation, "controller", "cell"),
            "rates": rates.rows(named=True),
            "references": REFERENCES,
            "subject": SUBJECT,
            "subjects": [name for name in SUBJECTS if name in runs.controllers],
            "sections": SECTIONS,
            "claims": made.claims.rows(named=True),
            "failures": made.failures.rows(named=True),
            "has_cities": any(cell.startswith(CITY) for cell in runs.cells),
            "tuned": configuration.get("tuned", {}),
            "tuning": configuration.get("tuning", []),
            "episodes": configuration.get("episodes"),
            "configuration": configuration_rows(configuration),
        }


def _costs(cost: pl.DataFrame) -> dict[str, dict[str, Any]]:
    """Return what each controller costs in the cell where it costs most."""
    table = cost.group_by("controller", maintain_order=True).agg(
        pl.col("learns").any(),
        pl.col("entries_per_agent").max(),
        pl.col("bytes_per_intersection").max(),
        pl.col("us_per_decision").max(),
        until=pl.col("decisions_until_better").max(),
        overtaken=pl.col("decisions_until_better").count(),
        cells=pl.len(),
        planned=pl.col("planned").sum(),
        failed=pl.col("failed").sum(),
        diverged=pl.col("diverged").sum(),
    )
    return {row["controller"]: row for row in table.iter_rows(named=True)}


REPORT = MemoriesReport
"""What makes the report of such a study."""


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
    others = ~pl.col("controller").is_in(list(REFERENCES))
    names = ranked(tables.overall).filter(others)["controller"].to_list()
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
