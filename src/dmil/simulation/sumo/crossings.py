"""How many vehicles have crossed the stop lines of every intersection, from where they are seen."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from dmil.simulation.sumo.approaches import FloatArray, Ways


class Crossings:
    """Follows all vehicles of a run along their routes (ours).

    Parameters
    ----------
    ways
        Routes of all vehicles.

    Notes
    -----
    Vehicles are seen at decisions only: one that enters and arrives between two of them is missed.
    """

    def __init__(self, ways: Ways) -> None:
        self._ways = ways
        self._place = ways.offset[:-1].copy()
        self._there = np.zeros(self._place.size, np.bool_)

    def see(self, seen: FloatArray) -> None:
        """Take in where the vehicles of the network are.

        Parameters
        ----------
        seen: (5, vehicles in the network) float64
            See `dmil.simulation.sumo.approaches.count_vehicles`.
        """
        vehicle = seen[0].astype(np.int64)
        end = self._ways.offset[1:]
        there = np.zeros_like(self._there)
        there[vehicle] = True
        gone = self._there & ~there  # nobody is teleported: who is not there any more has arrived
        self._place[gone] = end[gone]
        # On a junction its stop line is crossed: what counts is the link behind it.
        place = self._ways.offset[vehicle] + seen[1].astype(np.int64) + seen[4].astype(np.int64)
        self._place[vehicle] = np.minimum(place, end[vehicle] - 1)
        self._there = there

    def counted(self, intersections: int, movements: int) -> npt.NDArray[np.int64]:
        """Return the vehicles that have crossed, by intersection: (intersections,) int64.

        Parameters
        ----------
        intersections, movements
            How many there are; movements of the intersection with the most.
        """
        ways = self._ways
        behind = np.repeat(self._place, np.diff(ways.offset))
        crossed = ways.own & (np.arange(ways.slot.size) < behind)
        return np.bincount(ways.slot[crossed] // movements, minlength=intersections)
