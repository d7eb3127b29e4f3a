"""Figures of the study of capacity.

Every function takes aggregated tables and returns a chart, or None without the runs for it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import altair as alt
import polars as pl

from dmil.reports.contenders import controller_name, dashes, palette
from dmil.reports.marks import (
    Chart,
    coloured,
    dashed,
    dots,
    heading,
    line_legend,
    log_field,
    tips,
    values,
)
from dmil.reports.theme import FAINT
from dmil.studies.capacity.disturbed import begin_s
from dmil.studies.capacity.names import DISTURBANCE_LABELS, place_label
from dmil.studies.capacity.recoveries import LASTS_S, UNDISTURBED

_PANEL = (215, 150)
_ACROSS = 3
ADDED = "added delay (s per vehicle)"


def _named(table: pl.DataFrame) -> pl.DataFrame:
    """Return a table with ``name`` of the controller and ``where`` it ran."""
    return table.with_columns(
        name=pl.Series([controller_name(each) for each in table["controller"]], dtype=pl.String),
        where=pl.Series([place_label(each) for each in table["scenario"]], dtype=pl.String),
    )


def capacity_chart(capacities: pl.DataFrame, controllers: Sequence[str]) -> Chart | None:
    """Draw the capacity of every controller on every network."""
    data = _named(capacities).select("name", "where", "low", "high", "n", mean="capacity")
    if data.is_empty():
        return None
    order = [controller_name(each) for each in controllers]
    places = data["where"].unique(maintain_order=True).to_list()
    y = alt.Y("name:N", title=None, sort=order, axis=alt.Axis(grid=True, labelLimit=220))
    colour = coloured("name", order, palette(controllers))
    axis = alt.Axis(tickCount=4)
    layers = dots(
        y,
        colour,
        format=".3f",
        x=lambda field: alt.X(
            field, title="load (times the demand)", scale=alt.Scale(zero=False), axis=axis
        ),
    )
    chart: Chart = (
        alt.layer(*layers)
        .properties(width=150, height=16 * len(order))
        .facet(
            facet=alt.Facet("where:N", sort=places, header=alt.Header(title=None)),
            columns=min(len(places), _ACROSS),
            data=values(data),
        )
        .resolve_scale(x="independent")
        .properties(
            title=heading(
                "The highest load that stays stable",
                "mean and 95 % interval over seeds; further right is better",
            )
        )
    )
    return chart


def curve_chart(curves: pl.DataFrame, controllers: Sequence[str]) -> Chart | None:
    """Draw the delay over load, up to where the queue is shown to grow."""
    data = _named(
        curves.filter((pl.col("verdict") != "grows").fill_null(True), pl.col("mean") > 0)
    ).select("controller", "name", "where", "mean", "low", "high", x="load")
    return _panels(
        data,
        controllers,
        alt.X("x:Q", title="load (times the demand)", axis=alt.Axis(grid=False, tickCount=4)),
        lambda field: log_field(alt.Y, field, "delay (s per vehicle)"),
        heading(
            "Delay over load",
            "mean and 95 % band over seeds, log scale; up to where the queue is shown to grow",
        ),
    )


def disturbance_chart(table: pl.DataFrame, controllers: Sequence[str]) -> Chart | None:
    """Draw how much delay every disturbance adds."""
    data = _named(
        table.filter(pl.col("disturbance") != UNDISTURBED, pl.col("added_s").is_not_null())
    ).with_columns(what=pl.col("disturbance").replace_strict(DISTURBANCE_LABELS, default=None))
    if data.is_empty():
        return None
    data = data.select(
        "name", "where", "what", "n", mean="added_s", low="added_s_low", high="added_s_high"
    )
    order = [controller_name(each) for each in controllers]
    places = data["where"].unique(maintain_order=True).to_list()
    legend = alt.Legend(title=None, orient="bottom", columns=3)
    layers = dots(
        alt.Y("what:N", title=None, sort=list(DISTURBANCE_LABELS.values())),
        coloured("name", order, palette(controllers), legend),
        offset=alt.YOffset("name:N", sort=order),
        format="+.2f",
        x=lambda field: alt.X(field, title=ADDED, axis=alt.Axis(tickCount=4)),
    )
    chart: Chart = (
        alt.layer(*layers)
        .properties(width=160, height=alt.Step(6, **{"for": "offset"}))
        .facet(
            facet=alt.Facet("where:N", sort=places, header=alt.Header(title=None)),
            columns=min(len(places), _ACROSS),
            data=values(data),
        )
        .resolve_scale(x="independent")
        .properties(
            title=heading(
                "What disturbances add",
                "paired difference to the undisturbed run, mean and 95 % interval; less is better",
            )
        )
    )
    return chart


def course_chart(
    courses: pl.DataFrame, controllers: Sequence[str], disturbance: str, horizon_s: int
) -> Chart | None:
    """Draw how many more vehicles wait over time than undisturbed."""
    data = _named(courses.filter(disturbance=disturbance)).select(
        "controller", "name", "where", "mean", "low", "high", x=pl.col("time_s") / 60
    )
    ends = begin_s(horizon_s), begin_s(horizon_s) + LASTS_S[disturbance]
    return _panels(
        data,
        controllers,
        alt.X("x:Q", title="time (min)", axis=alt.Axis(grid=False, tickCount=4)),
        lambda field: alt.Y(field, title="more vehicles waiting"),
        heading(
            f"After: {DISTURBANCE_LABELS[disturbance]}",
            "paired difference to the undisturbed run, mean and 95 % band; "
            "between the lines it lasts",
        ),
        rules=[end_s / 60 for end_s in ends],
    )


def _panels(
    data: pl.DataFrame,
    controllers: Sequence[str],
    x: alt.X,
    y: Any,
    title: alt.TitleParams,
    *,
    rules: Sequence[float] = (),
) -> Chart | None:
    """Draw one panel per network with a line and band for every controller."""
    if data.is_empty():
        return None
    shown = [each for each in controllers if each in data["controller"]]
    names = [controller_name(each) for each in shown]
    places = data["where"].unique(maintain_order=True).to_list()
    legend = line_legend(columns=3, symbolOpacity=1)
    colour = coloured("name", names, palette(shown), legend)
    dash = dashed("name", names, dashes(shown), legend)
    base = alt.Chart().transform_filter("isValid(datum.mean)")
    layers = [
        alt.Chart(alt.InlineData(values=[{"at": at} for at in rules]))
        .mark_rule(color=FAINT, strokeDash=[4, 3])
        .encode(x=alt.X("at:Q"))
    ] * bool(rules)
    layers += [
        base.transform_filter("isValid(datum.low)")
        .mark_area(opacity=0.08)
        .encode(x=x, y=y("low:Q"), y2=alt.Y2("high:Q"), color=colour),
        base.mark_line(strokeWidth=1.7).encode(
            x=x,
            y=y("mean:Q"),
            color=colour,
            strokeDash=dash,
            tooltip=tips("name:N", "x:Q", "mean:Q"),
        ),
    ]
    chart: Chart = (
        alt.layer(*layers)
        .properties(width=_PANEL[0], height=_PANEL[1])
        .facet(
            facet=alt.Facet("where:N", sort=places, header=alt.Header(title=None)),
            columns=min(len(places), _ACROSS),
            data=values(data.drop("controller")),
        )
        .resolve_scale(x="independent", y="independent")
        .properties(title=title)
    )
    return chart
