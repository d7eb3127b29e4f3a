"""Variants of what agents exchange: their effect on waiting, memory and messages."""

from __future__ import annotations

from dataclasses import replace

import polars as pl

from dmil.analysis.cells import Cells
from dmil.analysis.paper import COMPLEX, COMPLEX_COMMUNICATION, is_of
from dmil.analysis.tables import (
    HEADLINE,
    as_cells,
    headline_estimates,
    percent_columns,
    seed_means,
    series_of,
)
from dmil.results import Results
from dmil.seeding import stream
from dmil.statistics import paired_difference

_KEYS = ("preset", "scenario", "reward", "communication", "variant")
_MEANS = {
    "entries": "entries_per_agent",
    "entries_total": "entries_total",
    "messages": "messages",
    "exchanged_bytes": "exchanged_bytes",
}


def exchange_table(results: Results | Cells) -> pl.DataFrame:
    """Return every variant of the communication beside the paper's rule and beside none (ours).

    Returns
    -------
    One row per variant, in front of them those without communication and with the paper's rule:
    ``preset``, ``scenario``, ``reward``, ``communication``, ``variant`` (null for the paper's own);
    W/V_c as ``mean``, ``sd``, ``low``, ``high``, ``n``; its paired relative difference in % to the
    paper's rule, with its interval; means over seeds of ``entries`` per agent, ``entries_total``
    (what all share counted once), ``messages`` and ``exchanged_bytes``. Empty without variants.
    """
    cells = as_cells(results)
    varied = cells.table.filter(pl.col("variant").is_not_null())
    rows: list[list[object]] = []
    numbers: list[int] = []
    partners: list[int | None] = []
    for preset, scenario, reward in varied.select(_KEYS[:3]).unique(maintain_order=True).rows():
        own = [
            cells.reading.architecture(column, preset)
            for column in (COMPLEX, COMPLEX_COMMUNICATION)
        ]
        chosen = [cells.find(preset, scenario, reward, each) for each in own]
        chosen += [
            number
            for number, row in enumerate(cells.table.iter_rows(named=True))
            if row["variant"]
            and (row["preset"], row["scenario"], row["reward"]) == (preset, scenario, reward)
            and any(is_of(replace(each, variant=row["variant"]), row) for each in own)
        ]
        for number in chosen:
            if number is not None:
                row = cells.table.row(number, named=True)
                rows.append([row[name] for name in _KEYS])
                numbers.append(number)
                partners.append(chosen[1])
    table = pl.DataFrame(
        rows, schema={name: cells.table.schema[name] for name in _KEYS}, orient="row"
    )
    if not rows:
        return table
    difference = paired_difference(
        cells.columns(HEADLINE, numbers),
        cells.columns(HEADLINE, partners),
        stream(0, "bootstrap", "exchange"),
        relative=True,
    )
    table = pl.concat([table, headline_estimates(cells, numbers, "exchange")], how="horizontal")
    return table.with_columns(
        **percent_columns("vs_rule", difference),
        **{
            name: series_of(seed_means(cells.columns(measure, numbers)))
            for name, measure in _MEANS.items()
        },
    )
