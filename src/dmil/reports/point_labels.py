"""Names beside points, placed so that they do not lie on each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from dmil.reports.sheet import text_width

Box = tuple[float, float, float, float]
"""Left, top, right, bottom in px."""


@dataclass(frozen=True, slots=True)
class Place:
    """Where a name goes.

    Attributes
    ----------
    x, y: float
        Its anchor in px, at half of its height.
    align: str
        "left", "right" or "center": what of the text stands at the anchor.
    """

    x: float
    y: float
    align: str


def label_places(
    points: Sequence[tuple[float, float]],
    names: Sequence[str],
    *,
    size: tuple[float, float],
    letters_px: float = 11,
    gap_px: float = 8,
    taken: Sequence[Box] = (),
) -> list[Place]:
    """Place names beside their points: right, left, above, below or askew, the first that fits.

    Parameters
    ----------
    points
        In px from the upper left corner.
    names
        One for each.
    size
        Width and height of the drawing in px.
    letters_px
        Height of the letters.
    gap_px
        Distance of a name to its point.
    taken
        Boxes that are not free.
    """
    radius = gap_px / 2
    boxes = [*taken, *((x - radius, y - radius, x + radius, y + radius) for x, y in points)]
    places = []
    for (x, y), name in zip(points, names, strict=True):
        up = gap_px + letters_px / 2
        options = [
            Place(x + gap_px, y, "left"),
            Place(x - gap_px, y, "right"),
            Place(x, y - up, "center"),
            Place(x, y + up, "center"),
            Place(x + gap_px, y - up, "left"),
            Place(x + gap_px, y + up, "left"),
            Place(x - gap_px, y - up, "right"),
            Place(x - gap_px, y + up, "right"),
        ]
        width = text_width(name, letters_px)
        costs = [
            sum(_overlap(_box(option, width, letters_px), box) for box in boxes)
            + _outside(_box(option, width, letters_px), size)
            for option in options
        ]
        best = options[min(range(len(options)), key=lambda number: (costs[number], number))]
        places.append(best)
        boxes.append(_box(best, width, letters_px))
    return places


def _box(place: Place, width: float, height: float) -> Box:
    left = {"left": place.x, "right": place.x - width, "center": place.x - width / 2}[place.align]
    return left, place.y - height / 2, left + width, place.y + height / 2


def _overlap(one: Box, other: Box) -> float:
    """Return the common area of two boxes."""
    width = min(one[2], other[2]) - max(one[0], other[0])
    height = min(one[3], other[3]) - max(one[1], other[1])
    return max(width, 0.0) * max(height, 0.0)


def _outside(box: Box, size: tuple[float, float]) -> float:
    """Return how much of a box's area lies outside, counted more than once: it would be cut."""
    inside = _overlap(box, (0.0, 0.0, *size))
    return 3 * ((box[2] - box[0]) * (box[3] - box[1]) - inside)
