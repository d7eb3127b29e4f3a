"""A figure of a report: its specification, its place, and what it says."""

from __future__ import annotations

from dataclasses import dataclass

from dmil.reports.export import Specification, specification
from dmil.reports.marks import Chart


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
    """Return a figure whose description, for those who cannot see it, is its caption (ours)."""
    spec = specification(chart)
    spec["description"] = caption
    return Figure(name, section, scenario, caption, spec)


def slug(name: str) -> str:
    """Return a name as part of a file's name: "grid-5x5" for "grid:5x5" (ours)."""
    return "".join(letter if letter.isalnum() else "-" for letter in name)
