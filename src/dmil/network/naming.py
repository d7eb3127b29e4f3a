"""Readable names of phases, such as "E/W F" and "E F+L"."""

from __future__ import annotations

import math
from collections.abc import Sequence

from dmil.network.model import TURNS, Movement

COMPASS = ("E", "NE", "N", "NW", "W", "SW", "S", "SE")
LETTER = {"right": "R", "straight": "F", "left": "L", "uturn": "U"}


def approach_names(angles_rad: Sequence[float]) -> tuple[str, ...]:
    """Name approaches after the point of the compass they come from (ours).

    Parameters
    ----------
    angles_rad
        Angle of the side that the traffic comes from, counter-clockwise from East.

    Returns
    -------
    tuple of str
        Of four points of the compass if they tell the approaches apart, else of eight, else
        numbers.
    """
    for step in (2, 1):
        points = COMPASS[::step]
        names = tuple(
            points[round(angle / (2 * math.pi) * len(points)) % len(points)] for angle in angles_rad
        )
        if len(set(names)) == len(names):
            return names
    return tuple(str(index) for index in range(len(angles_rad)))


def phase_name(phase: frozenset[int], movements: Sequence[Movement], names: Sequence[str]) -> str:
    """Name a phase in the paper's manner: sides, then F, L or R (paper, Section IV).

    Parameters
    ----------
    phase
        Local movement indices.
    movements
        Movements of the intersection.
    names
        Name of every approach.
    """
    turns: dict[int, set[str]] = {}
    for index in sorted(phase):
        turns.setdefault(movements[index].approach, set()).add(movements[index].turn)
    groups: dict[str, list[str]] = {}
    for approach, served in turns.items():
        order = ("straight", "left", "right", "uturn")
        letters = "+".join(LETTER[turn] for turn in order if turn in served)
        groups.setdefault(letters, []).append(names[approach])
    return ", ".join(f"{'/'.join(sides)} {letters}" for letters, sides in groups.items())


__all__ = ["COMPASS", "LETTER", "TURNS", "approach_names", "phase_name"]
