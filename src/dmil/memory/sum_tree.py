"""Prioritised replay: a tree of sums that finds a row by its share of all priorities."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from dmil.arrays import Array, Arrays, FloatArray, LongArray
from dmil.compilation import kernel
from dmil.memory.saved import saved_array

FIRST_PRIORITY = 1.0
"""Priority of the first rows, before any error is known."""


class Priorities:
    """How urgently each row of a replay is to be sampled (Schaul et al. 2016, §3.3).

    P(row) ∝ (|δ| + floor)^exponent; a new row has the largest priority there has been.

    Parameters
    ----------
    capacity
        Rows of the replay.
    exponent
        α: 0 samples uniformly, 1 in proportion to |δ|.
    floor
        ε of the paper: keeps rows without error from never being sampled again.
    """

    def __init__(self, capacity: int, exponent: float, floor: float) -> None:
        self.capacity, self.exponent, self.floor = capacity, exponent, floor
        self.sums: FloatArray = np.zeros(2 << max(0, (capacity - 1).bit_length()))
        self.largest = FIRST_PRIORITY

    def add(self, rows: LongArray) -> None:
        """Give new rows the largest priority."""
        set_priorities(self.sums, rows, np.full(rows.size, self.largest))

    def update(self, rows: LongArray, errors: npt.NDArray[Any]) -> None:
        """Give rows the priority of their errors δ."""
        priority = (np.abs(errors.astype(np.float64)) + self.floor) ** self.exponent
        self.largest = max(self.largest, float(priority.max()))
        set_priorities(self.sums, rows, priority)

    def sample(
        self, draws: FloatArray, size: int, correction: float
    ) -> tuple[LongArray, FloatArray]:
        """Return rows and the weights that undo the preference (Schaul et al. 2016, §3.4).

        Parameters
        ----------
        draws: (samples,) float64
            Uniform draws in [0, 1), one per stratum.
        size
            Rows in use, N.
        correction
            β.

        Returns
        -------
        rows: (samples,) int64
        weights: (samples,) float64
            (N·P)^−β, divided by the largest of the batch.
        """
        rows = np.empty(draws.size, np.int64)
        sample_stratified(self.sums, draws, rows)
        chance = self.of(rows) / self.sums[1]
        weights = (size * chance) ** -correction
        return rows, weights / weights.max()

    def of(self, rows: LongArray) -> FloatArray:
        """Return the priorities of rows."""
        found: FloatArray = self.sums[self.sums.size // 2 + rows]
        return found

    def arrays(self, size: int) -> dict[str, Array]:
        """Return the priorities of the first ``size`` rows, and the largest there has been."""
        return {"priority": self.of(np.arange(size)), "largest": np.array(self.largest)}

    def restore(self, arrays: Arrays, size: int) -> None:
        """Replace all priorities; the sums over them are worked out again, to the last bit.

        Raises
        ------
        PolicyError
            If the arrays are not the priorities of ``size`` rows.
        """
        priority = saved_array(arrays, "priority", (size,), np.float64, least=0.0)
        largest = saved_array(arrays, "largest", (), np.float64, least=0.0)
        self.sums[:] = 0.0
        set_priorities(self.sums, np.arange(size), priority)
        self.largest = float(largest)


@kernel
def set_priorities(sums: FloatArray, rows: LongArray, priority: FloatArray) -> None:
    """Change the priorities of rows, and the sums above them (ours).

    A sum is always its two parts added, never changed by a difference: so it depends on the
    priorities alone, and a tree that is built anew has the same bits.

    Parameters
    ----------
    sums: (2·leaves,) float64
        Sum of node n in n, its parts in 2n and 2n + 1; the root is 1, rows begin at ``leaves``.
    rows: (rows,) int64
    priority: (rows,) float64
    """
    leaves = sums.size // 2
    for k in range(rows.size):
        node = leaves + rows[k]
        sums[node] = priority[k]
        while node > 1:
            node //= 2
            sums[node] = sums[2 * node] + sums[2 * node + 1]


@kernel
def sample_stratified(sums: FloatArray, draws: FloatArray, rows: LongArray) -> None:
    """Find the rows at draws of the total, one draw in each of equal strata (Schaul, App. B.2.1).

    Parameters
    ----------
    sums
        See `set_priorities`.
    draws: (samples,) float64
        Uniform draws in [0, 1).
    rows: (samples,) int64
        What is found, filled in place.
    """
    leaves = sums.size // 2
    for k in range(draws.size):
        rest = (k + draws[k]) / draws.size * sums[1]
        node = 1
        while node < leaves:
            node *= 2
            # Rounding may leave a rest at the very end, where there is nothing.
            if rest >= sums[node] and sums[node + 1] > 0.0:
                rest -= sums[node]
                node += 1
        rows[k] = node - leaves
