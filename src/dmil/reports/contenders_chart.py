"""One measure of all contenders of a comparison: every seed a dot, mean and interval above."""

from __future__ import annotations

import altair as alt
import numpy as np
import polars as pl

from dmil.experiments.comparison import Comparison
from dmil.reports.marks import Chart, values
from dmil.reports.theme import FAINT, INK

ROW_PX = 38
BROAD = 10.0
"""From this ratio between most and least on the axis is logarithmic, or a locked run hides all."""


def contenders_chart(found: Comparison, metric: str, title: str) -> Chart:
    """Draw a measure's means, intervals and seeds, in the order of the contenders.

    Parameters
    ----------
    found
        The comparison.
    metric
        Which measure.
    title
        What its axis is called, with the unit.
    """
    measured, mean = found.measures[metric], found.mean(metric)
    known = measured[np.isfinite(measured) & (measured > 0)]
    broad = known.size > 0 and known.max() > BROAD * known.min()
    seeds = pl.DataFrame(
        [
            {"label": label, "seed": seed, "value": measured[k, i]}
            for i, label in enumerate(found.labels)
            for k, seed in enumerate(found.seeds)
            if measured[k, i] > 0 or not broad
        ],
        schema={"label": pl.String, "seed": pl.Int64, "value": pl.Float64},
    )
    means = pl.DataFrame(
        {"label": found.labels, "value": mean.value, "low": mean.low, "high": mean.high}
    ).fill_nan(None)
    scale = alt.Scale(type="log", nice=True) if broad else alt.Scale(zero=True)
    # A name's options on lines of their own leave the drawing its room on a phone.
    names = alt.Axis(labelExpr="split(datum.label, ',')", labelLimit=160, title=None)
    y = alt.Y("label:N", sort=None, axis=names)
    x = alt.X("value:Q", title=title, scale=scale, axis=alt.Axis(tickCount=5, format=",~f"))
    tip = [alt.Tooltip("label:N", title="controller"), alt.Tooltip("value:Q", format=".1f")]
    dots = alt.Chart(values(seeds)).mark_circle(color=FAINT, opacity=0.45, size=28)
    bars = alt.Chart(values(means.drop_nulls(["low", "high"]))).mark_rule(color=INK, strokeWidth=2)
    points = alt.Chart(values(means)).mark_point(color=INK, filled=True, size=70, opacity=1)
    return alt.layer(
        dots.encode(x=x, y=y, tooltip=[*tip, alt.Tooltip("seed:Q")]),
        bars.encode(x=alt.X("low:Q"), x2=alt.X2("high:Q"), y=y),
        points.encode(x=x, y=y, tooltip=tip),
    ).properties(width="container", height=ROW_PX * len(found.labels))
