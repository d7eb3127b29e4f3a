"""The report of the paper's study: its figures, its tables, also as LaTeX, one page."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from itertools import product
from typing import Any

import markupsafe
import polars as pl

from dmil.analysis.claims import FEWEST_SEEDS
from dmil.analysis.panel import ordered, rows_by
from dmil.controllers.tabular.settings import DualMemorySettings
from dmil.errors import unknown_name
from dmil.reports.export import Figure, csv, evidence_csv, latex
from dmil.reports.html import configuration_rows, environment, shared_values
from dmil.reports.labels import architecture_label, controller_label, signed
from dmil.results import Results
from dmil.studies.paper.assumptions import assumptions, changed
from dmil.studies.paper.cells import BASELINES, PRESET_ORDER, REWARD_ORDER, Cells
from dmil.studies.paper.figures import gallery
from dmil.studies.paper.published import NO_MEMORY, PAPER_COLUMNS, SOURCE, scenario_label
from dmil.studies.paper.tables import PaperTables, paper_tables
from dmil.theory import STATEMENTS

#: How claims end, each with how the headline says it.
_OUTCOMES = {
    "holds": "hold",
    "does not hold": "do not hold",
    "depends": "depend on the reward, or on how they are read or counted",
    "not shown": "are not shown by these runs",
    "not judged": "cannot be judged from them",
}

#: Names of CSV files, and which table each holds.
_CSV = {name: name for name in ("summary", "sensitivity", "memory", "exchange", "claims")} | {
    "paper_table": "paper",
    "complex_readings": "readings",
    "cells_reproduced": "reproduced",
}

#: Fewer seeds than this and the intervals are too narrow to rely on.
FEW_SEEDS = 8
_BASELINES = ("longest-queue-first", "max-pressure")


class PaperReport:
    """What the report of the paper's study is made of.

    See `dmil.studies.registry.Report`; its main preset is the last of literal, decaying, matched
    that was run.
    """

    def __init__(
        self, results: Results, tables: PaperTables | None = None, preset: str | None = None
    ) -> None:
        self._results = results
        self._tables = tables or paper_tables(results)
        self._preset = preset or _main_preset(self._tables.cells)
        if self._preset not in self._tables.cells.presets:
            raise unknown_name("preset in this study", self._preset, self._tables.cells.presets)

    def tables(self) -> dict[str, str | bytes]:
        """Return the tables' files by name."""
        tables = self._tables
        files: dict[str, str | bytes] = {
            f"tables/{name}.csv": csv(getattr(tables, attribute))
            for name, attribute in _CSV.items()
        }
        files["tables/claims_evidence.csv"] = evidence_csv(tables.claims)
        for preset in tables.cells.presets:
            files[f"tables/paper_table_{preset}.tex"] = paper_table_latex(tables.paper, preset)
        return files

    def figures(self) -> Iterator[Figure]:
        """Yield the figures as they are made."""
        return gallery(self._results, self._tables, self._preset)

    def pages(self, figures: list[Figure]) -> dict[str, str]:
        """Return the pages by name."""
        return {"report.html": _page(self._results, self._tables, figures, self._preset)}


def _main_preset(cells: Cells) -> str:
    known = [name for name in PRESET_ORDER if name in cells.presets]
    return known[-1] if known else cells.presets[0]


def _page(results: Results, tables: PaperTables, figures: list[Figure], preset: str) -> str:
    cells, shown = tables.cells, tables.summary.filter(pl.col("preset") == preset)
    templates = environment(__package__)
    templates.filters |= {"scenario": scenario_label, "maths": _maths}
    configuration = results.manifest.get("configuration", {})
    return templates.get_template("page.html.j2").render(
        **shared_values(results, figures),
        preset=preset,
        presets=cells.presets,
        scenarios=cells.scenarios,
        seeds=cells.seeds,
        few_seeds=FEW_SEEDS,
        fewest_seeds=FEWEST_SEEDS,
        changed=changed(configuration),
        paper_source=SOURCE,
        paper_columns=PAPER_COLUMNS,
        baselines=[name for name in BASELINES if name in tables.summary["controller"]],
        paper_tables={name: _paper_rows(tables.paper, name) for name in cells.presets},
        best=_best(shown),
        claims=_claim_rows(tables.claims, preset),
        outcomes=_OUTCOMES,
        counts_of=_counts(tables.claims),
        no_memory={
            name: cells.reading.architecture(NO_MEMORY, name).embedding for name in cells.presets
        },
        rule=DualMemorySettings().model_dump() | (configuration.get("dual_memory") or {}),
        exchange=tables.exchange.rows(named=True),
        memory=tables.memory.filter(pl.col("preset") == preset).rows(named=True),
        reproduced=tables.reproduced.rows(named=True),
        reading=cells.reading.complex_embedding,
        reading_names=tables.readings["reading"].unique(maintain_order=True).to_list(),
        readings=_grouped(
            tables.readings,
            ("preset", "scenario", "reward", "column"),
            "reading",
            ("paper_mean", "paper_spread"),
        )
        if tables.readings["reading"].n_unique() > 1
        else [],
        statements=STATEMENTS,
        sensitivity=_grouped(tables.sensitivity, ("scenario", "reward", "column"), "preset")
        if len(cells.presets) > 1
        else [],
        architectures=_with_label(shown.iter_rows(named=True)),
        assumptions=assumptions(configuration),
        configuration=configuration_rows(configuration),
    )


def _maths(text: str) -> markupsafe.Markup:
    """Set the paper's symbols with subscripts."""
    escaped = str(markupsafe.escape(text))
    return markupsafe.Markup(re.sub(r"\b([Vm])_([cLsQ])\b", r"\1<sub>\2</sub>", escaped))


def _paper_rows(table: pl.DataFrame, preset: str) -> list[dict[str, Any]]:
    """One row per grid and reward, with the entry of every column; baselines once per grid."""
    rows: list[dict[str, Any]] = []
    chosen = table.filter(pl.col("preset") == preset)
    for scenario in chosen["scenario"].unique(maintain_order=True):
        by_reward: dict[str | None, dict[str, Any]] = {None: {}}
        for row in chosen.filter(pl.col("scenario") == scenario).iter_rows(named=True):
            by_reward.setdefault(row["reward"], {})[row["column"]] = row
        baselines = by_reward.pop(None)
        first: dict[str, Any] | None = {"span": len(by_reward), "baselines": baselines}
        for reward, entries in by_reward.items():
            rows.append(
                {"scenario": scenario, "reward": reward, "entries": entries, "first": first}
            )
            first = None
    return rows


def _best(table: pl.DataFrame) -> list[dict[str, Any]]:
    """Find the learning agent that waits least on each grid, beside the baselines."""
    learned = table.filter(pl.col("reward").is_not_null())
    grids = learned.group_by("scenario", maintain_order=True)
    return _with_label(grid.sort("w_over_vc_mean").row(0, named=True) for _, grid in grids)


def _claim_rows(table: pl.DataFrame, preset: str) -> list[dict[str, Any]]:
    """Claims of the shown preset, each with its verdict under every preset."""
    verdicts: dict[str, dict[str, dict[str, Any]]] = {}
    for row in table.iter_rows(named=True):
        verdicts.setdefault(row["id"], {})[row["preset"]] = row
    return [
        {**by[preset], "evidence_range": _range(by[preset]["evidence"]), "by_preset": by}
        for by in verdicts.values()
    ]


def _counts(table: pl.DataFrame) -> dict[str, dict[str, int]]:
    """Count how the paper's claims end, under each preset."""
    counts = {preset: dict.fromkeys(_OUTCOMES, 0) for preset in table["preset"].unique()}
    for row in table.filter(pl.col("source") != "ours").iter_rows(named=True):
        counts[row["preset"]][row["outcome"]] += 1
    return counts


def _grouped(
    table: pl.DataFrame, keys: Sequence[str], by: str, also: Sequence[str] = ()
) -> list[dict[str, Any]]:
    """One row for each value of the keys, with all of its rows by another column."""
    rows: dict[tuple[Any, ...], dict[str, Any]] = {}
    for row in table.iter_rows(named=True):
        key = tuple(row[name] for name in keys)
        found = rows.setdefault(
            key, {"key": key, f"{by}s": {}} | {name: row[name] for name in also}
        )
        found[f"{by}s"][row[by]] = row
    return list(rows.values())


def _range(evidence: list[dict[str, Any]]) -> str:
    """Say between what the differences of all comparisons lie."""
    values = [row["difference_pct"] for row in evidence if row["difference_pct"] is not None]
    if not values:
        return ""
    number_of = "one comparison" if len(values) == 1 else f"{len(values)} comparisons"
    return f"{number_of}: W/V_c differs by {signed(min(values))} to {signed(max(values))} %"


def _with_label(rows: Iterable[dict[str, Any]]) -> list[dict[str, Any]]:
    return [{**row, "label": architecture_label(row)} for row in rows]


REPORT = PaperReport
"""What makes the report of such a study."""


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
