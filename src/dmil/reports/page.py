"""The report: one page that works offline, with figures and tables as files beside it."""

from __future__ import annotations

import re
from importlib import resources
from pathlib import Path
from typing import Any

import jinja2
import markupsafe
import polars as pl

import dmil
from dmil.analysis import Tables, tables_of
from dmil.analysis.cells import BASELINES, PRESET_ORDER, Cells
from dmil.analysis.claims import FEWEST_SEEDS
from dmil.analysis.paper import PAPER_COLUMNS, SOURCE, scenario_label
from dmil.errors import unknown_name
from dmil.reports.assumptions import assumptions, configuration_rows, find_value
from dmil.reports.drawing import DrawingProcesses
from dmil.reports.export import embedded, script_bundle, write_file
from dmil.reports.files import csv, evidence_csv, paper_table_latex
from dmil.reports.gallery import Figure, gallery
from dmil.reports.labels import architecture_label, controller_label, interval, number, signed
from dmil.reports.theme import DARK
from dmil.results import Results
from dmil.theory import STATEMENTS

REPORT_FILE = "report.html"
#: Fewer seeds than this and the intervals are too narrow to rely on.
FEW_SEEDS = 8


def write_report(
    folder: Path | str,
    *,
    preset: str | None = None,
    pictures: bool = True,
    tables: Tables | None = None,
) -> Path:
    """Write ``report.html``, ``figures/`` and ``tables/`` into a folder of results (ours).

    Everything is computed before the first file is written, each file appears whole, and the page
    comes last.

    Parameters
    ----------
    folder
        Folder of results; the report goes into it.
    preset
        Preset that headline and figures show; default: the last of literal, decaying, matched
        that was run.
    pictures
        Whether to write the figures as SVG, PNG and PDF files too.
    tables
        The tables of these results, if they are there already.

    Returns
    -------
    Path of the page.

    Raises
    ------
    OutputError
        The folder is not one of results or cannot be written.
    InputError
        No run succeeded.
    UnknownNameError
        The preset was not run.
    """
    folder = Path(folder)
    with Results(folder) as results:
        tables = tables or tables_of(results)
        shown = preset or _main_preset(tables.cells)
        if shown not in tables.cells.presets:
            raise unknown_name("preset in this study", shown, tables.cells.presets)
        files = _table_files(tables)
        figures = []
        with DrawingProcesses() as drawing:
            for figure in gallery(results, tables, shown):
                figures.append(figure)
                if pictures:
                    drawing.draw(figure.name, figure.spec)
            page = _page(results, tables, figures, shown)
            files |= {f"figures/{name}": data for name, data in drawing.pictures().items()}
    for name, content in files.items():
        write_file(folder / name, content)
    write_file(folder / REPORT_FILE, page)
    return folder / REPORT_FILE


def _main_preset(cells: Cells) -> str:
    known = [name for name in PRESET_ORDER if name in cells.presets]
    return known[-1] if known else cells.presets[0]


def _table_files(tables: Tables) -> dict[str, str | bytes]:
    files: dict[str, str | bytes] = {
        "tables/summary.csv": csv(tables.summary),
        "tables/paper_table.csv": csv(tables.paper),
        "tables/sensitivity.csv": csv(tables.sensitivity),
        "tables/claims.csv": csv(tables.claims),
        "tables/claims_evidence.csv": evidence_csv(tables.claims),
    }
    for preset in tables.cells.presets:
        files[f"tables/paper_table_{preset}.tex"] = paper_table_latex(tables.paper, preset)
    return files


def _page(results: Results, tables: Tables, figures: list[Figure], preset: str) -> str:
    cells = tables.cells
    environment = jinja2.Environment(
        autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters |= {
        "number": number,
        "signed": signed,
        "scenario": scenario_label,
        "controller": controller_label,
        "maths": _maths,
    }
    environment.globals["interval"] = interval
    text = (resources.files("dmil.reports") / "templates" / "report.html.j2").read_text("utf-8")
    configuration = results.manifest.get("configuration", {})
    return environment.from_string(text).render(
        manifest=results.manifest,
        version=dmil.__version__,
        preset=preset,
        presets=cells.presets,
        scenarios=cells.scenarios,
        seeds=cells.seeds,
        few_seeds=FEW_SEEDS,
        fewest_seeds=FEWEST_SEEDS,
        load=find_value(configuration, "load", 1.0),
        counts=results.query(
            "select count(*) runs, count(*) filter (status = 'ok') ok,"
            " any_value(status) filter (status <> 'ok') failure,"
            " min(horizon_s) shortest_s, max(horizon_s) longest_s from runs"
        ).row(0, named=True),
        paper_source=SOURCE,
        paper_columns=PAPER_COLUMNS,
        baselines=[name for name in BASELINES if name in tables.summary["controller"]],
        paper_tables={name: _paper_rows(tables.paper, name) for name in cells.presets},
        best=_best(tables.summary, preset),
        claims=_claim_rows(tables.claims, preset),
        statements=STATEMENTS,
        sensitivity=_sensitivity_rows(tables.sensitivity, cells.presets),
        architectures=_architecture_rows(tables.summary, preset),
        assumptions=assumptions(configuration),
        configuration=configuration_rows(configuration),
        figures=figures,
        specs=[(figure.name, embedded(figure.spec)) for figure in figures],
        bundle=script_bundle(),
        dark_colours=DARK,
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
        of_grid = chosen.filter(pl.col("scenario") == scenario)
        baselines = {
            row["column"]: row
            for row in of_grid.filter(pl.col("reward").is_null()).iter_rows(named=True)
        }
        rewards = of_grid["reward"].drop_nulls().unique(maintain_order=True).to_list()
        for index, reward in enumerate(rewards):
            entries = {
                row["column"]: row
                for row in of_grid.filter(pl.col("reward") == reward).iter_rows(named=True)
            }
            first = {"span": len(rewards), "baselines": baselines} if index == 0 else None
            rows.append(
                {"scenario": scenario, "reward": reward, "entries": entries, "first": first}
            )
    return rows


def _best(table: pl.DataFrame, preset: str) -> list[dict[str, Any]]:
    """Find the learning agent that waits least on each grid, beside the baselines."""
    rows = []
    chosen = table.filter(pl.col("preset") == preset)
    for scenario in chosen["scenario"].unique(maintain_order=True):
        learned = chosen.filter((pl.col("scenario") == scenario) & pl.col("reward").is_not_null())
        if learned.is_empty():
            continue
        row = learned.sort("w_over_vc_mean").row(0, named=True)
        rows.append({**row, "label": architecture_label(row)})
    return rows


def _claim_rows(table: pl.DataFrame, preset: str) -> list[dict[str, Any]]:
    """Claims of the shown preset, each with its verdict under every preset."""
    verdicts: dict[str, dict[str, dict[str, Any]]] = {}
    for row in table.iter_rows(named=True):
        verdicts.setdefault(row["id"], {})[row["preset"]] = row
    return [
        {**by[preset], "evidence_range": _range(by[preset]["evidence"]), "by_preset": by}
        for by in verdicts.values()
    ]


def _range(evidence: list[dict[str, Any]]) -> str:
    """Say between what the differences of all comparisons lie."""
    values = [row["difference_pct"] for row in evidence if row["difference_pct"] is not None]
    if not values:
        return ""
    number_of = "one comparison" if len(values) == 1 else f"{len(values)} comparisons"
    return f"{number_of}: W/V_c differs by {signed(min(values))} to {signed(max(values))} %"


def _sensitivity_rows(table: pl.DataFrame, presets: list[str]) -> list[dict[str, Any]]:
    if len(presets) < 2:
        return []
    rows: dict[tuple[str, ...], dict[str, Any]] = {}
    for row in table.iter_rows(named=True):
        key = (row["scenario"], row["reward"], row["column"])
        rows.setdefault(key, {"key": key, "presets": {}})["presets"][row["preset"]] = row
    return list(rows.values())


def _architecture_rows(table: pl.DataFrame, preset: str) -> list[dict[str, Any]]:
    return [
        {**row, "label": architecture_label(row)}
        for row in table.filter(pl.col("preset") == preset).iter_rows(named=True)
    ]
