"""Figures of the study of memories over time, and of what factored memory's ingredients bring."""

from __future__ import annotations

from collections.abc import Sequence

import altair as alt
import polars as pl

from dmil.reports.contenders import colour_of, controller_name, dashes, palette
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
    vertical_at,
)
from dmil.reports.theme import FAINT
from dmil.studies.memories.names import cell_label, named

_PANEL = (205, 130)
_ACROSS = 3


def learning_chart(learning: pl.DataFrame, cells: Sequence[str]) -> Chart | None:
    """Draw the waiting in every hour of training and in the test, over max-pressure's."""
    data = named(
        learning.filter(pl.col("base") > 0).with_columns(
            pl.col("mean", "low", "high") / pl.col("base")
        )
    )
    if data.is_empty():
        return None
    kept = data.select("controller", "where", "name", "mean", "low", "high", x="run", test="test")
    axis = alt.Axis(grid=False, tickMinStep=1, tickCount=6, format="d")
    return _panels(
        kept,
        cells,
        alt.X("x:Q", title="hour (last: test)", axis=axis),
        "waiting / max-pressure's",
        heading(
            "Learning",
            "waiting over max-pressure's (the line at 1), exploration included; mean over seeds, "
            "95 % band; dots: learning from the test's first second",
        ),
        rule=1.0,
    )


def memory_chart(memory: pl.DataFrame, cells: Sequence[str]) -> Chart | None:
    """Draw true bytes per intersection over the hours of the learners' lives."""
    data = named(memory)
    if data.is_empty():
        return None
    unknown = {"low": pl.lit(None, pl.Float64), "high": pl.lit(None, pl.Float64)}
    kept = data.select("controller", "where", "name", x="hour", mean="bytes", **unknown)
    return _panels(
        kept,
        cells,
        alt.X("x:Q", title="hours (last: test)", axis=alt.Axis(grid=False, tickCount=6)),
        "bytes per intersection",
        heading("Memory over time", "true bytes per intersection, mean over seeds; log scale"),
    )


def ablation_chart(ablation: pl.DataFrame, subject: str) -> Chart | None:
    """Draw what every ablation changes against factored memory as it is, over all cells."""
    data = named(ablation.filter(pl.col("cell").is_null())).select(
        "name", "low", "high", "n", mean="pct"
    )
    if data.is_empty():
        return None
    order = data["name"].to_list()
    layers = dots(
        alt.Y("name:N", title=None, sort=order, axis=alt.Axis(grid=True, labelLimit=300)),
        coloured("name", order, [colour_of(subject)]),
        f"difference to {controller_name(subject)} in waiting time (%)",
        format="+.1f",
    )
    zero = vertical_at(0.0)
    return alt.layer(zero, *layers, data=values(data)).properties(
        width=360,
        height=alt.Step(18),
        title=heading(
            "Effect of the components",
            "over all cases: interquartile mean of ratios, 95 % interval; to the right is worse",
        ),
    )


def _panels(
    data: pl.DataFrame,
    cells: Sequence[str],
    x: alt.X,
    y_title: str,
    title: alt.TitleParams,
    *,
    rule: float | None = None,
) -> Chart:
    """Draw one panel per cell with lines of all learners, single points as dots."""
    learners = data["controller"].unique(maintain_order=True).to_list()
    data = data.drop("controller")
    places = [cell_label(cell) for cell in cells]
    places = [place for place in places if (data["where"] == place).any()]
    names = [controller_name(name) for name in learners]
    legend = line_legend(columns=4, symbolOpacity=1)
    colour = coloured("name", names, palette(learners), legend)
    dash = dashed("name", names, dashes(learners), legend)
    numbers = [*data["mean"], *data["low"].drop_nulls(), *data["high"].drop_nulls()]
    ends = min(numbers) / 1.1, max(numbers) * 1.1
    y = log_field(alt.Y, "mean:Q", y_title, ends)
    low = log_field(alt.Y, "low:Q", y_title, ends)
    points = data.group_by("where", "name").len().filter(pl.col("len") == 1)
    marked = data.join(points, on=["where", "name"], how="left", maintain_order="left")
    base = alt.Chart().transform_filter("isValid(datum.mean)")
    layers = [
        base.transform_filter("isValid(datum.low)")
        .mark_area(opacity=0.15)
        .encode(x=x, y=low, y2=alt.Y2("high:Q"), color=colour),
        base.mark_line(strokeWidth=1.7).encode(
            x=x,
            y=y,
            color=colour,
            strokeDash=dash,
            tooltip=tips("name:N", "x:Q", "mean:Q"),
        ),
        base.transform_filter("isValid(datum.len)")
        .mark_point(filled=True, size=40, opacity=1)
        .encode(x=x, y=y, color=colour, tooltip=tips("name:N", "mean:Q")),
    ]
    if rule is not None:
        layers.insert(0, alt.Chart().mark_rule(color=FAINT).encode(y=alt.datum(rule)))
    chart: Chart = (
        alt.layer(*layers)
        .properties(width=_PANEL[0], height=_PANEL[1])
        .facet(
            facet=alt.Facet("where:N", sort=places, header=alt.Header(title=None)),
            columns=min(len(places), _ACROSS),
            data=values(marked),
        )
        .properties(title=title)
    )
    return chart
