"""A drawing in px of lines, areas and words that becomes one chart; names beside points."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import altair as alt
import numpy as np
import numpy.typing as npt

from dmil.reports.marks import Chart
from dmil.reports.theme import INK

Points = npt.NDArray[np.float64]

_LETTER_WIDTH = {"narrow": 0.3, "wide": 0.82, "usual": 0.56}
_NARROW, _WIDE = set("iljtfrI.,:;'|!()[] "), set("mwMW@%")


def text_width(text: str, size_px: float) -> float:
    """Return about how wide a line of text is in px, in a font of a height."""
    kinds = ("narrow" if c in _NARROW else "wide" if c in _WIDE else "usual" for c in text)
    return size_px * sum(_LETTER_WIDTH[kind] for kind in kinds)


def shortened(text: str, width_px: float, size_px: float) -> str:
    """Return a line of text that is no wider than asked for, cut at its end if need be."""
    if text_width(text, size_px) <= width_px:
        return text
    while text and text_width(f"{text}…", size_px) > width_px:
        text = text[:-1]
    return f"{text}…"


class Sheet:
    """Collects what is drawn, in px; x to the right, y downwards, later things above earlier ones.

    A ``tip``, names and values, is shown where a page is interactive.
    """

    def __init__(self, width: float, height: float) -> None:
        self.width, self.height = round(width), round(height)
        self._parts: list[tuple[tuple[Any, ...], list[dict[str, Any]]]] = []
        self._paths = 0

    def line(
        self,
        points: Points,
        colour: str,
        width: float,
        *,
        dash: tuple[int, ...] = (),
        cap: str = "butt",
        tip: Mapping[str, str] | None = None,
    ) -> None:
        """Draw a line through (points, 2) float64."""
        style = {"colour": colour, "width": round(width, 2)}
        names = tuple(tip) if tip else ()
        self._path(("line", dash, cap, names), points, style | dict(tip or {}))

    def area(self, points: Points, colour: str) -> None:
        """Fill a polygon of (corners, 2) float64."""
        self._path(("area",), points, {"colour": colour})

    def dot(
        self,
        place: Sequence[float],
        radius: float,
        colour: str,
        *,
        rim: str = "",
        rim_width: float = 0.0,
        tip: Mapping[str, str] | None = None,
    ) -> None:
        """Draw a circle around ``place``."""
        row = {
            "x": round(float(place[0]), 2),
            "y": round(float(place[1]), 2),
            "colour": colour,
            "rim": rim or colour,
            "size": round(4 * radius**2, 2),
        }
        names = tuple(tip) if tip else ()
        self._rows(("dot", rim_width, names)).append(row | dict(tip or {}))

    def text(
        self,
        place: Sequence[float],
        text: str,
        size: float = 11,
        *,
        colour: str = INK,
        align: str = "left",
        bold: bool = False,
    ) -> None:
        """Write a line, its middle at the height of ``place``."""
        row = {"x": round(float(place[0]), 2), "y": round(float(place[1]), 2), "text": text}
        self._rows(("text", size, align, bold)).append(row | {"colour": colour})

    def arrows(
        self,
        ways: Iterable[Points],
        colour: str,
        width: float,
        *,
        dash: tuple[int, ...] = (),
    ) -> None:
        """Draw lines, (points, 2) float64 each, with a head at the end of each."""
        length = 2.2 + 2.6 * width
        heads = []
        for points in ways:
            end = points[-1]
            near = np.hypot(*(points - end).T) > length
            base = points[near][-1] if near.any() else points[0]
            along = (end - base) / max(float(np.hypot(*(end - base))), 1e-9)
            across = np.array([-along[1], along[0]]) * length * 0.42
            foot = end - along * length
            shaft = np.vstack([points[near] if near.any() else points[:1], foot])
            self.line(shaft, colour, width, dash=dash)
            heads.append(np.array([end, foot + across, foot - across]))
        for head in heads:
            self.area(head, colour)

    def chart(self, title: alt.TitleParams) -> Chart:
        """Return the drawing as a chart."""
        layers = [self._layer(look, rows) for look, rows in self._parts]
        chart: Chart = alt.layer(*layers, width=self.width, height=self.height, title=title)
        return chart

    def _path(self, look: tuple[Any, ...], points: Points, style: dict[str, Any]) -> None:
        rows = self._rows(look)
        self._paths += 1
        rows += [
            {"path": self._paths, "at": at, "x": round(float(x), 2), "y": round(float(y), 2)}
            | style
            for at, (x, y) in enumerate(points)
        ]

    def _rows(self, look: tuple[Any, ...]) -> list[dict[str, Any]]:
        """Return where things of a look go: what follows each other becomes one layer."""
        if not self._parts or self._parts[-1][0] != look:
            self._parts.append((look, []))
        return self._parts[-1][1]

    def _layer(self, look: tuple[Any, ...], rows: list[dict[str, Any]]) -> alt.Chart:
        kind, *more = look
        placed = {
            "x": alt.X("x:Q", scale=alt.Scale(domain=[0, self.width]), axis=None),
            "y": alt.Y("y:Q", scale=alt.Scale(domain=[self.height, 0]), axis=None),
        }
        base = alt.Chart(alt.InlineData(values=json.dumps(rows)))
        own: dict[str, Any] = {"scale": None, "legend": None}
        colour, fill = alt.Color("colour:N", **own), alt.Fill("colour:N", **own)
        path = {"detail": alt.Detail("path:N"), "order": alt.Order("at:Q")}
        drawn: alt.Chart
        if kind == "text":
            size, align, bold = more
            mark = base.mark_text(
                fontSize=size,
                align=align,
                baseline="middle",
                fontWeight="bold" if bold else "normal",
            )
            drawn = mark.encode(text=alt.Text("text:N"), color=colour, **placed)
        elif kind == "dot":
            rim_width, names = more
            mark = base.mark_point(filled=True, opacity=1, strokeWidth=rim_width)
            drawn = mark.encode(
                fill=fill,
                stroke=alt.Stroke("rim:N", **own),
                size=alt.Size("size:Q", **own),
                tooltip=[alt.Tooltip(f"{name}:N") for name in names],
                **placed,
            )
        elif kind == "area":
            mark = base.mark_line(interpolate="linear-closed", strokeWidth=0, opacity=1)
            drawn = mark.encode(fill=fill, **path, **placed)
        else:
            dash, cap, names = more
            mark = base.mark_line(
                strokeCap=cap, strokeJoin="round", strokeDash=list(dash) or [1, 0], opacity=1
            )
            drawn = mark.encode(
                color=colour,
                strokeWidth=alt.StrokeWidth("width:N", **own),
                tooltip=[alt.Tooltip(f"{name}:N") for name in names],
                **path,
                **placed,
            )
        return drawn


Box = tuple[float, float, float, float]
"""Left, top, right, bottom in px."""


@dataclass(frozen=True, slots=True)
class Place:
    """Where a name goes: its anchor in px, at half of its height, and what of it stands there."""

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

    Points are in px from the upper left corner of a drawing of that size; ``gap_px`` is the
    distance of a name to its point, and boxes that are ``taken`` are not free.
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
