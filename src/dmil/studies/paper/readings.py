"""The readings of the complex classes beside each other, and how much of Table II each gives."""

from __future__ import annotations

from dataclasses import replace

import polars as pl

from dmil.results import Results
from dmil.studies.paper.cells import Cells
from dmil.studies.paper.published import COMPLEX, COMPLEX_COMMUNICATION, COMPLEX_READINGS
from dmil.studies.paper.summaries import as_cells, beside_the_paper, compared, named_rows

NARROW = 0.05
"""A ± of the paper below this is a measure; some of its cells have .1, within which most lie."""


def complex_readings(results: Results | Cells) -> pl.DataFrame:
    """Return the paper's Complex columns under every reading of the complex classes (ours).

    Returns
    -------
    One row per preset, scenario, reward, column and reading: ``paper_mean``, ``paper_spread``,
    ``mean``, ``sd``, ``low``, ``high``, ``n``, ``within`` (whether the mean is within the paper's
    ±, null where it has no entry), and the paired relative difference to the study's first reading
    in %, with its interval. Readings that were not run are left out.
    """
    cells = as_cells(results)
    readings = [name for name in COMPLEX_READINGS if name in cells.table["embedding"]]
    rows = [
        (preset, scenario, reward, column, reading)
        for preset in cells.presets
        for scenario in cells.scenarios
        for reward in cells.rewards
        for column in (COMPLEX, COMPLEX_COMMUNICATION)
        for reading in readings
    ]
    numbers = [_complex_cell(cells, *row) for row in rows]
    first = [_complex_cell(cells, *row[:4], cells.reading.complex_embedding) for row in rows]
    table = named_rows(rows, "preset", "scenario", "reward", "column", "reading")
    return beside_the_paper(compared(cells, table, numbers, first, "vs_first_reading", "readings"))


def cells_reproduced(table: pl.DataFrame, readings: pl.DataFrame) -> pl.DataFrame:
    """Count the cells of the paper's Table II that a study's means reproduce within its ± (ours).

    Parameters
    ----------
    table
        What `paper_table` returned.
    readings
        What `complex_readings` returned.

    Returns
    -------
    One row per preset and reading of the complex classes: ``within`` of ``cells`` of the whole
    table; ``narrow_within`` of ``narrow_cells`` of those whose ± is below `NARROW`; and
    ``complex_within`` of ``complex_cells`` of its Complex columns, in which the readings differ.
    """
    keys = ["preset", "reading"]
    others = table.filter(
        pl.col("within").is_not_null(), ~pl.col("column").str.starts_with(COMPLEX)
    ).join(readings.select(keys).unique(maintain_order=True), on="preset", maintain_order="right")
    narrow = pl.col("paper_spread") < NARROW
    ours = pl.col("column").str.starts_with(COMPLEX)
    both = (*keys, "column", "paper_spread", "within")
    return (
        pl.concat(
            [readings.filter(pl.col("within").is_not_null()).select(both), others.select(both)]
        )
        .group_by(keys, maintain_order=True)
        .agg(
            within=pl.col("within").sum(),
            cells=pl.len(),
            narrow_within=(pl.col("within") & narrow).sum(),
            narrow_cells=narrow.sum(),
            complex_within=(pl.col("within") & ours).sum(),
            complex_cells=ours.sum(),
        )
    )


def _complex_cell(
    cells: Cells, preset: str, scenario: str, reward: str, column: str, reading: str
) -> int | None:
    chosen = replace(cells.reading, complex_embedding=reading)
    return cells.find(preset, scenario, reward, chosen.architecture(column, preset))
