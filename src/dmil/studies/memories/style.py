"""Colours, dashes and names of the controllers in the study of memories."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TypeVar

import altair as alt
import polars as pl

from dmil.controllers.variants import parse_variant
from dmil.reports.styles import colour, dash
from dmil.reports.theme import INK
from dmil.studies.memories.names import cell_label, controller_name

Axis = TypeVar("Axis", alt.X, alt.Y)

_TICKS = (
    (1.0,),
    (1.0, 2.0, 5.0),
    (1.0, 1.5, 2.0, 3.0, 5.0, 7.0),
    tuple(i / 20 for i in range(20, 200)),
)
_FEWEST_TICKS = 4


def ticks(low: float, high: float) -> list[float]:
    """Return the values to label on a logarithmic axis: round, and not too many (ours)."""
    found: list[float] = []
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    for steps in _TICKS:
        found = [
            value
            for decade in decades
            for value in (float(f"{step}e{decade}") for step in steps)
            if low <= value <= high
        ]
        if len(found) >= _FEWEST_TICKS:
            break
    return found


def tick_format(low: float) -> str:
    """Return how ticks from ``low`` on are written: thousands as 1k, parts of 1 as they are."""
    return "~s" if low >= 1 else "~g"


def log_field(field: str, title: str, low: float, high: float, kind: type[Axis]) -> Axis:
    """Return a logarithmic axis from ``low`` to ``high`` with few, round labels (ours)."""
    return kind(
        field,
        title=title,
        scale=alt.Scale(type="log", domain=[low, high], nice=False),
        axis=alt.Axis(values=ticks(low, high), format=tick_format(low), grid=True, ticks=False),
    )


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
