"""Hindsight replay: goals that were reached later in the same run (Andrychowicz et al. 2017)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from dmil.errors import PolicyError
from dmil.memory.saved import saved_array

LongArray = npt.NDArray[np.int64]


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

    def arrays(self) -> dict[str, npt.NDArray[Any]]:
        """Return where the runs begin."""
        return {"begins": self.begins.copy()}

    def restore(self, arrays: Mapping[str, npt.NDArray[Any]], written: int) -> None:
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
