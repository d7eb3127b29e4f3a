"""Names of cells and controllers as the study writes them, and as a reader should see them."""

from __future__ import annotations

import re

from dmil.reports.labels import short_label

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
CITY = "cityflow:"

_SHORT = {
    "approaching=true": " + approaching",
    "embedding=complex": ", complex classes",
}


def cell_name(scenario: str, load: float | None) -> str:
    """Return a cell's name in one word, such as ``grid:5x5*3`` (ours)."""
    return scenario if load in (None, 1.0) else f"{scenario}*{load:g}"


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
