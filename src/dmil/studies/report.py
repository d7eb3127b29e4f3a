"""The report of a study: pages that work offline, with figures and tables as files beside them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from dmil.reports.drawing import DrawingProcesses
from dmil.reports.export import write_file
from dmil.results import Results
from dmil.studies.registry import report_of

REPORT_FILE = "report.html"


def write_report(
    folder: Path | str,
    *,
    preset: str | None = None,
    pictures: bool = True,
    tables: Any | None = None,
) -> Path:
    """Write ``report.html``, ``figures/`` and ``tables/`` into a folder of results (ours).

    The study on the RESCO benchmark gets a page for each network, too, in ``scenarios/``.
    Everything is computed before the first file is written, each file appears whole, and the main
    page comes last.

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
        The folder is not one of results, is of an unknown study, or cannot be written.
    InputError
        No run succeeded.
    UnknownNameError
        The preset was not run.
    """
    folder = Path(folder)
    with Results(folder) as results:
        report = report_of(results)(results, tables, preset)
        files: dict[str, str | bytes] = report.tables()
        figures = []
        with DrawingProcesses() as drawing:
            for figure in report.figures():
                figures.append(figure)
                if pictures:
                    drawing.draw(figure.name, figure.spec)
            pages = report.pages(figures)
            files |= {f"figures/{name}": data for name, data in drawing.pictures().items()}
    page = pages.pop(REPORT_FILE)
    for name, content in (files | pages).items():
        write_file(folder / name, content)
    write_file(folder / REPORT_FILE, page)
    return folder / REPORT_FILE
