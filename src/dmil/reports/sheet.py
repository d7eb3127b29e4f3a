"""A drawing in px that is put together from lines, areas and words, and becomes one chart."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
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
    """Return about how wide a text is in px.

    Parameters
    ----------
    text
        One line.
    size_px
        Height of its font.
    """
    kinds = ("narrow" if c in _NARROW else "wide" if c in _WIDE else "usual" for c in text)
    return size_px * sum(_LETTER_WIDTH[kind] for kind in kinds)


def shortened(text: str, width_px: float, size_px: float) -> str:
    """Return a text that is no wider than asked for, cut at its end if need be.

    Parameters
    ----------
    text
        One line.
    width_px
        What there is room for.
    size_px
        Height of its font.
    """
    if text_width(text, size_px) <= width_px:
        return text
    while text and text_width(f"{text}…", size_px) > width_px:
        text = text[:-1]
    return f"{text}…"


class Sheet:
    """Collects what is drawn; x to the right, y downwards, later things above earlier ones.

    Parameters
    ----------
    width, height
        Size in px.
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
        """Draw a line; ``tip`` is shown where a page is interactive.

        Parameters
        ----------
        points: (points, 2) float64
        colour, width, dash, cap
            Its look.
        tip
            Names and values.
        """
        style = {"colour": colour, "width": round(width, 2)}
        names = tuple(tip) if tip else ()
        self._path(("line", dash, cap, names), points, style | dict(tip or {}))

    def area(self, points: Points, colour: str) -> None:
        """Fill a polygon.

        Parameters
        ----------
        points: (corners, 2) float64
        colour
            Of its inside.
        """
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
        """Draw a circle.

        Parameters
        ----------
        place
            Its middle.
        radius, colour, rim, rim_width
            Its look.
        tip
            Names and values, shown where a page is interactive.
        """
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
        """Write a line, its middle at the height of ``place``.

        Parameters
        ----------
        place
            Where.
        text
            What.
        size, colour, align, bold
            Its look.
        """
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
        """Draw lines with a head at the end of each.

        Parameters
        ----------
        ways: iterable of (points, 2) float64
        colour, width, dash
            Their look.
        """
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
        """Return the drawing as a chart.

        Parameters
        ----------
        title
            What stands above it.
        """
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
        colour = alt.Color("colour:N", scale=None, legend=None)
        fill = alt.Fill("colour:N", scale=None, legend=None)
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
                stroke=alt.Stroke("rim:N", scale=None, legend=None),
                size=alt.Size("size:Q", scale=None, legend=None),
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
                strokeWidth=alt.StrokeWidth("width:N", scale=None, legend=None),
                tooltip=[alt.Tooltip(f"{name}:N") for name in names],
                **path,
                **placed,
            )
        return drawn
