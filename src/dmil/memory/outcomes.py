"""A table of outcomes: what follows a part and its treatment, beyond what a formula says.

A row is what a part looks like, a column how it is treated; an entry holds the mean error of the
formula for each number that it predicts (*residual*), the same table for all parts.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from dmil.compilation import kernel
from dmil.memory.saved import saved_array

SMALLEST_STEP = 0.005
"""Least step of a running mean: a world that changes is learned for ever."""
MOST = np.iinfo(np.uint16).max
"""Entries learned more often are counted no further."""


class OutcomeTable(NamedTuple):
    """Residuals of outcomes (ours).

    Attributes
    ----------
    residual: (rows, columns, outcomes) float32
    times: (rows, columns) uint16
        How often an entry was learned, at most `MOST`.
    """

    residual: npt.NDArray[np.float32]
    times: npt.NDArray[np.uint16]

    @property
    def entries(self) -> int:
        """Entries that have been learned."""
        return int(np.count_nonzero(self.times))

    @property
    def bytes_total(self) -> int:
        """Memory of all arrays."""
        return sum(array.nbytes for array in self)


def make_outcome_table(rows: int, columns: int, outcomes: int) -> OutcomeTable:
    """Return a table that has learned nothing (ours)."""
    return OutcomeTable(
        residual=np.zeros((rows, columns, outcomes), np.float32),
        times=np.zeros((rows, columns), np.uint16),
    )


def restored_outcomes(arrays: Mapping[str, npt.NDArray[Any]], like: OutcomeTable) -> OutcomeTable:
    """Return a saved table; it may have more columns than the one that it is like.

    Raises
    ------
    PolicyError
        If an array is missing, of another shape, or holds what is no number.
    """
    rows, columns, outcomes = like.residual.shape
    saved = arrays.get("residual")
    if saved is not None and saved.ndim == 3:
        columns = max(columns, saved.shape[1])
    like = make_outcome_table(rows, columns, outcomes)
    return OutcomeTable(
        *(
            saved_array(arrays, name, array.shape, array.dtype).copy()
            for name, array in like._asdict().items()
        )
    )


@kernel
def learn_outcome(table: OutcomeTable, row: int, column: int, outcome: int, error: float) -> None:
    """Move a residual towards an error of the formula, as a running mean does (ours).

    The caller counts the entry when all its outcomes are learned; see `count_outcome`.
    """
    step = max(SMALLEST_STEP, 1.0 / (1.0 + int(table.times[row, column])))
    past = table.residual[row, column, outcome]
    table.residual[row, column, outcome] = np.float32(past + step * (error - past))


@kernel
def count_outcome(table: OutcomeTable, row: int, column: int) -> None:
    """Count that an entry was learned once more."""
    table.times[row, column] = np.uint16(min(int(table.times[row, column]) + 1, MOST))


@kernel
def believed(table: OutcomeTable, row: int, column: int, outcome: int, trust: float) -> float:
    """Return a residual as far as it is believed: half of it after ``trust`` times (ours)."""
    times = float(table.times[row, column])
    if times == 0.0:
        return 0.0
    return float(table.residual[row, column, outcome]) * (times / (times + trust))


@kernel
def has_numbers_only(table: OutcomeTable) -> bool:
    """Tell whether no residual is infinite or no number (ours)."""
    others = 0
    for row in range(table.residual.shape[0]):
        for column in range(table.residual.shape[1]):
            for outcome in range(table.residual.shape[2]):
                others += not np.isfinite(table.residual[row, column, outcome])
    return others == 0
