"""Figures of one network of the RESCO benchmark.

Every function takes aggregated tables and returns a chart, or None without the runs for it.
"""

from __future__ import annotations

from functools import partial

import altair as alt
import polars as pl

from dmil.reports.labels import (
    colours_by_label,
    controller_label,
    dash,
    dashes_by_label,
    network_label,
    simulator_label,
)
from dmil.reports.marks import (
    INTERVAL,
    Chart,
    coloured,
    dashed,
    dots,
    heading,
    line_legend,
    lines,
    log_field,
    log_scale,
    tips,
    values,
)
from dmil.reports.theme import FAINT, INK, SIMULATOR_COLOURS, colours
from dmil.studies.resco.charts import (
    APPROACHING,
    DELAY,
    SUFFIX,
    contender_colours,
    contender_marks,
    hollow,
    labelled,
)
from dmil.studies.resco.contenders import SIMULATOR_ORDER
from dmil.studies.resco.published import METHODS, METRIC

_SIZE = (430, 230)
_TIME_AXIS = alt.Axis(grid=False, tickCount=6)
_RULES = {controller_label(name): dash(name) for name in ("max-pressure", "longest-queue-first")}
_PUBLISHED = {f"published {method}": INK for method in METHODS}


def delay_by_simulator(scores: pl.DataFrame, scenario: str) -> Chart | None:
    """Draw the delay of every controller in every simulator."""
    data = labelled(
        scores.filter(
            (pl.col("scenario") == scenario) & (pl.col("metric") == METRIC) & (pl.col("mean") > 0)
        )
    )
    if data.is_empty():
        return None
    simulators = pl.Series([simulator_label(name) for name in data["simulator"]])
    kept = data.select("label", *INTERVAL, simulator=simulators)
    names = kept["label"].unique(maintain_order=True).to_list()
    order = [name for name in map(simulator_label, SIMULATOR_ORDER) if name in kept["simulator"]]
    y = alt.Y("label:N", title=None, sort=names, axis=alt.Axis(grid=True, labelLimit=200))
    legend = alt.Legend(title=None, orient="bottom")
    colour = coloured("simulator", order, SIMULATOR_COLOURS, legend)
    offset = alt.YOffset("simulator:N", sort=order)
    layers = dots(y, colour, DELAY, offset, ".1f", partial(log_field, alt.X, title=DELAY))
    return alt.layer(*layers, data=values(kept)).properties(
        width=_SIZE[0],
        height=alt.Step(7),
        title=heading(
            f"Delay in every simulator, {network_label(scenario)}",
            "mean and 95 % interval over seeds; log scale",
        ),
    )


def training_curves(
    curves: pl.DataFrame, scenario: str, rules: dict[str, float], trained_in: str
) -> Chart | None:
    """Draw the delay of every training episode, beside other numbers."""
    data = labelled(curves.filter((pl.col("scenario") == scenario) & (pl.col("mean") > 0)))
    if data.is_empty():
        return None
    learners = data["label"].unique(maintain_order=True).to_list()
    ends = [1, max(data["episode"].n_unique(), 2)]
    chosen = data.select(pl.col("episode") + 1, "mean", "low", "high", line="label")
    level = [(episode, name, value) for name, value in rules.items() for episode in ends]
    flat = pl.DataFrame(level, schema=["episode", "line", "mean"], orient="row").with_columns(
        pl.col("episode").cast(chosen.schema["episode"]), low="mean", high="mean"
    )
    names = [*learners, *rules]
    palette = [*contender_colours(learners), *colours(list(rules), colours_by_label() | _PUBLISHED)]
    return lines(
        pl.concat([chosen, flat.select(chosen.columns)]) if rules else chosen,
        names,
        dict(zip(names, palette, strict=True)),
        dashes(names),
        f"{DELAY} of the episode",
        heading(
            f"Training, {network_label(scenario)}",
            f"in {simulator_label(trained_in)}, exploration included; mean over seeds, 95 % band",
        ),
        x=alt.X(
            "episode:Q",
            title="episode",
            scale=alt.Scale(domain=ends, nice=False),
            axis=alt.Axis(grid=False, tickCount=min(ends[1] - 1, 6), format="d"),
        ),
        x_title="episode",
        y=log_field(alt.Y, "mean:Q", f"{DELAY} of the episode"),
        size=_SIZE,
    )


def queues(courses: pl.DataFrame, scenario: str, judge: str) -> Chart | None:
    """Draw the vehicles that wait over time under every controller."""
    data = labelled(courses.with_columns(scenario=pl.lit(scenario)))
    if data.is_empty():
        return None
    names = data["label"].unique(maintain_order=True).to_list()
    return lines(
        data.select("time_s", "mean", "low", "high", line="label"),
        names,
        dict(zip(names, contender_colours(names), strict=True)),
        dashes(names),
        "vehicles waiting (veh)",
        heading(
            f"Queues in {simulator_label(judge)}, {network_label(scenario)}",
            "mean over seeds of minutes' means, 95 % band; square-root scale",
        ),
        x=alt.X("time_s:Q", title="time (s)", scale=alt.Scale(nice=False), axis=_TIME_AXIS),
        y=alt.Y("mean:Q", title="vehicles waiting (veh)", scale=alt.Scale(type="sqrt")),
        size=_SIZE,
    )


def delay_and_memory(scores: pl.DataFrame, scenario: str, judge: str) -> Chart | None:
    """Draw every learner's delay against the bytes that it stores, baselines as rules."""
    here = scores.filter((pl.col("scenario") == scenario) & (pl.col("simulator") == judge))
    delay = labelled(here.filter((pl.col("metric") == METRIC) & (pl.col("mean") > 0)))
    size = here.filter(pl.col("metric") == "bytes_total").select("contender", size="mean")
    data = (
        delay.filter(pl.col("reward").is_not_null())
        .join(size, on="contender", maintain_order="left")
        .filter(pl.col("size") > 0)
        .select("label", *INTERVAL, kib=pl.col("size") / 1024)
    )
    if data.is_empty():
        return None
    colour, shape = contender_marks(data["label"].unique(maintain_order=True).to_list())
    base = alt.Chart(values(data)).encode(x=log_field(alt.X, "kib:Q", "memory of all agents (KiB)"))
    bars = base.mark_rule(strokeWidth=1.4).encode(
        y=log_field(alt.Y, "low:Q", DELAY), y2=alt.Y2("high:Q"), color=colour
    )
    points = hollow(base).encode(
        y=log_field(alt.Y, "mean:Q", DELAY),
        color=colour,
        shape=shape,
        tooltip=tips("label:N", "kib:Q", "mean:Q", "low:Q", "high:Q"),
    )
    rules = delay.filter(pl.col("label").is_in(list(_RULES))).select("label", "mean")
    order = [name for name in _RULES if name in rules["label"]]
    baselines = (
        alt.Chart(values(rules))
        .mark_rule(color=FAINT, strokeWidth=1.4)
        .encode(
            y=alt.Y("mean:Q", title=DELAY, scale=log_scale()),
            strokeDash=dashed("label", order, _RULES, line_legend(orient="right")),
        )
    )
    return alt.layer(*([baselines] if order else []), bars, points).properties(
        width=330,
        height=_SIZE[1],
        title=heading(
            f"Delay in {simulator_label(judge)} and memory, {network_label(scenario)}",
            "mean and 95 % interval over seeds; log scale; lines: no memory",
        ),
    )


def dashes(names: list[str]) -> dict[str, list[int]]:
    """Return a dash for each label: the rules' own, long for communication (ours)."""
    own, added = dashes_by_label(), {SUFFIX: [7, 3], APPROACHING: [2, 2]}
    return {
        name: next((dash for end, dash in added.items() if end in name), own.get(name, [1, 0]))
        for name in names
    }
