"""Runs arranged for comparison, one column per cell and one row per seed; pairs of cells."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property

import numpy as np
import polars as pl
from numpy.typing import NDArray

from dmil.analysis.claims import Evidence, Relation, judge
from dmil.analysis.panel import (
    EMBEDDING_ORDER,
    RunPanel,
    check_distinct,
    check_success,
    numeric,
    on_axes,
    ordered,
)
from dmil.results import Results
from dmil.seeding import stream
from dmil.statistics import Estimate, paired_difference, paired_ratio_of_ratios
from dmil.studies.paper.plan import Architecture
from dmil.studies.paper.published import Reading, intersections_of, is_of, reading_of

#: What makes up a cell: all runs that differ in nothing but the seed.
CELL: tuple[str, ...] = (
    "preset",
    "scenario",
    "reward",
    "controller",
    "embedding",
    "communication",
    "epsilon",
    "variant",
)

#: All states that an agent stores, as SQL over the columns of ``series``.
ENTRIES = (
    "coalesce(short_term_entries, 0) + coalesce(long_term_entries, 0) + coalesce(table_entries, 0)"
)

#: What the paper records as the size of memory: m_L, for SARSA m_Q; as SQL over ``series``.
LONG_ENTRIES = "coalesce(long_term_entries, 0) + coalesce(table_entries, 0)"

PRESET_ORDER = ("literal", "decaying", "matched")
REWARD_ORDER = ("default", "entropy", "diffusion", "queue", "pressure")
BASELINES = ("longest-queue-first", "max-pressure", "fixed-cycle", "random")
LEARNERS = ("sarsa", "dual-memory")
CONTROLLER_ORDER = (*LEARNERS, *BASELINES)


@dataclass(frozen=True, kw_only=True)
class Cells(RunPanel):
    """All successful runs; the axes are ``seed`` and ``cell``, the rows of the table.

    Attributes
    ----------
    table: polars.DataFrame
        One row per cell: the columns of :data:`CELL`, in the order of the paper.
    reading: Reading
        Which cells the columns of the paper's table stand for.
    """

    table: pl.DataFrame
    reading: Reading

    @cached_property
    def named(self) -> pl.DataFrame:
        """The table, the paper's ``column`` that a cell stands for, and ``is_exact_sarsa``."""
        rows = self.table.rows(named=True)
        return self.table.with_columns(
            column=pl.Series([self.reading.column(row) for row in rows], dtype=pl.String),
            is_exact_sarsa=pl.Series(
                [is_of(self.reading.exact_sarsa, row) for row in rows], dtype=pl.Boolean
            ),
        )

    @cached_property
    def presets(self) -> list[str]:
        """Presets, those of the paper first."""
        return ordered(self.table["preset"].unique().to_list(), PRESET_ORDER)

    @property
    def rewards(self) -> list[str]:
        """Rewards of the learning agents, those of the paper first."""
        return ordered(self.table["reward"].drop_nulls().unique().to_list(), REWARD_ORDER)

    @property
    def scenarios(self) -> list[str]:
        """Scenarios, small grids first."""
        return by_size(self.table["scenario"].unique().to_list())

    def find(
        self, preset: str, scenario: str, reward: str | None, architecture: Architecture
    ) -> int | None:
        """Return the number of a cell, None if it was not run."""
        row = asdict(architecture) | {"preset": preset, "scenario": scenario, "reward": reward}
        return self.number("cell", tuple(row[name] for name in CELL))

    def of_column(self, preset: str, scenario: str, reward: str, column: str) -> int | None:
        """Return the number of the cell that a column of the paper's table stands for."""
        return self.find(preset, scenario, reward, self.reading.architecture(column, preset))

    def baseline(self, preset: str, scenario: str, controller: str) -> int | None:
        """Return the number of a baseline's cell, None if it was not run.

        A baseline does not depend on the preset: if the preset has none, another's stands in.
        """
        for name in (preset, *self.presets):
            number = self.find(name, scenario, None, Architecture(controller))
            if number is not None:
                return number
        return None

    def columns(self, measure: str, numbers: Sequence[int | None]) -> NDArray[np.float64]:
        """Return a measure of several cells as (seeds, numbers); NaN columns for None."""
        values = self.measures[measure]
        missing = np.full((len(self.seeds), 1), np.nan)
        padded = np.hstack([values, missing])
        return padded[:, [values.shape[1] if number is None else number for number in numbers]]


def by_size(scenarios: Sequence[str]) -> list[str]:
    """Return scenarios, small grids first and other networks last."""
    return sorted(scenarios, key=lambda name: (intersections_of(name) or 10**9, name))


def cells_of(results: Results) -> Cells:
    """Arrange the successful runs of a study.

    Besides the numeric columns of ``runs`` there are, per agent, ``long_entries`` at the horizon
    (m_L, for SARSA m_Q) and ``first_long_entries`` at the start; and the slopes of least-squares
    lines over the decisions of a run: ``entries_per_decision`` of all stored states,
    ``long_entries_per_decision`` and ``short_entries_per_decision`` of the parts of it.

    Raises
    ------
    InputError
        No run succeeded, or two runs of one cell have the same seed.
    """
    runs = results.runs()
    check_success(runs, results)
    runs = runs.filter(pl.col("status") == "ok")
    runs = runs.join(_growth(results), on=[*CELL, "seed"], how="left", nulls_equal=True)
    return arrange(runs, results)


def arrange(runs: pl.DataFrame, results: Results) -> Cells:
    """Arrange rows with the columns of :data:`CELL`, ``seed`` and any numeric measures."""
    reading = reading_of(results.manifest.get("configuration") or {})
    check_distinct(
        runs,
        (*CELL, "seed"),
        results,
        shared="cell and seed",
        mend="analyse different horizons or studies in folders of their own",
    )
    orders = {
        "preset": PRESET_ORDER,
        "scenario": by_size(runs["scenario"].unique().to_list()),
        "reward": REWARD_ORDER,
        "controller": CONTROLLER_ORDER,
        "embedding": EMBEDDING_ORDER,
    }
    ranks = [_rank(column, order) for column, order in orders.items()]
    table = runs.select(CELL).unique().sort(*ranks, *CELL, nulls_last=True)
    seeds = sorted(runs["seed"].unique().to_list())
    axes = {"seed": seeds, "cell": table.rows()}
    array = on_axes(runs, axes, cell=runs.select(CELL).rows())
    measures = {name: array(name) for name in numeric(runs, but=(*CELL, "seed"))}
    return Cells(axes=axes, measures=measures, table=table, reading=reading)


def _rank(column: str, order: Sequence[str]) -> pl.Expr:
    return pl.col(column).replace_strict(
        list(order), list(range(len(order))), default=len(order), return_dtype=pl.Int64
    )


def _growth(results: Results) -> pl.DataFrame:
    """Entries of each run at its ends, and per decision by least squares over its decisions.

    Sums are taken in order, so that the same runs give the same bytes.
    """
    return results.query(
        f"""
        select {", ".join(CELL)}, seed,
            arg_min({LONG_ENTRIES}, decision) as first_long_entries,
            arg_max({LONG_ENTRIES}, decision) as long_entries,
            regr_slope({ENTRIES}, decision order by decision) as entries_per_decision,
            regr_slope({LONG_ENTRIES}, decision order by decision) as long_entries_per_decision,
            regr_slope(coalesce(short_term_entries, 0), decision order by decision)
                as short_entries_per_decision
        from (select *, row_number() over (
                  partition by {", ".join(CELL)}, seed order by time_s) as decision from series)
        group by all
        """
    )


@dataclass(frozen=True, slots=True)
class CellComparison:
    """One cell against another: mean(first)/mean(second) - 1 over the seeds that both have.

    Parameters
    ----------
    label, scenario
        What is compared, for a reader, and where.
    measure
        Column of ``runs``, or a measure that `cells_of` adds.
    first, second
        Numbers of the cells, None where a cell was not run.
    change_of, change_from
        If given, (first/second)/(change_of/change_from) - 1 is estimated: whether going from
        second to first changes more than going from change_from to change_of.
    """

    label: str
    scenario: str
    measure: str
    first: int | None
    second: int | None
    change_of: int | None = None
    change_from: int | None = None

    @property
    def possible(self) -> bool:
        """Whether all its cells were run."""
        pair = self.first is not None and self.second is not None
        return pair and (self.change_of is None) == (self.change_from is None)


CellEvidence = Evidence[CellComparison]
"""Differences are relative, -0.3 is 30 % lower."""


def evaluate(
    cells: Cells, comparisons: Iterable[CellComparison], relation: Relation, threshold: float
) -> list[CellEvidence]:
    """Estimate all possible comparisons and judge each."""
    possible = [comparison for comparison in comparisons if comparison.possible]
    evidence: list[CellEvidence] = []
    for comparison, (value, low, high, seeds) in zip(
        possible, _estimate(cells, possible), strict=True
    ):
        if seeds:
            outcome = judge(relation, threshold, low, high)
            alike = _alike(cells, comparison)
            evidence.append(Evidence(comparison, value, low, high, seeds, outcome, alike))
    return evidence


def _alike(cells: Cells, comparison: CellComparison) -> float:
    pair = cells.columns(comparison.measure, [comparison.first, comparison.second])
    both = pair[~np.isnan(pair).any(axis=1)]
    return float((both[:, 0] == both[:, 1]).mean())


def _estimate(
    cells: Cells, comparisons: Sequence[CellComparison]
) -> list[tuple[float, float, float, int]]:
    results: dict[int, tuple[float, float, float, int]] = {}
    groups: dict[tuple[str, bool], list[int]] = {}
    for number, comparison in enumerate(comparisons):
        plain = comparison.change_of is None
        groups.setdefault((comparison.measure, plain), []).append(number)
    for (measure, plain), numbers in groups.items():
        chosen = [comparisons[number] for number in numbers]
        rng = stream(0, "bootstrap", "claims")
        first = cells.columns(measure, [c.first for c in chosen])
        second = cells.columns(measure, [c.second for c in chosen])
        if plain:
            estimate = paired_difference(first, second, rng, relative=True)
        else:
            change_of = cells.columns(measure, [c.change_of for c in chosen])
            change_from = cells.columns(measure, [c.change_from for c in chosen])
            estimate = paired_ratio_of_ratios((first, second), (change_of, change_from), rng)
        results |= dict(zip(numbers, _rows(estimate), strict=True))
    return [results[number] for number in range(len(comparisons))]


def _rows(estimate: Estimate) -> list[tuple[float, float, float, int]]:
    columns = (estimate.value, estimate.low, estimate.high, estimate.seeds)
    return list(zip(*(each.tolist() for each in columns), strict=True))
