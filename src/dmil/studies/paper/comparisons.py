"""Paired comparisons of cells and what they show: the bricks of a verdict."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from dmil.analysis.claims import Evidence, Relation, judge
from dmil.seeding import stream
from dmil.statistics import Estimate, paired_difference, paired_ratio_of_ratios
from dmil.studies.paper.cells import Cells


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
