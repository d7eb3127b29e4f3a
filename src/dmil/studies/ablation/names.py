"""Names of cases as a reader should see them."""

from __future__ import annotations

from dmil.experiments.cells import CITY
from dmil.reports.labels import network_label
from dmil.scenarios.names import shown


def cell_label(name: str) -> str:
    """Return "5×5 ×3", "Jinan", "cologne1" for a cell's name (ours)."""
    place, _, load = name.partition("*")
    if place.startswith(CITY):
        label = shown(place).partition("_")[0].capitalize()
    elif place.startswith("grid:"):
        label = place.removeprefix("grid:").replace("x", "×").replace("/", " ")
    else:
        label = shown(network_label(place)).removesuffix(".sumocfg")
    return f"{label} ×{load}" if load else label
