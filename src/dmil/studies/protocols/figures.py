"""The figure of the study of protocols."""

from __future__ import annotations

from collections.abc import Iterator

import altair as alt
import polars as pl

from dmil.reports.contenders import controller_name
from dmil.reports.export import Figure, drawn_figures
from dmil.reports.marks import Chart, heading, values
from dmil.studies.protocols.tables import ProtocolsTables


def figures_of_study(tables: ProtocolsTables) -> Iterator[Figure]:
    """Yield the figures that the runs allow (ours)."""
    caption = (
        "Every method under every protocol, in the simulator and by the measure of the protocol: "
        "only points of one row compare."
    )
    yield from drawn_figures([("recipes", "headline", caption, recipes_chart(tables.ours))])


def recipes_chart(ours: pl.DataFrame) -> Chart | None:
    """Draw the figures of all methods by protocol, a panel for each city."""
    data = ours.filter(pl.col("same_recipe")).with_columns(
        value=pl.coalesce("mean_s", "recorded_s"),
        method=pl.col("controller").map_elements(controller_name, return_dtype=pl.String),
    )
    if data.is_empty():
        return None
    chart: Chart = (
        alt.Chart(values(data.select("preset", "scenario", "method", "value")))
        .mark_point(filled=True, size=45)
        .encode(
            x=alt.X("value:Q", title="s per vehicle", scale=alt.Scale(zero=False)),
            y=alt.Y("preset:N", title=None),
            color=alt.Color("method:N", legend=alt.Legend(title=None, orient="bottom", columns=2)),
            row=alt.Row("scenario:N", title=None),
        )
        .properties(
            width=420,
            height=alt.Step(18),
            title=heading(
                "Methods under their protocols", "mean over resampled days, else the recorded day"
            ),
        )
    )
    return chart
