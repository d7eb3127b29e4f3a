"""``dmil report``: rewrite the report of a study."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from dmil.cli.options import Debug, Json, option
from dmil.cli.terminal import print_json, show, waiting


def report(
    folder: Annotated[
        Path, typer.Argument(metavar="DIR", help="Folder of a finished study.", show_default=False)
    ],
    preset: Annotated[
        str | None,
        option(
            "Report",
            "Preset shown in headline and figures; by default the last one run.",
            "NAME",
        ),
    ] = None,
    pictures: Annotated[
        bool, option("Report", "Also save the figures as SVG, PNG and PDF. [default: yes]")
    ] = True,
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Write the report of a study: one page that works offline, with figures and tables.

    For example:
        dmil report study
        dmil report study --preset literal --no-pictures

    The folder gets report.html, figures/ (SVG, PNG, PDF) and tables/ (CSV, LaTeX); for the RESCO
    study also scenarios/ with a page per network. All of it is computed from the Parquet files
    there, as 'dmil study' already does once.
    """
    with waiting("writing the report"):
        from dmil.studies.report import write_report

        page = write_report(folder, preset=preset, pictures=pictures)
    files = {
        name: sorted(str(path) for path in (folder / name).glob(pattern))
        for name, pattern in (("figures", "*"), ("tables", "*"), ("scenarios", "*.html"))
    }
    if json:
        print_json({"report": page, **files})
        return
    show(f"Report: {page}", f"{len(files['tables'])} tables: {folder / 'tables'}")
    show(f"{len(files['figures'])} pictures: {folder / 'figures'}")
    if files["scenarios"]:
        show(f"Pages of the networks: {folder / 'scenarios'}")
