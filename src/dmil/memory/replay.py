"""Replay: the last so many transitions in a ring of flat arrays, sampled uniformly."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from dmil.memory.saved import saved_array

Array = npt.NDArray[Any]
Arrays = Mapping[str, Array]
LongArray = npt.NDArray[np.int64]
Columns = dict[str, tuple[npt.DTypeLike, Sequence[int]]]
WRITTEN = "written"


class Replay:
    """A ring of rows, each one number or array per column; the oldest row leaves first (Lin 1992).

    Where a row is stays the same until another one takes its place, so its number can be kept.

    Parameters
    ----------
    capacity
        Rows kept.
    columns
        Name of each column to the type of its numbers and the shape of what a row has there.
    """

    def __init__(self, capacity: int, columns: Columns) -> None:
        self.capacity = capacity
        # The system gives memory to what is touched, so an empty ring costs next to nothing.
        self._columns = {
            name: np.zeros((capacity, *shape), kind) for name, (kind, shape) in columns.items()
        }
        self._written = 0

    @property
    def size(self) -> int:
        """Rows in use."""
        return min(self._written, self.capacity)

    @property
    def written(self) -> int:
        """Rows ever written, those that left included."""
        return self._written

    @property
    def bytes_used(self) -> int:
        """Memory of the rows in use."""
        return sum(column[: self.size].nbytes for column in self._columns.values())

    def append(self, **block: Array) -> LongArray:
        """Write some rows.

        Parameters
        ----------
        block: (rows, …) arrays
            What the rows have in each column, the first row being the oldest.

        Returns
        -------
        rows: (rows,) int64
            Where they are; of more rows than the capacity, only where the last ones are.
        """
        count = len(next(iter(block.values())))
        kept = min(count, self.capacity)
        rows: LongArray = np.arange(self._written + count - kept, self._written + count)
        rows %= self.capacity
        for name, column in self._columns.items():
            column[rows] = block[name][count - kept :]
        self._written += count
        return rows

    def sample(self, draws: npt.NDArray[np.float64]) -> LongArray:
        """Return rows in use, all equally likely, with repetition.

        Parameters
        ----------
        draws: (samples,) float64
            Uniform draws in [0, 1).
        """
        return (draws * self.size).astype(np.int64)

    def take(self, name: str, rows: LongArray) -> Array:
        """Return a copy of what some rows have in a column: (rows, …)."""
        return self._columns[name][rows]

    def arrays(self) -> dict[str, Array]:
        """Return the rows in use, by column, and how many were ever written."""
        size = self.size
        kept = {name: column[:size].copy() for name, column in self._columns.items()}
        return {**kept, WRITTEN: np.array(self._written, np.int64)}

    def restore(self, arrays: Arrays) -> None:
        """Replace all rows.

        Raises
        ------
        PolicyError
            If the arrays are not those of a ring of the same columns and capacity.
        """
        written = int(saved_array(arrays, WRITTEN, (), np.int64, least=0))
        size = min(written, self.capacity)
        saved = {
            name: saved_array(arrays, name, (size, *column.shape[1:]), column.dtype)
            for name, column in self._columns.items()
        }
        for name, column in self._columns.items():
            column[:size] = saved[name]
        self._written = written
