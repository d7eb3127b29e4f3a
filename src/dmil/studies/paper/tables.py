"""All tables of one study, computed once for page, figures and command line."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product

import polars as pl

from dmil.analysis.estimates import as_column, seed_means
from dmil.results import Results
from dmil.studies.paper.cells import Cells, cells_of
from dmil.studies.paper.claims import claims
from dmil.studies.paper.published import (
    COMPLEX,
    COMPLEX_COMMUNICATION,
    COMPLEX_READINGS,
    NO_MEMORY,
    PAPER_COLUMNS,
    intersections_of,
)
from dmil.studies.paper.questions import WAIT_UNDIVIDED
from dmil.studies.paper.summaries import (
    as_cells,
    beside_the_paper,
    compared,
    named_rows,
    paper_table,
    sensitivity,
    summary,
)

NARROW = 0.05
"""A ± of the paper below this is a measure; some of its cells have .1, within which most lie."""
PAPER_RULE = "communication=true"
"""The variant that is the paper's own: long-term memories, every T seconds."""
_STORED = {
    "first_long": "first_long_entries",
    "long": "long_entries",
    "entries": "entries_per_agent",
    "long_slope": "long_entries_per_decision",
    "short_slope": "short_entries_per_decision",
    "shared": "entries_total",
}
"""Columns of `memory_table`, and which measure each is the mean of."""
_KEYS = ("preset", "scenario", "reward", "variant")
_MEANS = {
    "horizon_s": "horizon_s",
    "entries": "entries_per_agent",
    "entries_total": "entries_total",
    "messages": "messages",
    "exchanged_bytes": "exchanged_bytes",
}
"""The same of `exchange_table`."""


@dataclass(frozen=True, slots=True)
class PaperTables:
    """What is known about a study: its cells, seed by seed, and tables.

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
    both = (COMPLEX, COMPLEX_COMMUNICATION)
    rows = list(product(cells.presets, cells.scenarios, cells.rewards, both, readings))
    numbers = [_complex_cell(cells, *row) for row in rows]
    first = [_complex_cell(cells, *row[:4], cells.reading.complex_embedding) for row in rows]
    table = named_rows(rows, "preset", "scenario", "reward", "column", "reading")
    return beside_the_paper(compared(cells, table, numbers, first, "vs_first_reading", "readings"))


def cells_reproduced(table: pl.DataFrame, readings: pl.DataFrame) -> pl.DataFrame:
    """Count the cells of the paper's Table II that a study's means reproduce within its ± (ours).

    Parameters
    ----------
    table, readings
        What `paper_table` and `complex_readings` returned.

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
    known = readings.filter(pl.col("within").is_not_null())
    return (
        pl.concat([known.select(both), others.select(both)])
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


def memory_table(results: Results | Cells) -> pl.DataFrame:
    """Return what the agents of the paper's columns and exact SARSA store (paper, §VI-C; ours).

    Returns
    -------
    One row per preset, scenario, reward and ``agent``, means over seeds and agents: ``first_long``
    and ``long``, m_L (m_Q for SARSA) at the start and at the horizon; ``entries``, m_s + m_L at the
    horizon; ``long_slope`` and ``short_slope``, entries added per decision by least squares, those
    of short-term memory apart, because it fills once and then stays below its capacity; ``shared``,
    the entries of all agents together, what all share counted once; ``per_agent_total``, the same
    with every agent's own copy counted.
    """
    cells = as_cells(results)
    rows: list[tuple[str, str, str, str]] = []
    numbers: list[int | None] = []
    for preset in cells.presets:
        agents = {"SARSA exact": cells.reading.exact_sarsa} | {
            column: cells.reading.architecture(column, preset) for column in PAPER_COLUMNS
        }
        # Under most presets "No Memory" is exact SARSA: one row is enough.
        if agents[NO_MEMORY] == agents["SARSA exact"]:
            del agents[NO_MEMORY]
        places = list(product([preset], cells.scenarios, cells.rewards, agents))
        rows += places
        numbers += [cells.find(*place[:3], agents[place[3]]) for place in places]
    columns = {
        name: as_column(seed_means(cells.columns(measure, numbers)))
        for name, measure in _STORED.items()
    }
    counts = [intersections_of(row[1]) for row in rows]
    return (
        named_rows(rows, "preset", "scenario", "reward", "agent")
        .with_columns(**columns)
        .with_columns(
            per_agent_total=pl.col("entries") * pl.Series(counts, dtype=pl.Int64, strict=False)
        )
        .filter(pl.col("long").is_not_null())
    )


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
    others = ~pl.col("variant").str.starts_with("communication=")
    found = found.drop("sd").with_columns(**means)
    return found.sort("preset", "scenario", "reward", others, "variant")
