"""Names and colours of cells and controllers: as the study writes them, and for a reader."""

from __future__ import annotations

import re

import polars as pl

from dmil.experiments.cells import CITY, Cell
from dmil.reports.contenders import controller_name

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
