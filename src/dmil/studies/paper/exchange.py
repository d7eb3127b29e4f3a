"""Variants of what agents exchange: their effect on waiting, memory and messages."""

from __future__ import annotations

import polars as pl

from dmil.analysis.estimates import as_column, seed_means
from dmil.results import Results
from dmil.studies.paper.cells import Cells
from dmil.studies.paper.selections import WAIT_UNDIVIDED
from dmil.studies.paper.summaries import as_cells, compared, named_rows

PAPER_RULE = "communication=true"
"""The variant that is the paper's own: long-term memories, every T seconds."""

_KEYS = ("preset", "scenario", "reward", "variant")
_MEANS = {
    "horizon_s": "horizon_s",
    "entries": "entries_per_agent",
    "entries_total": "entries_total",
    "messages": "messages",
    "exchanged_bytes": "exchanged_bytes",
}


def exchange_table(results: Results | Cells) -> pl.DataFrame:
    """Return every variant of what agents exchange beside the paper's own rule (ours).

    Returns
    -------
    One row per variant: ``preset``, ``scenario``, ``reward``, ``variant``, ``horizon_s``; W in s as
    ``mean``, ``low``, ``high``, ``n``; its paired relative difference in % to the paper's rule
    (``communication=true``), with its interval; means over seeds of ``entries`` per agent,
    ``entries_total`` (what all share counted once), ``messages`` and ``exchanged_bytes``. Empty
    without variants.
    """
    cells = as_cells(results)
    rows = [
        (number, *(row[name] for name in _KEYS))
        for number, row in enumerate(cells.table.iter_rows(named=True))
        if row["variant"] is not None
    ]
    known = {row[1:]: row[0] for row in rows}
    numbers = [row[0] for row in rows]
    partners = [known.get((*row[1:-1], PAPER_RULE)) for row in rows]
    table = named_rows([row[1:] for row in rows], *_KEYS)
    if not rows:
        return table
    found = compared(cells, table, numbers, partners, "vs_rule", "exchange", WAIT_UNDIVIDED)
    means = {
        name: as_column(seed_means(cells.columns(measure, numbers)))
        for name, measure in _MEANS.items()
    }
    return (
        found.drop("sd")
        .with_columns(**means)
        .sort(
            "preset",
            "scenario",
            "reward",
            ~pl.col("variant").str.starts_with("communication="),
            "variant",
        )
    )
