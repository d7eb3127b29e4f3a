"""A figure of a report: its specification, its place, and what it says."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

from dmil.reports.export import Specification, specification
from dmil.reports.marks import Chart
from dmil.reports.theme import DARK, DARK_BACKGROUND


@dataclass(frozen=True, slots=True)
class Figure:
    """One figure.

    Parameters
    ----------
    name
        Name of its files, without ending.
    section
        Part of the report it belongs to.
    scenario
        Scenario it shows, "" for all.
    caption
        What it shows and how to read it.
    spec
        Vega-Lite specification.
    """

    name: str
    section: str
    scenario: str
    caption: str
    spec: Specification


def figure(name: str, section: str, scenario: str, caption: str, chart: Chart) -> Figure:
    """Return a figure whose description, for those who cannot see it, is its caption."""
    spec = specification(chart)
    spec["description"] = caption
    return Figure(name, section, scenario, caption, spec)


Drawn = tuple[str, str, str, Chart | None]
"""Name, section, caption and chart of a figure, None if the runs do not allow it."""


def drawn_figures(drawn: Iterable[Drawn], scenario: str = "") -> Iterator[Figure]:
    """Yield the figures of a scenario that the runs allow, as they are made."""
    for name, section, caption, chart in drawn:
        if chart is not None:
            yield figure(name, section, scenario, caption, chart)


def darkened(made: Figure, section: str) -> Figure:
    """Return a figure for dark pages, such as those of a code host at night.

    Parameters
    ----------
    made
        The figure for light pages.
    section
        Part of the report that it belongs to instead.
    """
    text = json.dumps(made.spec)
    for light, dark in DARK.items():
        text = text.replace(f'"{light}"', f'"{dark}"')
    spec = json.loads(text)
    spec["config"]["background"] = DARK_BACKGROUND
    return replace(made, name=f"{made.name}-dark", section=section, spec=spec)


def slug(name: str) -> str:
    """Return a name as part of a file's name: "grid-5x5" for "grid:5x5"."""
    return "".join(letter if letter.isalnum() else "-" for letter in name)
