"""Colours and dashes of controllers from their catalogue: the same in every report."""

from __future__ import annotations

from collections.abc import Iterable

from dmil.controllers import CONTROLLERS
from dmil.reports.labels import controller_label
from dmil.symmetry import EMBEDDINGS

UNKNOWN = "#AA3377"
"""Colour of controllers that a user brings."""


def colour(controller: str, options: Iterable[str] = ()) -> str:
    """Return a controller's colour; some options, such as an embedding, have a shade of it.

    Parameters
    ----------
    controller
        Its name.
    options
        Its embedding, or names of other options that are set.
    """
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
