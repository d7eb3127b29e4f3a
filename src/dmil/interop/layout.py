"""The numbers that an outside algorithm gets: one flat vector per intersection, and masks."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from dmil.network import RoadNetwork
from dmil.simulation import Observation

FloatArray = npt.NDArray[np.float32]
IntArray = npt.NDArray[np.int32]
MaskArray = npt.NDArray[np.int8]


class VectorLayout:
    """Where what is seen of an intersection stands in its vector.

    A vector of an intersection with m movements and p phases has 2·m + p + 2 places:

    - m: vehicles queued, by movement in the network's order;
    - m: vehicles approaching, in the same order;
    - 1 + p: 1 at the phase shown, else 0; the first place means that none has been shown yet;
    - 1: time since that phase turned green, in decision intervals.

    Padded, m and p are the largest of the network: what an intersection does not have is 0.

    Parameters
    ----------
    network
        The roads.
    decision_interval_s
        Time between two decisions.
    padded
        Whether all intersections get vectors and actions of equal length.

    Attributes
    ----------
    phases: (intersections,) int32
        How many phases each intersection has.
    actions: tuple of int
        Length of each intersection's action mask: its number of phases, or the largest.
    """

    def __init__(self, network: RoadNetwork, decision_interval_s: int, *, padded: bool) -> None:
        movements = [len(item.movements) for item in network.intersections]
        phases = [len(item.phases) for item in network.intersections]
        self._movements, self._most_phases = max(movements), max(phases)
        self._interval_s = decision_interval_s
        self.phases = np.array(phases, np.int32)
        self._exists = np.arange(self._most_phases) < self.phases[:, None]
        self._width = 2 * self._movements + self._most_phases + 2
        if padded:
            movements = [self._movements] * len(movements)
            phases = [self._most_phases] * len(phases)
        self.actions = tuple(phases)
        self._columns = [self._own(m, p) for m, p in zip(movements, phases, strict=True)]

    def _own(self, movements: int, phases: int) -> npt.NDArray[np.intp] | slice:
        """Return the places of the widest vector that an intersection has."""
        if (movements, phases) == (self._movements, self._most_phases):
            return slice(None)
        shown = 2 * self._movements
        places = np.r_[
            0:movements,
            self._movements : self._movements + movements,
            shown : shown + 1 + phases,
            self._width - 1,
        ]
        return np.asarray(places, np.intp)

    def highest(self, i: int) -> FloatArray:
        """Return the largest value of every place of an intersection's vector; the least is 0."""
        high = np.full(self._width, np.iinfo(np.int32).max, np.float32)
        high[2 * self._movements : -1] = 1.0
        return high[self._columns[i]]

    def vectors(self, observation: Observation) -> list[FloatArray]:
        """Return the vector of every intersection, in the network's order."""
        count, movements = observation.phase.size, self._movements
        full = np.zeros((count, self._width), np.float32)
        full[:, :movements] = observation.queue_veh
        full[:, movements : 2 * movements] = observation.approaching_veh
        full[np.arange(count), 2 * movements + 1 + observation.phase] = 1.0
        full[:, -1] = observation.phase_elapsed_s / self._interval_s
        return [row[own] for row, own in zip(full, self._columns, strict=True)]

    def masks(
        self,
        observation: Observation,
        min_green_s: int | IntArray = 0,
        max_green_s: int | IntArray = 0,
    ) -> list[MaskArray]:
        """Return for every intersection 1 where a phase exists and may be chosen now, else 0.

        Parameters
        ----------
        observation
            What is seen now.
        min_green_s, max_green_s: int or (intersections, phases) int32
            Rules of the signals, see `dmil.scenarios.signal_times`: what they would overrule is 0.
        """
        shown, elapsed_s = observation.phase, observation.phase_elapsed_s
        free = self._exists.copy()
        of_shown = np.arange(shown.size), shown
        least_s, longest_s = (
            np.broadcast_to(times, self._exists.shape)[of_shown]
            for times in (min_green_s, max_green_s)
        )
        held = np.flatnonzero((shown >= 0) & (elapsed_s < least_s))
        free[held] = False
        free[held, shown[held]] = True
        limited = (shown >= 0) & (longest_s > 0) & (self.phases > 1)
        over = np.flatnonzero(limited & (elapsed_s >= longest_s))
        free[over, shown[over]] = False
        masks = free.astype(np.int8)
        return [row[:count] for row, count in zip(masks, self.actions, strict=True)]
