"""The parts that the figures are put together from: lines with bands, dots with bars, panels."""

from __future__ import annotations

import json
from typing import Any

import altair as alt
import polars as pl

from dmil.reports.styles import colour, dashes_by_label
from dmil.reports.theme import ONE_COLUMN, colours

Chart = alt.TopLevelMixin

WAIT_TITLE = "W/Vc (s per vehicle)"
RULES = ("longest queue first", "max-pressure")


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
    order
        Names of lines in the order of the legend; those without data are left out.
    palette, dashes
        Colour and dash of each name.
    y_title
        Title of the vertical axis, with its unit.
    title
        Title of the figure.
    x, x_title
        Horizontal axis, time by default, and what it is called.
    y
        Vertical axis, linear by default; of the field ``mean``.
    size
        Width and height in px.
    """
    present = set(data["line"].to_list())
    names = [name for name in order if name in present]
    legend = alt.Legend(
        title=None,
        orient="bottom",
        columns=2,
        symbolType="stroke",
        symbolOpacity=1,
        symbolSize=240,
        symbolStrokeWidth=2,
    )
    hue = alt.Color(
        "line:N", scale=alt.Scale(domain=names, range=colours(names, palette)), legend=legend
    )
    dash_range = [dashes.get(name, [1, 0]) for name in names]
    x = x or alt.X("time_s:Q", title=x_title, axis=alt.Axis(grid=False, tickCount=6))
    y = y or alt.Y("mean:Q", title=y_title)
    low = y.copy()
    low.shorthand = "low:Q"
    base = alt.Chart(values(data)).encode(x=x)
    band = base.mark_area(opacity=0.2).encode(y=low, y2="high:Q", color=hue)
    line = base.mark_line(strokeWidth=1.8).encode(
        y=y,
        color=hue,
        strokeDash=alt.StrokeDash(
            "line:N", scale=alt.Scale(domain=names, range=dash_range), legend=legend
        ),
        tooltip=[
            alt.Tooltip("line:N", title="run"),
            alt.Tooltip(x.shorthand, title=x_title),
            *_interval_tooltip(".4~g"),
        ],
    )
    return alt.layer(band, line, width=size[0], height=size[1], title=title)


def reference_rules() -> alt.Chart:
    """Draw the baselines as vertical lines; the data has ``rule`` and ``rule_at``."""
    dashes = dashes_by_label()
    rule: alt.Chart = (
        alt.Chart()
        .transform_filter("isValid(datum.rule)")
        .mark_rule(strokeWidth=1.3)
        .encode(
            x=alt.X("rule_at:Q", title=WAIT_TITLE),
            strokeDash=alt.StrokeDash(
                "rule:N",
                scale=alt.Scale(domain=list(RULES), range=[dashes[name] for name in RULES]),
                legend=alt.Legend(
                    title=None,
                    orient="bottom",
                    symbolType="stroke",
                    symbolSize=240,
                    symbolStrokeWidth=2,
                ),
            ),
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
) -> list[alt.Chart]:
    """Draw means as dots on their interval; the data has ``mean``, ``low``, ``high``, ``n``."""
    placed: dict[str, Any] = {"y": y, "color": colour}
    if offset is not None:
        placed["yOffset"] = offset
    base = alt.Chart().transform_filter("isValid(datum.mean)")
    bar = base.mark_rule(strokeWidth=1.6).encode(
        x=alt.X("low:Q", title=x_title), x2="high:Q", **placed
    )
    dot = base.mark_point(filled=True, size=34, opacity=1).encode(
        x=alt.X("mean:Q", title=x_title),
        tooltip=[
            alt.Tooltip(f"{y.shorthand}", title="run"),
            *_interval_tooltip(format),
            alt.Tooltip("n:Q", title="seeds"),
        ],
        **placed,
    )
    return [bar, dot]


def panels_across(field: str, order: list[str]) -> alt.Column:
    """Put the panels side by side, each under its name."""
    return alt.Column(f"{field}:N", sort=order, header=alt.Header(title=None))


def panels_down(field: str, order: list[str]) -> alt.Row:
    """Put the panels below each other, each right of its name."""
    header = alt.Header(title=None, labelAngle=0, labelAlign="left", labelPadding=8)
    return alt.Row(f"{field}:N", sort=order, header=header)


def _interval_tooltip(format: str) -> list[alt.Tooltip]:
    return [
        alt.Tooltip("mean:Q", title="mean", format=format),
        alt.Tooltip("low:Q", title="95 % from", format=format),
        alt.Tooltip("high:Q", title="to", format=format),
    ]
