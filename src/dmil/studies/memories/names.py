"""Names and colours of cells and controllers: as the study writes them, and for a reader."""

from __future__ import annotations

import re
from collections.abc import Sequence

import polars as pl

from dmil.controllers.variants import parse_variant
from dmil.experiments.cells import CITY, Cell
from dmil.reports.labels import colour, dash, short_label

MAX_PRESSURE = "max-pressure"
LONGEST_QUEUE = "longest-queue-first"
LONGEST_QUEUE_APPROACHING = "longest-queue-first,approaching=true"
PLANNER = "foresight"
REFERENCES: dict[str, str] = {
    MAX_PRESSURE: "max_pressure",
    LONGEST_QUEUE: "longest_queue",
    LONGEST_QUEUE_APPROACHING: "approaching",
    PLANNER: "limit",
}
"""References of paired differences, and the prefixes of their columns. The planner knows all
arrivals, and runs on one intersection only: the limit there."""

_SHORT = {
    "approaching=true": " + approaching",
    "embedding=complex": ", complex classes",
}


def cell_label(name: str) -> str:
    """Return "5×5 ×3", "5×5 unequal", "Jinan 2000" for a cell's name (ours)."""
    place, _, load = name.partition("*")
    if place.startswith(CITY):
        folder, _, flow = place.removeprefix(CITY).partition("#")
        found = re.search(r"(\d+)\.json$", flow)
        city = folder.rpartition("/")[2].partition("_")[0].capitalize()
        label = f"{city} {found[1]}" if found else city
    else:
        size, _, demand = place.removeprefix("grid:").partition("/")
        label = size.replace("x", "×") + (f" {demand}" if demand else "")
        if not load and not demand:
            return f"{label} ×1"
    return f"{label} ×{load}" if load else label


def controller_name(label: str) -> str:
    """Return a controller as a reader should see it: "longest queue + approaching" (ours)."""
    name, *options = label.split(",")
    parts = [_SHORT.get(each, ", " + each.replace("epsilon=0.", "ε .")) for each in options]
    return "".join([short_label(name), *parts])


def colour_of(label: str) -> str:
    """Return the colour of a controller with its options."""
    variant = parse_variant(label)
    return colour(variant.name, [*variant.options, *map(str, variant.options.values())])


def palette(labels: Sequence[str]) -> dict[str, str]:
    """Return the colour of each shown name (ours)."""
    return {controller_name(label): colour_of(label) for label in labels}


def dashes(labels: Sequence[str]) -> dict[str, list[int]]:
    """Return the dash of each shown name: those with options are dotted (ours)."""
    found = {}
    for label in labels:
        name, _, options = label.partition(",")
        found[controller_name(label)] = dash(name) if options in ("", "epsilon=0.05") else [2, 2]
    return found


def with_cell(rows: pl.DataFrame) -> pl.DataFrame:
    """Return a table with the name of the ``cell``, from ``scenario`` and ``load`` (ours)."""
    places = rows.select("scenario", "load").rows()
    names = [Cell(place, 1.0 if load is None else load).name for place, load in places]
    return rows.with_columns(cell=pl.Series(names, dtype=pl.String))


def ranked(overall: pl.DataFrame) -> pl.DataFrame:
    """Return the controllers that ran beside max-pressure, the best over all cells first (ours)."""
    known = overall.filter(pl.col("max_pressure_ratio").is_not_null())
    return known.sort("max_pressure_ratio", maintain_order=True)


def named(table: pl.DataFrame) -> pl.DataFrame:
    """Return a table with ``name`` of the controller and, if it has cells, ``where`` (ours)."""
    names = pl.Series([controller_name(each) for each in table["controller"]], dtype=pl.String)
    table = table.with_columns(name=names)
    if "cell" not in table.columns:
        return table
    cells = [None if each is None else cell_label(each) for each in table["cell"]]
    return table.with_columns(where=pl.Series(cells, dtype=pl.String))
