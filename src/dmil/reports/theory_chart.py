"""The growth bounds of the theory as a figure."""

from __future__ import annotations

import altair as alt
import numpy as np
import polars as pl

from dmil.reports.marks import Chart, values
from dmil.reports.theme import FAINT
from dmil.theory import best_case, worst_case

AFTER, BEFORE = "ζ1, right after a staging", "ζ2, right before one"
_COLOURS = {AFTER: "#228833", BEFORE: "#AA3377"}
_WIDTH, _HEIGHT = 300, 190


def growth_ratios(
    actions: int, staged_ratio: float, stage_period: int, stagings: int, distinct_states: int
) -> Chart:
    """Draw ζ of the worst case over stagings beside ζ of the best case over states met.

    The first three are |A|, κ and T; the others the last points: n stagings, M distinct states.
    """
    n, m = _points(stagings), _points(distinct_states)
    worst = worst_case(actions, staged_ratio, stage_period, n)
    best = best_case(actions, stage_period, m)
    panels = [
        _panel(n, worst.zeta1, worst.zeta2, "stagings n", "All states are new (worst case)"),
        _panel(m, best.zeta1, best.zeta2, "distinct states M", "No state is new any more (best)"),
    ]
    chart: Chart = alt.hconcat(*panels, spacing=28).properties(
        title=alt.TitleParams(
            "Memory of SARSA over that of dual memory",
            subtitle=f"|A| = {actions}, κ = {staged_ratio:g}, T = {stage_period}; "
            "above the grey line dual memory is the smaller",
        )
    )
    return chart


def _points(last: int) -> np.ndarray:
    """Return whole numbers from 1 to the last one, no more than a line can show."""
    return np.unique(np.linspace(1, max(last, 2), min(max(last, 2), 400)).astype(np.int64))


def _panel(
    x: np.ndarray, zeta1: np.ndarray, zeta2: np.ndarray, x_title: str, title: str
) -> alt.LayerChart | alt.FacetChart:
    parts = [
        pl.DataFrame({"x": x, "ratio": ratio}).with_columns(line=pl.lit(name))
        for name, ratio in ((AFTER, zeta1), (BEFORE, zeta2))
    ]
    lines = (
        alt.Chart(values(pl.concat(parts)))
        .mark_line(strokeWidth=1.8)
        .encode(
            x=alt.X("x:Q", title=x_title, axis=alt.Axis(grid=False, tickMinStep=1)),
            y=alt.Y("ratio:Q", title="ζ", scale=alt.Scale(zero=True)),
            color=alt.Color(
                "line:N",
                scale=alt.Scale(domain=list(_COLOURS), range=list(_COLOURS.values())),
                legend=alt.Legend(
                    title=None, orient="bottom", symbolType="stroke", symbolStrokeWidth=2
                ),
            ),
            tooltip=[
                alt.Tooltip("line:N", title="ratio"),
                alt.Tooltip("x:Q", title=x_title),
                alt.Tooltip("ratio:Q", title="ζ", format=".3f"),
            ],
        )
    )
    one = alt.Chart(alt.InlineData(values=[{"y": 1}])).mark_rule(color=FAINT).encode(y=alt.Y("y:Q"))
    return alt.layer(one, lines, width=_WIDTH, height=_HEIGHT, title=title)
