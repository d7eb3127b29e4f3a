"""Tables of residuals: what was learned of parts beyond a formula, one table for all of them.

A row is what a part looks like, a column how it is treated. An entry is what was learned beyond
what a formula says, the caller's: of the value of a part (values of a whole add up from those of
its parts), or of each of several outcomes that the formula predicts.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dmil.arrays import Arrays, Single
from dmil.compilation import kernel
from dmil.memory.saved import saved_array

STEPS = np.maximum(0.01, 0.1 / (1.0 + np.arange(256) / 5.0) ** 0.6)
"""Size of a value's n-th step; the last one counts for all that follow."""
SMALLEST_STEP = 0.005
"""Least step of an outcome's running mean: a world that changes is learned for ever."""
MOST = np.iinfo(np.uint16).max
"""Entries learned more often are counted no further."""


class ResidualTable(NamedTuple):
    """Residuals of parts (ours).

    Attributes
    ----------
    residual: (rows, columns) float32, or (rows, columns, outcomes)
    times: (rows, columns) uint16
        How often an entry was learned, at most `MOST`.
    """

    residual: Single
    times: npt.NDArray[np.uint16]

    @property
    def entries(self) -> int:
        """Entries that have been learned."""
        return int(np.count_nonzero(self.times))

    @property
    def bytes_total(self) -> int:
        """Memory of all arrays."""
        return sum(array.nbytes for array in self)


def make_residuals(rows: int, columns: int, *outcomes: int) -> ResidualTable:
    """Return a table that has learned nothing (ours)."""
    return ResidualTable(
        residual=np.zeros((rows, columns, *outcomes), np.float32),
        times=np.zeros((rows, columns), np.uint16),
    )


def restored_residuals(arrays: Arrays, like: ResidualTable, prefix: str = "") -> ResidualTable:
    """Return a saved table; it may have more columns than the one that it is like.

    The names of its arrays begin with ``prefix``.

    Raises
    ------
    PolicyError
        If an array is missing, of another shape, or holds numbers that cannot be.
    """
    rows, columns, *outcomes = like.residual.shape
    saved = arrays.get(prefix + "residual")
    if saved is not None and saved.ndim == like.residual.ndim:
        columns = max(columns, saved.shape[1])
    like = make_residuals(rows, columns, *outcomes)
    return ResidualTable(
        *(
            saved_array(arrays, prefix + name, array.shape, array.dtype).copy()
            for name, array in like._asdict().items()
        )
    )


@kernel
def learn_part(table: ResidualTable, row: int, column: int, error: float) -> None:
    """Move a value by a step of its error; the steps get smaller with their number (ours)."""
    times = int(table.times[row, column])
    step = STEPS[min(times, STEPS.size - 1)]
    table.residual[row, column] += np.float32(step * error)
    table.times[row, column] = np.uint16(min(times + 1, MOST))


@kernel
def learn_outcome(table: ResidualTable, row: int, column: int, outcome: int, error: float) -> None:
    """Move an outcome towards an error of the formula, as a running mean does (ours).

    The caller counts the entry when all its outcomes are learned; see `count_outcome`.
    """
    step = max(SMALLEST_STEP, 1.0 / (1.0 + int(table.times[row, column])))
    past = table.residual[row, column, outcome]
    table.residual[row, column, outcome] = np.float32(past + step * (error - past))


@kernel
def count_outcome(table: ResidualTable, row: int, column: int) -> None:
    """Count that an entry was learned once more."""
    table.times[row, column] = np.uint16(min(int(table.times[row, column]) + 1, MOST))


@kernel
def believed(table: ResidualTable, row: int, column: int, outcome: int, trust: float) -> float:
    """Return an outcome as far as it is believed: half of it after ``trust`` times (ours)."""
    times = float(table.times[row, column])
    if times == 0.0:
        return 0.0
    return float(table.residual[row, column, outcome]) * (times / (times + trust))


@kernel
def has_numbers_only(table: ResidualTable) -> bool:
    """Tell whether no residual is infinite or no number (ours)."""
    others = 0
    for residual in table.residual.flat:
        others += not np.isfinite(residual)
    return others == 0
