"""Figures of the study of memories: who stands where, and what memory costs.

Every function takes aggregated tables and returns a chart, or None without the runs for it.
"""

from __future__ import annotations

from collections.abc import Sequence

import altair as alt
import polars as pl

from dmil.analysis.memories.names import (
    LONGEST_QUEUE,
    LONGEST_QUEUE_APPROACHING,
    cell_label,
    controller_name,
)
from dmil.analysis.memories.statements import SUBJECTS
from dmil.reports.marks import Chart, dots, heading, lines, values
from dmil.reports.memories_look import dashes, named, palette
from dmil.reports.resco_charts import log_axis, log_x, log_y
from dmil.reports.theme import FAINT, INK

RATIO = "waiting / max-pressure's"


def shown_in_front(controllers: Sequence[str]) -> list[str]:
    """Return whom the headline shows: the baselines and our memories, or the best there is."""
    front = [name for name in (*SUBJECTS, LONGEST_QUEUE_APPROACHING, LONGEST_QUEUE)]
    return [name for name in front if name in controllers]


def differences(standing: pl.DataFrame, cells: Sequence[str], title: str) -> Chart | None:
    """Draw the paired difference to max-pressure in every cell: the headline."""
    chosen = shown_in_front(standing["controller"].unique().to_list())
    data = named(
        standing.filter(
            pl.col("controller").is_in(chosen), pl.col("max_pressure_pct").is_not_null()
        )
    ).select(
        "name",
        "where",
        "n",
        mean="max_pressure_pct",
        low="max_pressure_low",
        high="max_pressure_high",
    )
    if data.is_empty():
        return None
    order = [controller_name(name) for name in chosen]
    places = [cell_label(cell) for cell in cells]
    colours = palette(chosen)
    x_title = "difference to max-pressure in waiting time (%), less is better"
    layers = dots(
        alt.Y("where:N", title=None, sort=places, axis=alt.Axis(grid=True, labelFontSize=12)),
        alt.Color(
            "name:N",
            scale=alt.Scale(domain=order, range=[colours[name] for name in order]),
            legend=alt.Legend(title=None, orient="bottom", columns=2, labelFontSize=12),
        ),
        x_title,
        alt.YOffset("name:N", sort=order),
        "+.1f",
    )
    zero = alt.Chart().mark_rule(color=INK, strokeWidth=1.2).encode(x=alt.datum(0))
    return alt.layer(zero, *layers, data=values(data)).properties(
        width=470,
        height=alt.Step(7),
        title=heading(title, "mean and 95 % interval over seeds, the same vehicles for all"),
    )


def standing_chart(overall: pl.DataFrame) -> Chart | None:
    """Draw every controller's waiting over max-pressure's, over all cells."""
    data = named(
        overall.filter(pl.col("max_pressure_ratio").is_not_null()).sort(
            "max_pressure_ratio", maintain_order=True
        )
    ).select(
        "controller",
        "name",
        "n",
        mean="max_pressure_ratio",
        low="max_pressure_low",
        high="max_pressure_high",
    )
    if data.is_empty():
        return None
    order, colours = data["name"].to_list(), palette(data["controller"].to_list())
    colour = alt.Color(
        "name:N",
        scale=alt.Scale(domain=order, range=[colours[name] for name in order]),
        legend=None,
    )
    y = alt.Y("name:N", title=None, sort=order, axis=alt.Axis(grid=True, labelLimit=260))
    layers = [
        layer.encode(x=log_x("low:Q" if number == 0 else "mean:Q", RATIO))
        for number, layer in enumerate(dots(y, colour, RATIO, format=".3f"))
    ]
    one = alt.Chart().mark_rule(color=INK, strokeWidth=1.2).encode(x=alt.datum(1))
    return alt.layer(one, *layers, data=values(data.drop("controller"))).properties(
        width=420,
        height=alt.Step(16),
        title=heading(
            "All controllers, over all cells",
            "waiting over max-pressure's: interquartile mean, 95 % interval; logarithmic",
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
        low="max_pressure_low",
        high="max_pressure_high",
    )
    if data.is_empty():
        return None
    labels = data["controller"].to_list()
    colours = palette(labels)
    colour = alt.Color(
        "name:N", scale=alt.Scale(domain=list(colours), range=list(colours.values())), legend=None
    )
    level = overall.filter(
        pl.col("controller").is_in([LONGEST_QUEUE_APPROACHING]),
        pl.col("max_pressure_ratio").is_not_null(),
    )
    rules = [(1.0, "max-pressure")] + [
        (row["max_pressure_ratio"], "longest queue + approaching")
        for row in level.iter_rows(named=True)
    ]
    base = alt.Chart(values(data.drop("controller")))
    x = log_x("bytes:Q", "memory per intersection (bytes)")
    y = log_y("mean:Q", RATIO)
    flat = alt.Chart(values(pl.DataFrame(rules, schema=["mean", "rule"], orient="row")))
    rule = flat.mark_rule(color=FAINT, strokeDash=[4, 3]).encode(y=y)
    said = flat.mark_text(align="left", baseline="bottom", dx=3, dy=-2, color=FAINT).encode(
        y=y, x=alt.value(0), text="rule:N"
    )
    bar = base.mark_rule(strokeWidth=1.4).encode(
        x=x, y=log_y("low:Q", RATIO), y2="high:Q", color=colour
    )
    dot = base.mark_point(filled=True, size=70, opacity=1).encode(
        x=x,
        y=y,
        color=colour,
        tooltip=["name:N", "bytes:Q", "mean:Q"],
    )
    name = base.mark_text(align="left", dx=8, fontSize=11).encode(
        x=x, y=y, text="name:N", color=colour
    )
    return alt.layer(rule, said, bar, dot, name).properties(
        width=470,
        height=330,
        title=heading(
            "What memory costs and what it brings",
            "means over all cells, 95 % interval; both axes logarithmic; below 1 is better than "
            "max-pressure",
        ),
    )


def profile_chart(profiles: pl.DataFrame, chosen: Sequence[str]) -> Chart | None:
    """Draw which share of the runs waits at most so many times as long as under max-pressure."""
    data = named(profiles.filter(pl.col("controller").is_in(list(chosen))))
    if data.is_empty():
        return None
    order = [controller_name(name) for name in chosen]
    kept = data.select("ratio", "low", "high", line="name", mean="share")
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
            axis=log_axis(),
        ),
        x_title=RATIO,
        y=alt.Y("mean:Q", title="share of runs", axis=alt.Axis(format="%")),
        size=(470, 260),
    )
