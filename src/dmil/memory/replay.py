"""Replay: the last so many transitions in a ring of flat arrays, sampled uniformly.

And hindsight: goals that were reached later in the same run (Andrychowicz et al. 2017).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from dmil.arrays import Array, Arrays, LongArray
from dmil.errors import PolicyError
from dmil.memory.saved import saved_array

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


class Runs:
    """Where each run begins among the rows that are written to a ring, one after the other.

    Parameters
    ----------
    capacity
        Rows of the ring.
    """

    def __init__(self, capacity: int) -> None:
        self.capacity = capacity
        self.begins: LongArray = np.zeros(0, np.int64)

    def begin(self, written: int) -> None:
        """Note that a new run begins with the next row.

        Parameters
        ----------
        written
            Rows ever written to the ring.
        """
        # Runs whose rows have all left the ring are forgotten, but for the last of them.
        oldest = max(0, written - self.capacity)
        first = max(0, int(np.searchsorted(self.begins, oldest, side="right")) - 1)
        self.begins = np.append(self.begins[first:], written)

    def future(self, rows: LongArray, draws: npt.NDArray[np.float64], written: int) -> LongArray:
        """Return a row of the same run for each row: itself or a later one, all equally likely.

        This is the strategy "future" of the paper (§4.5).

        Parameters
        ----------
        rows: (samples,) int64
            Rows in the ring.
        draws: (samples,) float64
            Uniform draws in [0, 1).
        written
            Rows ever written to the ring.

        Returns
        -------
        later: (samples,) int64
            Rows in the ring.
        """
        newest = written - 1
        # The number of a row among all that were ever written: the last one that fits its place.
        number = newest - (newest - rows) % self.capacity
        ends = np.append(self.begins[1:], written)
        run = np.searchsorted(self.begins, number, side="right") - 1
        left = ends[run] - number
        later: LongArray = (number + (draws * left).astype(np.int64)) % self.capacity
        return later

    def arrays(self) -> dict[str, Array]:
        """Return where the runs begin."""
        return {"begins": self.begins.copy()}

    def restore(self, arrays: Arrays, written: int) -> None:
        """Replace all runs.

        Parameters
        ----------
        arrays
            What `arrays` returned.
        written
            Rows ever written to the ring that is restored with it.

        Raises
        ------
        PolicyError
            If the arrays are not those of runs of such a ring.
        """
        count = arrays["begins"].size if "begins" in arrays else 0
        begins = saved_array(arrays, "begins", (count,), np.int64, least=0)
        covers = written == 0 or (count > 0 and begins[0] <= max(0, written - self.capacity))
        if not covers or (np.diff(begins) < 0).any() or (begins > written).any():
            raise PolicyError(
                "array 'begins' does not fit the rows that are saved with it",
                where="saved memory",
                expected=f"numbers of rows in order, up to {written}",
                mend="train it again with this version of dmil and the same options",
            )
        self.begins = begins.copy()
