"""All tables of one study, computed once for page, figures and command line."""

from __future__ import annotations

from dataclasses import dataclass

import polars as pl

from dmil.analysis.cells import Cells, cells_of
from dmil.analysis.claims import claims
from dmil.analysis.tables import paper_table, sensitivity, summary
from dmil.results import Results


@dataclass(frozen=True, slots=True)
class Tables:
    """What is known about a study.

    Attributes
    ----------
    cells: Cells
        Its cells, seed by seed.
    summary, paper, sensitivity, claims: polars.DataFrame
        See the functions of these names.
    """

    cells: Cells
    summary: pl.DataFrame
    paper: pl.DataFrame
    sensitivity: pl.DataFrame
    claims: pl.DataFrame


def tables_of(results: Results) -> Tables:
    """Compute all tables of a study (ours).

    Raises
    ------
    InputError
        No run succeeded.
    """
    cells = cells_of(results)
    return Tables(cells, summary(cells), paper_table(cells), sensitivity(cells), claims(cells))
