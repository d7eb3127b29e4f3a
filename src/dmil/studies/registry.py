"""The studies by name, and what is made of their results: tables, report, terminal."""

from __future__ import annotations

import importlib
from collections.abc import Iterator, Sequence
from typing import Any, Protocol

from rich.console import RenderableType
from rich.text import Text

from dmil.errors import OutputError
from dmil.reports.export import Figure
from dmil.results import Results
from dmil.studies.ablation.study import AblationStudy
from dmil.studies.capacity.study import CapacityStudy
from dmil.studies.memories.study import MemoriesStudy
from dmil.studies.paper.study import PaperStudy
from dmil.studies.protocols.study import ProtocolsStudy
from dmil.studies.resco.study import RescoStudy

STUDIES = {
    study.name: study
    for study in (
        PaperStudy,
        RescoStudy,
        MemoriesStudy,
        AblationStudy,
        CapacityStudy,
        ProtocolsStudy,
    )
}
"""Name to what runs it. Each lies in a folder of its name, beside its modules page and terminal."""


class Report(Protocol):
    """What a report is made of; ``page.REPORT`` of a study makes one of results.

    Parameters
    ----------
    results, tables
        The study, and its tables, if they are there already.
    preset
        Preset that headline and figures show; None: its main one.

    Raises
    ------
    InputError
        No run succeeded.
    UnknownNameError
        There is no such preset in the study.
    """

    def __init__(
        self, results: Results, tables: Any | None = None, preset: str | None = None
    ) -> None: ...

    def tables(self) -> dict[str, str | bytes]:
        """Return the files of tables by name."""

    def figures(self) -> Iterator[Figure]:
        """Yield the figures as they are made."""

    def pages(self, figures: Sequence[Figure]) -> dict[str, str]:
        """Return the pages by name, report.html among them."""


class Terminal(Protocol):
    """What a study says in a terminal: its module terminal."""

    def tables_of(self, results: Results) -> Any:
        """Return the tables of a study."""

    def in_terminal(self, tables: Any) -> Sequence[RenderableType | list[Text]]:
        """Return the parts that are shown, lines of text as lists."""

    def as_json(self, tables: Any) -> dict[str, Any]:
        """Return what is shown as one JSON object."""


def report_of(results: Results) -> type[Report]:
    """Return the class that makes the report of a folder of results.

    Raises
    ------
    OutputError
        They are of an unknown study.
    """
    name = results.manifest.get("study", "paper")
    if name not in STUDIES:
        raise OutputError(
            f"there is no report for a study '{name}'",
            where=str(results.folder),
            expected=f"a study of these: {', '.join(STUDIES)}",
        )
    report: type[Report] = importlib.import_module(f"dmil.studies.{name}.page").REPORT
    return report


def terminal_of(name: str) -> Terminal:
    """Return what a study says in a terminal."""
    terminal: Any = importlib.import_module(f"dmil.studies.{name}.terminal")
    return terminal  # type: ignore[no-any-return]
