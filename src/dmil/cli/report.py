"""``dmil report``: the report of a study again."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from dmil.cli.help import Command
from dmil.cli.options import Debug, Json
from dmil.cli.terminal import print_json, show, waiting

app = typer.Typer(add_completion=False)


@app.command(cls=Command)
def report(
    folder: Annotated[
        Path, typer.Argument(metavar="DIR", help="Folder of a finished study.", show_default=False)
    ],
    preset: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            rich_help_panel="Report",
            help="Preset that headline and figures show; by default the last that was run.",
        ),
    ] = None,
    pictures: Annotated[
        bool,
        typer.Option(
            help="Whether to draw the figures as SVG, PNG and PDF, too. [default: yes]",
            show_default=False,
            rich_help_panel="Report",
        ),
    ] = True,
    json: Json = False,
    debug: Debug = False,
) -> None:
    """Write the report of a study: one page that works offline, figures and tables beside it.

    For example:
        dmil report study
        dmil report study --preset literal --no-pictures

    Into the folder come report.html, figures/ (SVG, PNG, PDF) and tables/ (CSV, LaTeX); for the
    study on the RESCO benchmark also scenarios/, a page for each network. All of it is computed
    from the Parquet files there; 'dmil study' has done it once already.
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
