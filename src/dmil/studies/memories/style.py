"""Colours, dashes and names of the controllers in the study of memories."""

from __future__ import annotations

from collections.abc import Sequence

import altair as alt
import polars as pl

from dmil.controllers.variants import parse_variant
from dmil.reports.styles import colour, dash
from dmil.reports.theme import INK
from dmil.studies.memories.names import cell_label, controller_name


def vertical_at(x: float) -> alt.Chart:
    """Return a vertical line, drawn once and not for every row of a figure's data (ours)."""
    line: alt.Chart = (
        alt.Chart(alt.InlineData(values=[{}]))
        .mark_rule(color=INK, strokeWidth=1.2)
        .encode(x=alt.datum(x))
    )
    return line


def colour_of(label: str) -> str:
    """Return the colour of a controller with its options."""
    variant = parse_variant(label)
    return colour(variant.name, [*variant.options, *map(str, variant.options.values())])


def palette(labels: Sequence[str]) -> dict[str, str]:
    """Return the colour of each shown name (ours)."""
    return {controller_name(label): colour_of(label) for label in labels}


def dashes(labels: Sequence[str]) -> dict[str, list[int]]:
    """Return the dash of each shown name: those with options are dotted (ours)."""
    found = {}
    for label in labels:
        name, _, options = label.partition(",")
        dotted = bool(options) and options != "epsilon=0.05"
        found[controller_name(label)] = [2, 2] if dotted else dash(name)
    return found


def named(table: pl.DataFrame) -> pl.DataFrame:
    """Return a table with ``name`` of the controller and, if it has cells, ``where`` (ours)."""
    names = pl.Series([controller_name(each) for each in table["controller"]], dtype=pl.String)
    table = table.with_columns(name=names)
    if "cell" not in table.columns:
        return table
    cells = [None if each is None else cell_label(each) for each in table["cell"]]
    return table.with_columns(where=pl.Series(cells, dtype=pl.String))
