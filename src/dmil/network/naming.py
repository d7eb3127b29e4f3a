"""Order and names: sides counter-clockwise from East, phases such as "E/W F" and "E F+L"."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from dmil.network.model import Movement

COMPASS = ("E", "NE", "N", "NW", "W", "SW", "S", "SE")
_LETTERS = (("straight", "F"), ("left", "L"), ("right", "R"), ("uturn", "U"))


def order_counter_clockwise(angle_rad: Mapping[str, float]) -> list[str]:
    """Order the roads into an intersection by the side that they come from (ours).

    Counter-clockwise from East, where East begins at -45°: a road from slightly South of East
    still comes first, so that four sides are always E, N, W, S.

    Parameters
    ----------
    angle_rad
        Link id to the angle, counter-clockwise from East, of where its traffic comes from.
    """
    turn = 2 * math.pi

    def key(link: str) -> tuple[float, str]:
        return round((angle_rad[link] + math.pi / 4) % turn, 9) % turn, link

    return sorted(angle_rad, key=key)


def approach_names(angle_rad: Sequence[float]) -> tuple[str, ...]:
    """Name approaches after the point of the compass that they come from (ours).

    Parameters
    ----------
    angle_rad
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
            points[round(angle / (2 * math.pi) * len(points)) % len(points)] for angle in angle_rad
        )
        if len(set(names)) == len(names):
            return names
    return tuple(str(index) for index in range(len(angle_rad)))


def phase_name(phase: frozenset[int], movements: Sequence[Movement], sides: Sequence[str]) -> str:
    """Name a phase in the paper's manner: sides, then F, L, R or U (paper, §III).

    Parameters
    ----------
    phase
        Local movement indices.
    movements
        Movements of the intersection.
    sides
        Name of every approach.
    """
    served: dict[int, set[str]] = {}
    for index in sorted(phase):
        served.setdefault(movements[index].approach, set()).add(movements[index].turn)
    groups: dict[str, list[str]] = {}
    for approach, turns in served.items():
        letters = "+".join(letter for turn, letter in _LETTERS if turn in turns)
        groups.setdefault(letters, []).append(sides[approach])
    return ", ".join(f"{'/'.join(names)} {letters}" for letters, names in groups.items())
