"""Names, colours and dashes as a reader should see them: the same in every report."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from dmil.controllers import CONTROLLERS
from dmil.symmetry import EMBEDDINGS

_SIMULATORS = {
    "sumo": "SUMO",
    "cityflow": "CityFlow",
    "sumo-meso": "SUMO, mesoscopic",
    "sumo-unblocked": "SUMO, blockers ignored",
    "queue-calibrated": "queue, calibrated",
}
UNKNOWN = "#AA3377"
"""Colour of controllers that a user brings."""


def controller_label(controller: str) -> str:
    """Return "SARSA" for "sarsa" and so on."""
    entry = CONTROLLERS.get(controller)
    return entry.label or controller if entry else controller


def short_label(controller: str) -> str:
    """Return "longest queue" for "longest-queue-first" and so on, for tables with much in them."""
    entry = CONTROLLERS.get(controller)
    return entry.short if entry and entry.short else controller_label(controller)


def contender_label(name: str) -> str:
    """Return "Dual memory cells + comm." for "dual-memory cells + communication" and so on.

    With approaching vehicles it is "max-pressure + approaching"; other options stay as they are.
    """
    variant, _, rest = name.partition(" ")
    controller, comma, options = variant.partition(",")
    options = " + approaching" if options == "approaching=true" else comma + options
    shown = f"{controller_label(controller)}{options} {rest}"
    return shown.strip().replace("communication", "comm.")


def simulator_label(simulator: str) -> str:
    """Return "SUMO" for "sumo" and so on."""
    return _SIMULATORS.get(simulator, simulator)


def network_label(scenario: str) -> str:
    """Return "cologne1" for "resco/cologne1", other names as they are."""
    return scenario.removeprefix("resco/")


def architecture_label(row: dict[str, Any]) -> str:
    """Return "SARSA exact, ε .6" or "Dual memory complex + comm., ε .4" for a cell."""
    name = controller_label(row["controller"])
    if row["embedding"] is None:
        return name
    shared = " + comm." if row["communication"] else ""
    epsilon = f"{row['epsilon']:g}".replace("0.", ".", 1)
    variant = f", {row['variant']}" if row["variant"] else ""
    return f"{name} {row['embedding']}{shared}, ε {epsilon}{variant}"


def number(value: float | None, digits: int = 3) -> str:
    """Return a number with a true minus sign, "–" if there is none."""
    return "–" if value is None else f"{value:.{digits}f}".replace("-", "−")


def interval(low: float | None, high: float | None, digits: int = 3) -> str:
    """Return "[low, high]", nothing if there is no interval."""
    if low is None or high is None:
        return ""
    return f"[{number(low, digits)}, {number(high, digits)}]"


def signed(value: float | None, digits: int = 1) -> str:
    """Return a percentage with its sign, "–" if there is none."""
    return "–" if value is None else f"{value:+.{digits}f}".replace("-", "−")


def counted(number: int, name: str) -> str:
    """Return a number and what it counts: "3 links" for 3 and "link"."""
    return f"{number:,} {name}{'' if number == 1 else 's'}"


def colour(controller: str, options: Iterable[str] = ()) -> str:
    """Return a controller's colour; some options, such as an embedding, have a shade of it."""
    entry = CONTROLLERS.get(controller)
    if entry is None:
        return UNKNOWN
    return next((entry.shades[each] for each in options if each in entry.shades), entry.colour)


def dash(controller: str) -> list[int]:
    """Return how a controller's lines are dashed: px drawn, px left out."""
    return list(CONTROLLERS[controller].dash) if controller in CONTROLLERS else [1, 0]


def colours_by_label() -> dict[str, str]:
    """Return the colour of every label, such as "SARSA" and "Dual memory complex"."""
    return {
        f"{controller_label(name)} {embedding}".strip(): colour(name, [embedding])
        for name in CONTROLLERS
        for embedding in ("", *EMBEDDINGS)
    }


def dashes_by_label() -> dict[str, list[int]]:
    """Return the dash of every controller's label."""
    return {controller_label(name): dash(name) for name in CONTROLLERS}
