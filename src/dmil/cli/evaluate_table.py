"""The table of a comparison: a column per controller, a row per measure, and the differences."""

from __future__ import annotations

import re
import textwrap

import numpy as np
from rich import box
from rich.table import Table
from rich.text import Text

from dmil.cli.measures import Measure, number
from dmil.statistics import Estimate
from dmil.studies.comparison import Comparison

DIFFERENCES = (
    "travel_time_s",
    "delay_s",
    "wait_per_spawned_s",
    "stops_per_spawned",
    "co2_g",
)
"""Measures whose differences to the reference are shown: of these, less is better."""
SHOWN = (
    Measure("travel_time_s", "travel time", "s", 1),
    Measure("delay_s", "delay", "s", 1),
    Measure("wait_per_spawned_s", "W, waiting", "s", 1),
    Measure("stops_per_spawned", "stops", "per vehicle", 2),
    Measure("co2_g", "CO2", "kg, all vehicles", 1, True, 1e-3),
    Measure("throughput_veh_per_h", "throughput", "veh/h", 0),
    Measure("mean_queue_veh", "mean queue", "veh", 1),
    Measure("overruled", "overruled", "phase requests", 0, True),
    Measure("entries_per_agent", "memory entries", "per intersection", 1, True),
    Measure("bytes_per_intersection", "memory bytes", "per intersection", 0, True),
)
LABEL_WIDTH, COLUMN_WIDTH = 16, 15


def comparison_table(found: Comparison, columns: range) -> Table:
    """Return means, intervals and differences to the reference (ours).

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
        parts = re.split("(?<=:)", found.labels[i])
        head = "\n".join(line for part in parts for line in textwrap.wrap(part, COLUMN_WIDTH))
        table.add_column(head, width=COLUMN_WIDTH, justify="right", overflow="fold")
    reference = "\n".join(textwrap.wrap(f"− {found.reference}", LABEL_WIDTH))
    for measure in SHOWN:
        values = found.measures[measure.name]
        if measure.optional and not np.nan_to_num(values).any():
            continue
        mean = found.mean(measure.name)
        # What a frozen policy remembers is not a matter of chance.
        fixed = measure.optional and bool((values == values[0]).all())
        cells = (_cell(mean, i, measure, plain=fixed) for i in columns)
        table.add_row(_label(measure), *cells)
        difference = found.difference(measure.name) if measure.name in DIFFERENCES else None
        if difference is not None:
            cells = (
                _cell(difference, i, measure, "+") if found.labels[i] != found.reference else ""
                for i in columns
            )
            table.add_row(Text(reference, "dim"), *cells)
    return table


def _label(measure: Measure) -> Text:
    return Text.assemble(measure.label, "\n", (measure.unit, "dim"))


def _cell(
    estimate: Estimate, i: int, measure: Measure, sign: str = "", *, plain: bool = False
) -> str:
    """Return a mean, and its interval on a second line unless that is not wanted."""
    value, low, high = (
        float(each[i]) * measure.factor for each in (estimate.value, estimate.low, estimate.high)
    )
    if value == low == high == 0 and not sign:
        return "0"
    digits = measure.digits
    mean = number(value, digits, sign)
    return (
        mean if low != low or plain else f"{mean}\n[{number(low, digits)}, {number(high, digits)}]"
    )
