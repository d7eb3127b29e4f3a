"""All tables of one study, computed once for page, figures and command line."""

from __future__ import annotations

from dataclasses import dataclass

import polars as pl

from dmil.results import Results
from dmil.studies.paper.cells import Cells, cells_of
from dmil.studies.paper.claims import claims
from dmil.studies.paper.exchange import exchange_table
from dmil.studies.paper.memory_use import memory_table
from dmil.studies.paper.readings import cells_reproduced, complex_readings
from dmil.studies.paper.summaries import paper_table, sensitivity, summary


@dataclass(frozen=True, slots=True)
class PaperTables:
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


def paper_tables(results: Results) -> PaperTables:
    """Compute all tables of a study (ours).

    Raises
    ------
    InputError
        No run succeeded.
    """
    cells = cells_of(results)
    paper, readings = paper_table(cells), complex_readings(cells)
    return PaperTables(
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
