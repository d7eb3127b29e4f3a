"""What the agents of the paper's columns store, as the paper counts it and as we do."""

from __future__ import annotations

import polars as pl

from dmil.analysis.estimates import as_column, seed_means
from dmil.results import Results
from dmil.studies.paper.cells import Cells
from dmil.studies.paper.published import NO_MEMORY, PAPER_COLUMNS, intersections_of
from dmil.studies.paper.summaries import as_cells, named_rows


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
        for scenario in cells.scenarios:
            for reward in cells.rewards:
                rows += [(preset, scenario, reward, agent) for agent in agents]
                numbers += [cells.find(preset, scenario, reward, agents[agent]) for agent in agents]
    columns = {
        name: as_column(seed_means(cells.columns(measure, numbers)))
        for name, measure in (
            ("first_long", "first_long_entries"),
            ("long", "long_entries"),
            ("entries", "entries_per_agent"),
            ("long_slope", "long_entries_per_decision"),
            ("short_slope", "short_entries_per_decision"),
            ("shared", "entries_total"),
        )
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
