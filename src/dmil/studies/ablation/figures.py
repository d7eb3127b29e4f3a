"""The figure of an ablation: what every part changes, on every network."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import altair as alt
import polars as pl

from dmil.reports.export import Figure, drawn_figures
from dmil.reports.labels import short_label
from dmil.reports.marks import Chart, coloured, dots, heading, panels_across, values, vertical_at
from dmil.studies.ablation.names import cell_label
from dmil.studies.ablation.tables import AblationTables

WIDEST_PCT = 40.0
"""Differences beyond this are drawn at the edge: what ruins a controller would hide the rest."""
_COLOURS = (
    *("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#7CB518", "#8250C4"),
    *("#8A6D3B", "#1F3B73"),
)


def figures_of_study(tables: AblationTables) -> Iterator[Figure]:
    """Yield the figure (ours)."""
    runs = tables.runs
    caption = (
        "Paired difference in delay from the controller as it is, in %: interquartile mean over "
        "seeds and its 95 % interval, locked runs left out; right of the line is worse. Beyond "
        f"±{WIDEST_PCT:g} % at the edge."
    )
    chart = forest(tables.differences, runs.cells, runs.controllers, runs.changes)
    yield from drawn_figures([("parts", "parts", caption, chart)])


def forest(
    differences: pl.DataFrame,
    cells: Sequence[str],
    controllers: Sequence[str],
    changes: Sequence[str],
) -> Chart | None:
    """Draw what every part changes: parts down, controllers across, a colour for each network."""
    known = differences.filter(pl.col("pct").is_not_null())
    if known.is_empty():
        return None
    places = [cell_label(cell) for cell in cells]
    names = [short_label(name) for name in controllers]
    data = known.select(
        "change",
        n="free",
        name=pl.col("controller").replace(dict(zip(controllers, names, strict=True))),
        where=pl.col("cell").replace(dict(zip(cells, places, strict=True))),
        **{
            end: pl.col(column).clip(-WIDEST_PCT, WIDEST_PCT)
            for end, column in (("mean", "pct"), ("low", "pct_low"), ("high", "pct_high"))
        },
    )
    colours = [_COLOURS[number % len(_COLOURS)] for number in range(len(places))]
    legend = alt.Legend(title=None, orient="bottom", columns=4)
    layers = dots(
        alt.Y("change:N", title=None, sort=list(changes), axis=alt.Axis(grid=True, labelLimit=260)),
        coloured("where", places, colours, legend),
        "difference in delay (%)",
        alt.YOffset("where:N", sort=places),
        "+.1f",
    )
    chart: Chart = (
        alt.layer(vertical_at(0.0), *layers, data=values(data))
        .properties(width=190, height=alt.Step(5, **{"for": "offset"}))
        .facet(column=panels_across("name", names))
        .properties(
            title=heading(
                "What each part of a controller is worth",
                "difference from the controller as it is, on the same vehicles; right is worse",
            )
        )
    )
    return chart
