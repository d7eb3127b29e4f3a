"""Summary tables of a study: every cell, the paper's table beside ours, presets, curves."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np
import polars as pl

from dmil.analysis.estimates import (
    CURVE_RESAMPLES,
    as_column,
    interval_columns,
    percent_columns,
    seed_means,
)
from dmil.analysis.panel import ordered
from dmil.results import Results
from dmil.seeding import stream
from dmil.statistics import mean_interval, paired_difference, standard_deviation
from dmil.studies.paper.cells import (
    BASELINES,
    CELL,
    ENTRIES,
    LEARNERS,
    LONG_ENTRIES,
    Cells,
    arrange,
    cells_of,
)
from dmil.studies.paper.published import PAPER_COLUMNS, PAPER_REWARDS, TABLE_II

HEADLINE = "w_over_vc"
_MEANS = {
    "vc_mean": "arrived_veh",
    "wait_mean_s": "wait_per_spawned_s",
    "queue_mean_veh": "mean_queue_veh",
    "travel_time_mean_s": "travel_time_s",
    "throughput_mean_veh_per_h": "throughput_veh_per_h",
    "entries_mean": "entries_per_agent",
    "msize_mean": "msize_per_agent",
    "bytes_mean": "bytes_total",
}


def summary(results: Results | Cells) -> pl.DataFrame:
    """Return one row per cell of the study, but for variants: see `exchange_table` (ours).

    Returns
    -------
    Columns of :attr:`Cells.named`; ``n`` seeds; mean, sd and 95 % interval of W/V_c; means of V_c,
    W, queue, travel time, throughput, stored entries and bytes; the paired relative difference of
    W/V_c to max-pressure and to longest-queue-first in % with its interval (below 0: waits less).
    """
    cells = as_cells(results)
    rows = list(cells.table.iter_rows(named=True))
    numbers = list(range(len(rows)))
    found = estimates(cells, numbers, "summary")
    columns = {"n": found["n"]} | {
        f"w_over_vc_{name}": found[name] for name in ("mean", "sd", "low", "high")
    }
    for name, measure in _MEANS.items():
        columns[name] = as_column(seed_means(cells.measures[measure]))
    for name, baseline in (
        ("vs_max_pressure", "max-pressure"),
        ("vs_longest_queue", "longest-queue-first"),
    ):
        partners = [cells.baseline(row["preset"], row["scenario"], baseline) for row in rows]
        columns |= differences(cells, numbers, partners, name, "summary", baseline)
    return cells.named.with_columns(**columns).filter(pl.col("variant").is_null())


def paper_table(results: Results | Cells) -> pl.DataFrame:
    """Return the paper's Table II beside ours, long (ours).

    Returns
    -------
    One row per preset, scenario, reward and column: ``paper_mean``, ``paper_spread`` (null where
    the paper has no entry), ``mean``, ``sd``, ``low``, ``high``, ``n`` of ours (null where it was
    not run), ``within`` (whether our mean lies within the paper's ±). The baselines
    are columns too; they have no reward and no paper value. Rows where both are missing are left
    out.
    """
    cells = as_cells(results)
    rewards = ordered(cells.rewards or PAPER_REWARDS, PAPER_REWARDS)
    rows: list[tuple[str, str, str | None, str, int | None]] = []
    for place in product(cells.presets, cells.scenarios):
        for entry in product(rewards, PAPER_COLUMNS):
            rows.append((*place, *entry, cells.of_column(*place, *entry)))
        for baseline in BASELINES:
            rows.append((*place, None, baseline, cells.baseline(*place, baseline)))
    table = named_rows([row[:4] for row in rows], "preset", "scenario", "reward", "column")
    ours = estimates(cells, [row[4] for row in rows], "paper-table")
    joined = beside_the_paper(pl.concat([table, ours], how="horizontal"))
    return joined.filter(pl.col("mean").is_not_null() | pl.col("paper_mean").is_not_null())


def sensitivity(results: Results | Cells) -> pl.DataFrame:
    """Return how W/V_c of the paper's columns depends on the preset (ours).

    Returns
    -------
    One row per scenario, reward, column and preset: ``mean``, ``sd``, ``low``, ``high``, ``n``,
    and the paired relative difference to the study's first preset in %, with its interval.
    """
    cells = as_cells(results)
    rows = list(product(cells.scenarios, cells.rewards, PAPER_COLUMNS, cells.presets))
    numbers = [cells.of_column(preset, *row) for *row, preset in rows]
    first = [cells.of_column(cells.presets[0], *row) for *row, _ in rows]
    table = named_rows(rows, "scenario", "reward", "column", "preset")
    return compared(cells, table, numbers, first, "vs_first_preset", "sensitivity")


def curves(
    results: Results, measure: str, preset: str, scenario: str, *, since_start: bool = False
) -> pl.DataFrame:
    """Return a measure of every cell of one preset and scenario over time (ours).

    Parameters
    ----------
    results, preset, scenario
        A study, and which of its cells.
    measure
        A numeric column of ``series``; ``entries``, all states an agent stores; or
        ``long_entries``, those of long-term memory, for SARSA of its table.
    since_start
        Return by how much the measure has changed since the first time of each run.

    Returns
    -------
    Columns of :attr:`Cells.named`, ``time_s``, ``mean``, ``low``, ``high`` over seeds. Baselines
    that ran under another preset only are taken from there.
    """
    value = {"entries": ENTRIES, "long_entries": LONG_ENTRIES}.get(measure, f'"{measure}"')
    learners = ", ".join(f"'{name}'" for name in LEARNERS)
    if since_start:
        run = f"partition by {', '.join(CELL)}, seed order by time_s"
        value = f"({value}) - first_value({value}) over ({run})"
    rows = results.query(
        f"""
        select {", ".join(CELL)}, seed, time_s, {value} as value from series
        where scenario = {_quoted(scenario)}
          and (preset = {_quoted(preset)} or controller not in ({learners}))
        """
    )
    own = rows.filter(pl.col("preset") == preset)
    have = own["controller"].unique().to_list()
    others = rows.filter((pl.col("preset") != preset) & ~pl.col("controller").is_in(have))
    if others.height:
        others = others.filter(pl.col("preset") == others["preset"].first())
        own = pl.concat([own, others.with_columns(preset=pl.lit(preset))])
    if own.is_empty():
        empty = {"column": pl.lit(None, pl.String), "is_exact_sarsa": pl.lit(False)}
        return own.select(*CELL, "time_s", mean="value", low="value", high="value", **empty)
    wide = own.pivot(on="time_s", index=[*CELL, "seed"], values="value")
    cells = arrange(wide, results)
    times = sorted(int(name) for name in cells.measures)
    values = np.hstack([cells.measures[str(time)] for time in times])
    estimate = mean_interval(values, stream(0, "bootstrap", "curves"), resamples=CURVE_RESAMPLES)
    count = cells.table.height
    return pl.concat([cells.named] * len(times)).with_columns(
        time_s=pl.Series(np.repeat(times, count)),
        **interval_columns(estimate),
    )


def beside_the_paper(table: pl.DataFrame) -> pl.DataFrame:
    """Add the entries of Table II, and whether our means lie within its ± (ours).

    The table has the columns ``scenario``, ``reward``, ``column`` and ``mean``.
    """
    paper = pl.DataFrame(
        [(v.scenario, v.reward, v.column, v.mean, v.spread) for v in TABLE_II],
        schema=["scenario", "reward", "column", "paper_mean", "paper_spread"],
        orient="row",
    )
    off = (pl.col("mean") - pl.col("paper_mean")).abs()
    return table.join(
        paper, on=["scenario", "reward", "column"], how="left", maintain_order="left"
    ).with_columns(within=off <= pl.col("paper_spread"))


def as_cells(results: Results | Cells) -> Cells:
    """Return a study's cells, arranged already or not (ours)."""
    return results if isinstance(results, Cells) else cells_of(results)


def named_rows(rows: Sequence[tuple[str | None, ...]], *names: str) -> pl.DataFrame:
    """Return a table of words (ours)."""
    return pl.DataFrame(rows, schema=dict.fromkeys(names, pl.String()), orient="row")


def estimates(
    cells: Cells, numbers: Sequence[int | None], name: str, measure: str = HEADLINE
) -> pl.DataFrame:
    """Return mean, sd, interval and number of seeds of cells, nulls for None (ours)."""
    values = cells.columns(measure, numbers)
    found = mean_interval(values, stream(0, "bootstrap", name))
    table = pl.DataFrame(interval_columns(found) | {"n": found.seeds})
    table = table.with_columns(sd=as_column(standard_deviation(values)))
    return table.select("mean", "sd", "low", "high", "n")


def differences(
    cells: Cells,
    numbers: Sequence[int | None],
    others: Sequence[int | None],
    name: str,
    *streams: str,
    measure: str = HEADLINE,
) -> dict[str, pl.Series]:
    """Return the paired relative differences of cells to others in %, nulls for None (ours)."""
    first, second = (cells.columns(measure, each) for each in (numbers, others))
    rng = stream(0, "bootstrap", *streams)
    return percent_columns(name, paired_difference(first, second, rng, relative=True))


def compared(
    cells: Cells,
    table: pl.DataFrame,
    numbers: Sequence[int | None],
    others: Sequence[int | None],
    name: str,
    stream_name: str,
    measure: str = HEADLINE,
) -> pl.DataFrame:
    """Add `estimates` of cells and their `differences` to others; cells not run are left out."""
    found = estimates(cells, numbers, stream_name, measure)
    against = differences(cells, numbers, others, name, stream_name, measure=measure)
    joined = pl.concat([table, found], how="horizontal").with_columns(**against)
    return joined.filter(pl.col("mean").is_not_null())


def _quoted(text: str) -> str:
    return "'" + text.replace("'", "''") + "'"
