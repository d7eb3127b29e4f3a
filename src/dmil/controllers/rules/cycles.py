"""Cycles of phases that repeat, whatever happens: one of its own for every intersection."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dmil.arrays import IntArray


class Cycles:
    """Tells the phases of a time (ours).

    Parameters
    ----------
    phases
        For every intersection its phases, one per decision interval.
    interval_s
        Decision interval.
    """

    def __init__(self, phases: Sequence[Sequence[int]], interval_s: int) -> None:
        self._length = np.array([len(cycle) for cycle in phases])
        self._phase = np.zeros((len(phases), self._length.max()), np.int32)
        for i, cycle in enumerate(phases):
            self._phase[i, : len(cycle)] = cycle
        self._interval_s = interval_s

    def at(self, time_s: int) -> IntArray:
        """Return the phases of this time: (intersections,) int32."""
        step = (time_s // self._interval_s) % self._length
        phases: IntArray = self._phase[np.arange(step.size), step]
        return phases
