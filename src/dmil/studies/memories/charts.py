"""Figures of the study of memories: who stands where, and what memory costs.

Every function takes aggregated tables and returns a chart, or None without the runs for it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import Any

import altair as alt
import polars as pl

from dmil.reports.contenders import controller_name, dashes, palette
from dmil.reports.marks import (
    Chart,
    coloured,
    dots,
    heading,
    lines,
    log_field,
    ticks,
    tips,
    values,
    vertical_at,
)
from dmil.reports.sheet import label_places
from dmil.reports.theme import FAINT
from dmil.studies.memories.names import (
    LONGEST_QUEUE,
    LONGEST_QUEUE_APPROACHING,
    cell_label,
    named,
    ranked,
)
from dmil.studies.memories.statements import SUBJECTS

RATIO = "waiting / max-pressure's"
_ENDS = {"low": "max_pressure_low", "high": "max_pressure_high"}
_SIZE = (470, 330)


def shown_in_front(controllers: Sequence[str]) -> list[str]:
    """Return the controllers of the headline: the baselines and our memories, if available."""
    front = (*SUBJECTS, LONGEST_QUEUE_APPROACHING, LONGEST_QUEUE)
    return [name for name in front if name in controllers]


def differences(standing: pl.DataFrame, cells: Sequence[str], title: str) -> Chart | None:
    """Draw the paired difference to max-pressure in every cell: the headline."""
    chosen = shown_in_front(standing["controller"].unique().to_list())
    data = named(
        standing.filter(
            pl.col("controller").is_in(chosen), pl.col("max_pressure_pct").is_not_null()
        )
    ).select("name", "where", "n", mean="max_pressure_pct", **_ENDS)
    if data.is_empty():
        return None
    order = [controller_name(name) for name in chosen]
    places = [cell_label(cell) for cell in cells]
    legend = alt.Legend(title=None, orient="bottom", columns=2, labelFontSize=12)
    x_title = "difference to max-pressure in waiting time (%), less is better"
    layers = dots(
        alt.Y(
            "where:N",
            title=None,
            sort=places,
            scale=alt.Scale(paddingInner=0.3, paddingOuter=0.2),
            axis=alt.Axis(grid=False, labelFontSize=12),
        ),
        coloured("name", order, palette(chosen), legend),
        x_title,
        alt.YOffset("name:N", sort=order),
        "+.1f",
    )
    ends = data.select(
        low=pl.min_horizontal("low", "mean").min(), high=pl.max_horizontal("high", "mean").max()
    ).row(0)
    span = max(ends[1], 0.0) - min(ends[0], 0.0) or 1.0
    domain = [min(ends[0], 0.0) - 0.03 * span, max(ends[1], 0.0) + 0.03 * span]
    layers[0] = layers[0].encode(
        x=alt.X("low:Q", title=x_title, scale=alt.Scale(domain=domain, nice=False))
    )
    zero = vertical_at(0.0)
    return alt.layer(zero, *layers, data=values(data)).properties(
        width=470,
        height=alt.Step(8, **{"for": "offset"}),
        title=heading(title, "mean and 95 % interval over seeds, the same vehicles for all"),
    )


def standing_chart(overall: pl.DataFrame) -> Chart | None:
    """Draw every controller's waiting over max-pressure's, over all cells."""
    kept = ("controller", "name", "n")
    data = named(ranked(overall)).select(*kept, mean="max_pressure_ratio", **_ENDS)
    if data.is_empty():
        return None
    order, colours = data["name"].to_list(), palette(data["controller"].to_list())
    colour = coloured("name", order, colours)
    y = alt.Y("name:N", title=None, sort=order, axis=alt.Axis(grid=True, labelLimit=260))
    ends = _ends([*data["mean"], *data["low"].drop_nulls(), *data["high"].drop_nulls()], 1.05)
    layers = dots(y, colour, x=partial(log_field, alt.X, title=RATIO, ends=ends))
    one = vertical_at(1.0)
    return alt.layer(one, *layers, data=values(data.drop("controller"))).properties(
        width=420,
        height=alt.Step(16),
        title=heading(
            "All controllers, over all cells",
            "waiting over max-pressure's: interquartile mean, 95 % interval; log scale",
        ),
    )


def waiting_and_bytes(overall: pl.DataFrame, cost: pl.DataFrame) -> Chart | None:
    """Draw waiting over max-pressure's against bytes per intersection; rules have none."""
    size = (
        cost.group_by("controller", maintain_order=True)
        .agg(pl.col("bytes_per_intersection").mean(), pl.col("learns").any())
        .filter("learns", pl.col("bytes_per_intersection") > 0)
    )
    data = named(
        overall.filter(pl.col("max_pressure_ratio") > 0).join(
            size, on="controller", maintain_order="left"
        )
    ).select(
        "controller",
        "name",
        bytes="bytes_per_intersection",
        mean="max_pressure_ratio",
        **_ENDS,
    )
    if data.is_empty():
        return None
    level = overall.filter(
        pl.col("controller") == LONGEST_QUEUE_APPROACHING,
        pl.col("max_pressure_ratio").is_not_null(),
    )["max_pressure_ratio"]
    rules = [("max-pressure", 1.0)] + [("longest queue + approaching", each) for each in level]
    x = _ends(data["bytes"].to_list(), 1.6)
    y = _ends([*data["mean"], *data["low"].drop_nulls(), *data["high"].drop_nulls(), 1.0], 1.15)
    colours = palette(data["controller"].to_list())
    colour = coloured("name", list(colours), colours)
    across = log_field(alt.X, "bytes:Q", "memory per intersection (bytes)", x)
    up = log_field(alt.Y, "mean:Q", RATIO, y)
    base = alt.Chart(values(data.drop("controller")))
    bar = base.mark_rule(strokeWidth=1.4).encode(
        x=across, y=log_field(alt.Y, "low:Q", RATIO, y), y2=alt.Y2("high:Q"), color=colour
    )
    dot = base.mark_point(filled=True, size=70, opacity=1).encode(
        x=across,
        y=up,
        color=colour,
        tooltip=tips("name:N", "bytes:Q", "mean:Q"),
    )
    flat = alt.Chart(values(pl.DataFrame(rules, schema=["rule", "mean"], orient="row")))
    rule = flat.mark_rule(color=FAINT, strokeDash=[4, 3]).encode(y=up)
    said = flat.mark_text(align="right", baseline="bottom", dx=-3, dy=-2, color=FAINT).encode(
        y=up, x=alt.value(_SIZE[0]), text=alt.Text("rule:N")
    )
    return alt.layer(rule, said, bar, dot, *_names(data, rules, x, y, colour)).properties(
        width=_SIZE[0],
        height=_SIZE[1],
        title=heading(
            "What memory costs and what it brings",
            "means over all cells, 95 % interval; log scale; below 1: better than max-pressure",
        ),
    )


def _ends(numbers: Sequence[float], room: float) -> tuple[float, float]:
    """Return the ends of a logarithmic axis, with some room."""
    return min(numbers) / room, max(numbers) * room


def _names(
    data: pl.DataFrame,
    rules: Sequence[tuple[str, float]],
    x: tuple[float, float],
    y: tuple[float, float],
    colour: alt.Color,
) -> list[alt.Chart]:
    """Return the names of the points, none on another."""

    def share(value: float, ends: tuple[float, float]) -> float:
        return math.log(value / ends[0]) / math.log(ends[1] / ends[0])

    width, height = _SIZE
    points = [
        (width * share(row["bytes"], x), height * (1 - share(row["mean"], y)))
        for row in data.iter_rows(named=True)
    ]
    lines_at = [(name, height * (1 - share(value, y))) for name, value in rules]
    taken = [(width - 7.0 * len(name), at - 15, float(width), at) for name, at in lines_at]
    places = label_places(points, data["name"].to_list(), size=(width, height), taken=taken)
    frame = pl.concat([data.select("name"), pl.DataFrame(places)], how="horizontal")
    bare: dict[str, Any] = {"scale": None, "axis": None, "title": None}
    layers = []
    for align in ("left", "right", "center"):
        chosen = frame.filter(pl.col("align") == align)
        if chosen.height:
            text = alt.Chart(values(chosen)).mark_text(align=align, baseline="middle", fontSize=11)
            placed = {"x": alt.X("x:Q", **bare), "y": alt.Y("y:Q", **bare)}
            layers.append(text.encode(**placed, text=alt.Text("name:N"), color=colour))
    return layers


def profile_chart(profiles: pl.DataFrame, chosen: Sequence[str]) -> Chart | None:
    """Draw which share of the runs waits at most so many times as long as under max-pressure."""
    data = named(profiles.filter(pl.col("controller").is_in(list(chosen))))
    if data.is_empty():
        return None
    order = [controller_name(name) for name in chosen]
    kept = data.select("ratio", "low", "high", line="name", mean="share")
    ends = float(data["ratio"].to_numpy().min()), float(data["ratio"].to_numpy().max())
    return lines(
        kept,
        order,
        palette(chosen),
        dashes(chosen),
        "share of runs",
        heading(
            "Performance profile",
            "share of runs, all cells, with at most this ratio; 95 % band; higher is better",
        ),
        x=alt.X(
            "ratio:Q",
            title=RATIO,
            scale=alt.Scale(type="log", nice=False),
            axis=alt.Axis(values=ticks(*ends), format="~g", ticks=False),
        ),
        x_title=RATIO,
        y=alt.Y("mean:Q", title="share of runs", axis=alt.Axis(format="%")),
        size=(470, 260),
    )
