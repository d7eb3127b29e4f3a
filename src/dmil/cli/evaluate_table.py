"""The table of a comparison: a column per controller, a row per measure, and the differences."""

from __future__ import annotations

import re
import textwrap

import numpy as np
from rich import box
from rich.table import Table
from rich.text import Text

from dmil.cli.measures import number
from dmil.experiments.comparison import Comparison
from dmil.results.metrics import COMPARED, COMPARISON_TABLE, METRICS, Metric
from dmil.statistics import Estimate

LABEL_WIDTH, COLUMN_WIDTH = 16, 20
SPREAD = "median IQM worst"
"""Label of how a measure varies over seeds: median, interquartile mean, worst seed."""


def ranking_table(found: Comparison, name: str) -> Table:
    """Return one metric of all contenders: how it varies over seeds, and the differences.

    Parameters
    ----------
    found
        The comparison, ranked.
    name
        Which metric.
    """
    metric = METRICS[name]
    several = len(found.seeds) > 1 and not found.one_day
    mean, spread = found.mean(name), found.spread(name)
    difference = found.difference(name)
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, padding=(0, 1, 0, 0), pad_edge=False)
    table.add_column(", ".join(metric.short_label), width=COLUMN_WIDTH, overflow="fold")
    heads = ["mean", "median", "IQM", "worst"] if several else ["mean"]
    if difference is not None:
        heads.append(f"− {found.reference}")
    for head in heads:
        wide = COLUMN_WIDTH if head.startswith("−") else 0
        table.add_column("\n".join(_name_lines(head)), justify="right", min_width=wide)
    for i, label in enumerate(found.labels):
        cells = [_cell(mean, i, metric, plain=True)]
        if several:
            cells += [number(float(each[i]), metric.digits) for each in spread.values()]
        if difference is not None:
            same = label == found.reference
            cells.append("" if same else _cell(difference, i, metric, "+", apart=" "))
        table.add_row("\n".join(_name_lines(label)), *cells)
    return table


def _name_lines(label: str) -> list[str]:
    """Break a contender's name where its options begin, and between words where it is longer."""
    parts = re.split("(?<=[:,])", label)
    return [line for part in parts for line in textwrap.wrap(part, COLUMN_WIDTH)]


def comparison_table(found: Comparison, columns: range) -> Table:
    """Return means, intervals, how they vary over seeds, and differences to the reference.

    Parameters
    ----------
    found
        The comparison.
    columns
        Which of its contenders, as many as the terminal has room for.
    """
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, padding=0)
    table.add_column("", width=LABEL_WIDTH, no_wrap=True)
    for i in columns:
        head = "\n".join(_name_lines(found.labels[i]))
        table.add_column(head, width=COLUMN_WIDTH, justify="right", overflow="fold")
    several = len(found.seeds) > 1 and not found.one_day
    reference = "\n".join(textwrap.wrap(f"− {found.reference}", LABEL_WIDTH))
    for name in COMPARISON_TABLE:
        metric, values = METRICS[name], found.measures[name]
        if metric.optional and not np.nan_to_num(values).any():
            continue
        mean = found.mean(name)
        # What a frozen policy remembers is not a matter of chance.
        fixed = metric.optional and bool((values == values[0]).all())
        cells = (_cell(mean, i, metric, plain=fixed) for i in columns)
        table.add_row(_label(metric), *cells)
        if several and not fixed:
            spread = list(found.spread(name).values())
            cells = (
                " ".join(number(float(each[i]) * metric.factor, metric.digits) for each in spread)
                for i in columns
            )
            table.add_row(Text(SPREAD, "dim"), *cells)
        difference = found.difference(name) if name in COMPARED else None
        if difference is not None:
            cells = (
                _cell(difference, i, metric, "+") if found.labels[i] != found.reference else ""
                for i in columns
            )
            table.add_row(Text(reference, "dim"), *cells)
    return table


def _label(metric: Metric) -> Text:
    label, unit = metric.short_label
    return Text.assemble(label, "\n", (unit, "dim"))


def _cell(
    estimate: Estimate,
    i: int,
    metric: Metric,
    sign: str = "",
    *,
    plain: bool = False,
    apart: str = "\n",
) -> str:
    """Return a mean, and its interval on a second line unless that is not wanted."""
    value, low, high = (
        float(each[i]) * metric.factor for each in (estimate.value, estimate.low, estimate.high)
    )
    if value == 0 and not sign and (low == high == 0 or low != low):
        return "0"
    digits = metric.digits
    mean = number(value, digits, sign)
    return (
        mean
        if low != low or plain
        else f"{mean}{apart}[{number(low, digits)}, {number(high, digits)}]"
    )
