"""Figures of the whole study on the RESCO benchmark.

Every function takes aggregated tables and returns a chart, or None without the runs for it.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import altair as alt
import polars as pl

from dmil.reports.labels import colours_by_label, contender_label, network_label, simulator_label
from dmil.reports.marks import (
    Chart,
    coloured,
    diamonds,
    dots,
    heading,
    log_axis,
    log_field,
    tips,
    values,
)
from dmil.reports.theme import FAINT, INK, SIMULATOR_COLOURS, colours
from dmil.studies.resco.agreement import AFTER, BEFORE
from dmil.studies.resco.published import METRIC

SUFFIX, APPROACHING = " + comm.", " + approaching"
DELAY = "average delay (s)"
_ALL = "all networks"
_SHAPES = {
    "own program": "square",
    "actuated": "square",
    "longest queue first": "triangle-up",
    "longest queue first + approaching": "triangle-right",
    "max-pressure": "triangle-down",
    "max-pressure + approaching": "triangle-left",
    "random": "cross",
}


def labelled(table: pl.DataFrame) -> pl.DataFrame:
    """Return a table with ``label``, the contender's, and ``network`` (ours)."""
    return table.with_columns(
        label=pl.Series([contender_label(name) for name in table["contender"]], dtype=pl.String),
        network=pl.Series([network_label(n or _ALL) for n in table["scenario"]], dtype=pl.String),
    )


def contender_colours(names: Sequence[str]) -> list[str]:
    """Return the colour of each label; what is added by + does not change it (ours)."""
    plain = [name.removesuffix(SUFFIX).removesuffix(APPROACHING) for name in names]
    return colours(plain, colours_by_label())


def contender_marks(names: Sequence[str]) -> tuple[alt.Color, alt.Shape]:
    """Return colour and shape of contenders in one legend: diamonds communicate (ours).

    Marks should be hollow: controllers that do the same lie on each other.
    """
    order = list(names)
    shapes = ["diamond" if SUFFIX in name else _SHAPES.get(name, "circle") for name in order]
    legend = alt.Legend(title=None, orient="right", symbolStrokeWidth=1.7)
    return (
        coloured("label", order, contender_colours(order), legend),
        alt.Shape("label:N", scale=alt.Scale(domain=order, range=shapes), legend=legend),
    )


def hollow(chart: alt.Chart) -> alt.Chart:
    """Return a chart of hollow points (ours)."""
    drawn: alt.Chart = chart.mark_point(filled=False, size=58, strokeWidth=1.7, opacity=1)
    return drawn


def delays(headline: pl.DataFrame, simulator: str) -> Chart | None:
    """Draw the delay of every controller on every network, published numbers as diamonds."""
    data = labelled(headline).filter(pl.col("iqm") > 0)
    if data.is_empty():
        return None
    middle = {"mean": "iqm", "low": "iqm_low", "high": "iqm_high"}
    kept = data.select("label", "network", "n", "median", "published_s", **middle)
    names = kept["label"].unique(maintain_order=True).to_list()
    networks = kept["network"].unique(maintain_order=True).to_list()
    y = alt.Y("label:N", title=None, sort=names, axis=alt.Axis(grid=True, labelLimit=200))
    colour = coloured("label", names, contender_colours(names))
    layers = dots(y, colour, format=".1f", x=partial(log_field, alt.X, title=DELAY))
    medians = (
        alt.Chart()
        .mark_tick(thickness=1.4, height=9, color=INK)
        .encode(
            x=log_field(alt.X, "median:Q", DELAY),
            y=y,
            tooltip=[alt.Tooltip("median:Q", title="median (s)", format=".1f")],
        )
    )
    published = diamonds("published_s", y, "published (s)", 60)
    chart: Chart = (
        alt.layer(*layers, medians, published)
        .properties(width=150, height=15 * len(names))
        .facet(
            facet=alt.Facet("network:N", sort=networks, header=alt.Header(title=None)),
            columns=min(len(networks), 4),
            data=values(kept),
        )
        .resolve_scale(x="independent")
        .properties(
            title=heading(
                f"Average delay in {simulator_label(simulator)} (dots) and as published (diamonds)",
                "interquartile mean and 95 % interval over seeds, ticks: medians; log scale",
            )
        )
    )
    return chart


def locked_runs(locks: pl.DataFrame) -> Chart | None:
    """Draw the share of runs in which a junction locked, where it did under anybody."""
    data = labelled(locks)
    some = data.group_by("network").agg(pl.col("locked").sum()).filter(pl.col("locked") > 0)
    data = data.filter(pl.col("network").is_in(some["network"].to_list()))
    if data.is_empty():
        return None
    kept = data.select(
        "label",
        "network",
        "n",
        "locked",
        "low",
        "high",
        mean="share",
        name=pl.Series([simulator_label(name) for name in data["simulator"]]),
    )
    names = kept["label"].unique(maintain_order=True).to_list()
    order = kept["name"].unique(maintain_order=True).to_list()
    y = alt.Y("label:N", title=None, sort=names, axis=alt.Axis(grid=True, labelLimit=200))
    colour = coloured("name", order, SIMULATOR_COLOURS, alt.Legend(title=None, orient="bottom"))
    layers = dots(y, colour, "share of runs", alt.YOffset("name:N", sort=order), ".2f")
    chart: Chart = (
        alt.layer(*layers)
        .properties(width=210, height=alt.Step(8))
        .facet(
            facet=alt.Facet("network:N", header=alt.Header(title=None)),
            columns=3,
            data=values(kept),
        )
        .properties(
            title=heading(
                "Runs in which a junction locked",
                "share of seeds, 95 % interval (Wilson); networks without a lock are left out",
            )
        )
    )
    return chart


def simulators_scatter(scores: pl.DataFrame, judge: str) -> Chart | None:
    """Draw the delay in the queue simulator over that in SUMO, before and after calibration."""
    chosen = labelled(scores.filter((pl.col("metric") == METRIC) & (pl.col("mean") > 0)))
    slow = chosen.filter(pl.col("simulator") == judge).select("label", "network", sumo="mean")
    fast = chosen.filter(pl.col("simulator").is_in([BEFORE, AFTER]))
    names_of = {BEFORE: "before calibration", AFTER: "after calibration"}
    data = fast.join(slow, on=["label", "network"], maintain_order="left").select(
        "label", "network", "sumo", fast="mean", panel=pl.col("simulator").replace(names_of)
    )
    if data.is_empty() or judge in names_of:
        return None
    names = data["label"].unique(maintain_order=True).to_list()
    panels = [name for name in names_of.values() if name in data["panel"]]
    ends = data.select(
        low=pl.min_horizontal("sumo", "fast").min() / 1.15,
        high=pl.max_horizontal("sumo", "fast").max() * 1.15,
    ).row(0)
    scale = alt.Scale(type="log", domain=ends, nice=False)
    axis = log_axis()
    colour, shape = contender_marks(names)
    diagonal = pl.DataFrame(
        {"panel": [panel for panel in panels for _ in ends], "line": list(ends) * len(panels)}
    )
    equal = (
        alt.Chart()
        .transform_filter("isValid(datum.line)")
        .mark_line(color=FAINT, strokeDash=[4, 3], strokeWidth=1)
        .encode(x=alt.X("line:Q", scale=scale), y=alt.Y("line:Q", scale=scale))
    )
    points = hollow(alt.Chart().transform_filter("isValid(datum.sumo)")).encode(
        x=alt.X("sumo:Q", title=f"{DELAY} in {simulator_label(judge)}", scale=scale, axis=axis),
        y=alt.Y("fast:Q", title=f"{DELAY}, queue simulator", scale=scale, axis=axis),
        color=colour,
        shape=shape,
        tooltip=tips("label:N", "network:N", "sumo:Q", "fast:Q"),
    )
    return (
        alt.layer(equal, points)
        .properties(width=250, height=250)
        .facet(
            column=alt.Column("panel:N", sort=panels, header=alt.Header(title=None)),
            data=values(pl.concat([data, diagonal], how="diagonal")),
        )
        .properties(
            title=heading(
                "One controller on one network, in both simulators",
                "means over seeds; on the dashed line both say the same",
            )
        )
    )


def rank_agreement(agreement: pl.DataFrame, goal: float) -> Chart | None:
    """Draw Kendall's τ of the ranks by delay for every network, before and after calibration."""
    chosen = agreement.filter((pl.col("metric") == METRIC) & pl.col("tau").is_not_null())
    if chosen.is_empty():
        return None
    data = chosen.select(
        network=pl.Series([network_label(n or _ALL) for n in chosen["scenario"]]),
        name=pl.Series([simulator_label(name) for name in chosen["simulator"]]),
        mean="tau",
        low="tau_low",
        high="tau_high",
        n="pairs",
    )
    networks = data["network"].unique(maintain_order=True).to_list()
    order = [n for n in ("queue", "queue, calibrated") if n in data["name"]]
    y = alt.Y("network:N", title=None, sort=networks, axis=alt.Axis(grid=True))
    legend = alt.Legend(title=None, orient="bottom")
    colour = coloured("name", order, SIMULATOR_COLOURS, legend)
    layers = dots(y, colour, "Kendall's τ", alt.YOffset("name:N", sort=order), ".2f")
    rule = alt.Chart().mark_rule(color=FAINT, strokeDash=[4, 3]).encode(x=alt.datum(goal))
    chart: Chart = (
        alt.layer(rule, *layers, data=values(data))
        .properties(
            width=300,
            height=alt.Step(11),
            title=heading(
                "Do both simulators rank the controllers alike?",
                f"τ of the delays, 95 % interval over seeds; dashed: {goal:g}, the goal",
            ),
        )
        .resolve_scale(x="shared")
    )
    return chart


def memory_and_delay(scores: pl.DataFrame, judge: str, reference: pl.DataFrame) -> Chart | None:
    """Draw every learner's delay over max-pressure's against the bytes that it stores."""
    here = scores.filter((pl.col("simulator") == judge) & pl.col("reward").is_not_null())
    key = ["contender", "scenario"]
    size = here.filter(pl.col("metric") == "bytes_total").select(*key, size="mean")
    base = reference.select("scenario", base="mean")
    data = labelled(
        here.filter(pl.col("metric") == METRIC)
        .select(*key, delay="mean")
        .join(size, on=key, maintain_order="left")
        .join(base, on="scenario", maintain_order="left")
        .with_columns(ratio=pl.col("delay") / pl.col("base"))
        .filter((pl.col("size") > 0) & (pl.col("ratio") > 0) & pl.col("ratio").is_finite())
    ).select("label", "network", "ratio", "delay", kib=pl.col("size") / 1024)
    if data.is_empty():
        return None
    colour, shape = contender_marks(data["label"].unique(maintain_order=True).to_list())
    one = alt.Chart().mark_rule(color=FAINT, strokeDash=[4, 3]).encode(y=alt.datum(1))
    points = hollow(alt.Chart()).encode(
        x=log_field(alt.X, "kib:Q", "memory of all agents (KiB)"),
        y=log_field(alt.Y, "ratio:Q", "delay / max-pressure's"),
        color=colour,
        shape=shape,
        tooltip=tips("label:N", "network:N", "kib:Q", "ratio:Q", "delay:Q"),
    )
    return alt.layer(one, points, data=values(data)).properties(
        width=330,
        height=240,
        title=heading(
            "What memory costs and what it brings",
            "one point per learner and network; below the line is better than max-pressure",
        ),
    )
