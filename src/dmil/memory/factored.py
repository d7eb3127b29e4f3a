"""A table of parts: what one queue is worth beyond a formula, the same table for all of them.

Values of a whole add up from values of its parts, so one small table serves every part everywhere.
A row is what a part looks like, a column how it is treated; an entry is the *residual*, what was
learned beyond what is believed of a part that nobody has seen (the prior, which is the caller's).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from dmil.compilation import kernel
from dmil.memory.saved import saved_array

STEPS = np.maximum(0.01, 0.1 / (1.0 + np.arange(256) / 5.0) ** 0.6)
"""Size of an entry's n-th step; the last one counts for all that follow."""

MOST = np.iinfo(np.uint16).max
"""Entries learned more often are counted no further."""

Single = npt.NDArray[np.float32]


class FactoredTable(NamedTuple):
    """Residuals of parts (ours).

    Attributes
    ----------
    residual: (rows, columns) float32
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


def make_factored_table(rows: int, columns: int) -> FactoredTable:
    """Return a table that has learned nothing (ours)."""
    return FactoredTable(
        residual=np.zeros((rows, columns), np.float32),
        times=np.zeros((rows, columns), np.uint16),
    )


def restored_table(arrays: Mapping[str, npt.NDArray[Any]], like: FactoredTable) -> FactoredTable:
    """Return a saved table; it may have more columns than the one that it is like.

    Raises
    ------
    PolicyError
        If an array is missing, of another shape, or holds numbers that cannot be.
    """
    rows, columns = like.residual.shape
    saved = arrays.get("residual")
    if saved is not None and saved.ndim == 2:
        columns = max(columns, saved.shape[1])
    like = make_factored_table(rows, columns)
    return FactoredTable(
        *(
            saved_array(arrays, name, array.shape, array.dtype).copy()
            for name, array in like._asdict().items()
        )
    )


@kernel
def learn_part(table: FactoredTable, row: int, column: int, error: float) -> None:
    """Move an entry by a step of its error; the steps get smaller with their number (ours)."""
    times = int(table.times[row, column])
    step = STEPS[min(times, STEPS.size - 1)]
    table.residual[row, column] += np.float32(step * error)
    table.times[row, column] = np.uint16(min(times + 1, MOST))


@kernel
def has_numbers_only(table: FactoredTable) -> bool:
    """Tell whether no residual is infinite or no number (ours)."""
    others = 0
    for row in range(table.residual.shape[0]):
        for column in range(table.residual.shape[1]):
            others += not np.isfinite(table.residual[row, column])
    return others == 0
