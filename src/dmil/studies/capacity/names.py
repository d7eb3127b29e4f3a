"""Names of networks and disturbances, as a reader should see them."""

from __future__ import annotations

from dmil.experiments.cells import CITY
from dmil.reports.labels import network_label
from dmil.studies.capacity.disturbed import (
    CLOSED_S,
    DEAD,
    DEAD_SHARE,
    FAILING,
    FALSE_VEH,
    INCIDENT,
    MISSED_SHARE,
    NOISE,
    OTHER_DAY,
    SURGE,
    SURGE_FACTOR,
    SURGE_S,
)

DISTURBANCE_LABELS = {
    INCIDENT: "lane closed",
    SURGE: "surge",
    DEAD: "dead detectors",
    FAILING: "failing detectors",
    NOISE: "noisy counts",
    OTHER_DAY: "other day",
}
"""Column ``variant`` to what tables call it."""
EXPLAINED = {
    INCIDENT: f"one busy lane is closed for {CLOSED_S // 60} minutes",
    SURGE: f"demand {100 * (SURGE_FACTOR - 1):+.0f} % for {SURGE_S // 60} minutes",
    DEAD: f"{100 * DEAD_SHARE:.0f} % of the detectors read 0",
    FAILING: f"{100 * DEAD_SHARE:.0f} % of the detectors read 0 after a quarter of the run",
    NOISE: f"counts miss every vehicle with a probability of {MISSED_SHARE:g} and "
    f"add {FALSE_VEH:g} vehicles in the mean",
    OTHER_DAY: "another day than the one trained on, against that day itself",
}


def place_label(scenario: str) -> str:
    """Return "5×5", "Jinan", "cologne3" for a scenario's name (ours)."""
    if scenario.startswith(CITY):
        folder, _, flow = scenario.removeprefix(CITY).partition("#")
        city = folder.rpartition("/")[2].partition("_")[0].capitalize()
        return f"{city} {flow.removesuffix('.json')}".rstrip()
    if scenario.startswith("grid:"):
        size, _, demand = scenario.removeprefix("grid:").partition("/")
        return f"{size.replace('x', '×')} {demand}".rstrip()
    return network_label(scenario)
