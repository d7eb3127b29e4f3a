"""The parts that the figures are put together from: lines with bands, dots with bars, panels."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from functools import partial
from typing import Any, TypeVar

import altair as alt
import polars as pl

from dmil.reports.labels import colour, dashes_by_label
from dmil.reports.theme import INK, ONE_COLUMN, colours

Chart = alt.TopLevelMixin
Axis = TypeVar("Axis", alt.X, alt.Y)

WAIT_TITLE = "W/Vc (s per vehicle)"
RULES = ("longest queue first", "max-pressure")
INTERVAL = ("mean", "low", "high", "n")
"""Columns that `dots` draws."""
_MANTISSA = "datum.value / pow(10, floor(log(datum.value) / LN10 + 1e-9))"
_LABELLED = f"indexof([1, 2, 3, 5, 7], round(100 * {_MANTISSA}) / 100) >= 0"
#: Label only 1, 2, 3, 5 and 7 times a power of ten on a logarithmic axis.
LOG_LABELS = f"{_LABELLED} ? format(datum.value, '~g') : ''"


def values(data: pl.DataFrame) -> alt.InlineData:
    """Return rows with five significant digits: the page has to carry them.

    They are JSON text until `dmil.reports.export.specification` is made, because Altair copies and
    checks every number of a list several times.
    """
    floats = [name for name, dtype in data.schema.items() if dtype.is_float()]
    rounded = data.with_columns(pl.col(name).round_sig_figs(5) for name in floats)
    rows = [
        {name: value for name, value in row.items() if value is not None}
        for row in rounded.iter_rows(named=True)
    ]
    return alt.InlineData(values=json.dumps(rows))


def heading(title: str, subtitle: str) -> alt.TitleParams:
    """Return a title with a line of what is shown below it."""
    return alt.TitleParams(title, subtitle=subtitle)


def lines(
    data: pl.DataFrame,
    order: list[str],
    palette: dict[str, str],
    dashes: dict[str, list[int]],
    y_title: str,
    title: alt.TitleParams,
    *,
    x: alt.X | None = None,
    x_title: str = "time (s)",
    y: alt.Y | None = None,
    size: tuple[int, int] = (ONE_COLUMN, 190),
) -> Chart:
    """Draw lines with interval bands over time, or over another number.

    Parameters
    ----------
    data
        Columns ``line``, ``time_s`` (or the field of ``x``), ``mean``, ``low``, ``high``.
    order, palette, dashes
        Names of lines in the order of the legend, those without data left out; colour and dash of
        each.
    y_title, title
        Of the vertical axis, with its unit, and of the figure.
    x, x_title
        Horizontal axis, time by default, and what it is called.
    y
        Vertical axis, linear by default; of the field ``mean``.
    size
        Width and height in px.
    """
    present = set(data["line"].to_list())
    names = [name for name in order if name in present]
    legend = line_legend(columns=2, symbolOpacity=1)
    hue = coloured("line", names, palette, legend)
    x = x or alt.X("time_s:Q", title=x_title, axis=alt.Axis(grid=False, tickCount=6))
    y = y or alt.Y("mean:Q", title=y_title)
    low = y.copy()
    low.shorthand = "low:Q"
    base = alt.Chart(values(data)).encode(x=x)
    band = base.mark_area(opacity=0.2).encode(y=low, y2=alt.Y2("high:Q"), color=hue)
    line = base.mark_line(strokeWidth=1.8).encode(
        y=y,
        color=hue,
        strokeDash=dashed("line", names, dashes, legend),
        tooltip=[
            alt.Tooltip("line:N", title="run"),
            alt.Tooltip(x.shorthand, title=x_title),
            *_interval_tooltip(".4~g"),
        ],
    )
    return alt.layer(band, line, width=size[0], height=size[1], title=title)


def reference_rules() -> alt.Chart:
    """Draw the baselines as vertical lines; the data has ``rule`` and ``rule_at``."""
    rule: alt.Chart = (
        alt.Chart()
        .transform_filter("isValid(datum.rule)")
        .mark_rule(strokeWidth=1.3)
        .encode(
            x=alt.X("rule_at:Q", title=WAIT_TITLE),
            strokeDash=dashed("rule", list(RULES), dashes_by_label(), line_legend()),
            color=alt.value(colour("max-pressure")),
            tooltip=[
                alt.Tooltip("rule:N", title="baseline"),
                alt.Tooltip("rule_at:Q", title="W/Vc", format=".3f"),
            ],
        )
    )
    return rule


def dots(
    y: alt.Y,
    colour: alt.Color,
    x_title: str = WAIT_TITLE,
    offset: alt.YOffset | None = None,
    format: str = ".3f",
    x: Callable[[str], alt.X] | None = None,
) -> list[alt.Chart]:
    """Draw means as dots on their interval; the data has the columns of `INTERVAL`.

    The axis of a field is ``x(field)``, by default linear.
    """
    x = x or partial(alt.X, title=x_title)
    placed: dict[str, Any] = {"y": y, "color": colour}
    if offset is not None:
        placed["yOffset"] = offset
    base = alt.Chart().transform_filter("isValid(datum.mean)")
    bar = base.mark_rule(strokeWidth=1.6).encode(x=x("low:Q"), x2=alt.X2("high:Q"), **placed)
    dot = base.mark_point(filled=True, size=34, opacity=1).encode(
        x=x("mean:Q"),
        tooltip=[
            alt.Tooltip(f"{y.shorthand}", title="run"),
            *_interval_tooltip(format),
            alt.Tooltip("n:Q", title="seeds"),
        ],
        **placed,
    )
    return [bar, dot]


def tips(*fields: str) -> list[alt.Tooltip]:
    """Return what is said of a mark where a page is interactive: some of its fields."""
    return [alt.Tooltip(each) for each in fields]


def panels_across(field: str, order: list[str]) -> alt.Column:
    """Put the panels side by side, each under its name."""
    return alt.Column(f"{field}:N", sort=order, header=alt.Header(title=None))


def panels_down(field: str, order: list[str]) -> alt.Row:
    """Put the panels below each other, each right of its name."""
    header = alt.Header(title=None, labelAngle=0, labelAlign="left", labelPadding=8)
    return alt.Row(f"{field}:N", sort=order, header=header)


def diamonds(field: str, y: alt.Y, title: str, size: int) -> alt.Chart:
    """Draw numbers of a publication as hollow diamonds."""
    look: dict[str, Any] = {"filled": False, "color": INK, "strokeWidth": 1.2, "opacity": 1}
    drawn: alt.Chart = (
        alt.Chart()
        .transform_filter(f"isValid(datum.{field})")
        .mark_point(shape="diamond", size=size, **look)
        .encode(x=alt.X(f"{field}:Q"), y=y, tooltip=[alt.Tooltip(f"{field}:Q", title=title)])
    )
    return drawn


def vertical_at(x: float) -> alt.Chart:
    """Return a vertical line, drawn once and not for every row of a figure's data (ours)."""
    line: alt.Chart = (
        alt.Chart(alt.InlineData(values=[{}]))
        .mark_rule(color=INK, strokeWidth=1.2)
        .encode(x=alt.datum(x))
    )
    return line


def line_legend(**more: Any) -> alt.Legend:
    """Return a legend below the figure that shows lines as strokes."""
    strokes: dict[str, Any] = {"symbolType": "stroke", "symbolSize": 240, "symbolStrokeWidth": 2}
    return alt.Legend(title=None, **{"orient": "bottom"} | strokes | more)


def dashed(
    field: str, names: list[str], dashes: dict[str, list[int]], legend: alt.Legend
) -> alt.StrokeDash:
    """Return the dash of each of the names of a field; those without one are drawn through."""
    chosen = [dashes.get(name, [1, 0]) for name in names]
    return alt.StrokeDash(f"{field}:N", scale=alt.Scale(domain=names, range=chosen), legend=legend)


def coloured(
    field: str,
    names: list[str],
    palette: dict[str, str] | list[str],
    legend: alt.Legend | None = None,
) -> alt.Color:
    """Return the colour of each of the names of a field, from a palette or in their order."""
    chosen = palette if isinstance(palette, list) else colours(names, palette)
    return alt.Color(f"{field}:N", scale=alt.Scale(domain=names, range=chosen), legend=legend)


_TICKS = (
    (1.0,),
    (1.0, 2.0, 5.0),
    (1.0, 1.5, 2.0, 3.0, 5.0, 7.0),
    tuple(i / 20 for i in range(20, 200)),
)
_FEWEST_TICKS = 4


def ticks(low: float, high: float) -> list[float]:
    """Return the values to label on a logarithmic axis: round, and not too many (ours)."""
    found: list[float] = []
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    for steps in _TICKS:
        found = [
            value
            for decade in decades
            for value in (float(f"{step}e{decade}") for step in steps)
            if low <= value <= high
        ]
        if len(found) >= _FEWEST_TICKS:
            break
    return found


def tick_format(low: float) -> str:
    """Return how ticks from ``low`` on are written: thousands as 1k, parts of 1 as they are."""
    return "~s" if low >= 1 else "~g"


def log_scale() -> alt.Scale:
    """Return a logarithmic scale that begins and ends where its data does."""
    return alt.Scale(type="log", nice=False, padding=8)


def log_axis() -> alt.Axis:
    """Return a logarithmic axis with labels at 1, 2, 3, 5 and 7 times a power of ten."""
    return alt.Axis(
        labelExpr=LOG_LABELS, labelOverlap="greedy", labelSeparation=5, grid=True, ticks=False
    )


def log_field(
    kind: type[Axis], field: str, title: str, ends: tuple[float, float] | None = None
) -> Axis:
    """Return a logarithmic axis: between given ends with few, round labels, or as its data goes."""
    scale, axis = log_scale(), log_axis()
    if ends is not None:
        scale = alt.Scale(type="log", domain=list(ends), nice=False)
        labels = ticks(*ends)
        axis = alt.Axis(values=labels, format=tick_format(ends[0]), grid=True, ticks=False)
    return kind(field, title=title, scale=scale, axis=axis)


def _interval_tooltip(format: str) -> list[alt.Tooltip]:
    return [
        alt.Tooltip("mean:Q", title="mean", format=format),
        alt.Tooltip("low:Q", title="95 % from", format=format),
        alt.Tooltip("high:Q", title="to", format=format),
    ]
