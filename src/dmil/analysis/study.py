"""All tables of one study, computed once for page, figures and command line."""

from __future__ import annotations

from dataclasses import dataclass

import polars as pl

from dmil.analysis.cells import Cells, cells_of
from dmil.analysis.claims import claims
from dmil.analysis.exchange import exchange_table
from dmil.analysis.memory_use import memory_table
from dmil.analysis.readings import cells_reproduced, complex_readings
from dmil.analysis.tables import paper_table, sensitivity, summary
from dmil.results import Results


@dataclass(frozen=True, slots=True)
class Tables:
    """What is known about a study.

    Attributes
    ----------
    cells: Cells
        Its cells, seed by seed.
    summary, paper, sensitivity, readings, reproduced, memory, exchange, claims: polars.DataFrame
        See the functions `summary`, `paper_table`, `sensitivity`, `complex_readings`,
        `cells_reproduced`, `memory_table`, `exchange_table` and `claims`.
    """

    cells: Cells
    summary: pl.DataFrame
    paper: pl.DataFrame
    sensitivity: pl.DataFrame
    readings: pl.DataFrame
    reproduced: pl.DataFrame
    memory: pl.DataFrame
    exchange: pl.DataFrame
    claims: pl.DataFrame


def tables_of(results: Results) -> Tables:
    """Compute all tables of a study (ours).

    Raises
    ------
    InputError
        No run succeeded.
    """
    cells = cells_of(results)
    paper, readings = paper_table(cells), complex_readings(cells)
    return Tables(
        cells=cells,
        summary=summary(cells),
        paper=paper,
        sensitivity=sensitivity(cells),
        readings=readings,
        reproduced=cells_reproduced(paper, readings),
        memory=memory_table(cells),
        exchange=exchange_table(cells),
        claims=claims(cells),
    )
