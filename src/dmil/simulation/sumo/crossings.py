"""How many vehicles have crossed the stop lines of every intersection, from where they are seen."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from dmil.simulation.sumo.approaches import FloatArray, RouteGeometry


class Crossings:
    """Follows all vehicles of a run along their routes (ours).

    Parameters
    ----------
    vehicles
        How many there are.

    Notes
    -----
    Vehicles are seen at decisions only: one that enters and arrives between two of them is missed.
    """

    def __init__(self, vehicles: int) -> None:
        self._links_behind = np.zeros(vehicles, np.int64)
        self._there = np.zeros(vehicles, np.bool_)

    def see(self, ways: RouteGeometry, seen: FloatArray) -> None:
        """Take in where the vehicles of the network are.

        Parameters
        ----------
        ways
            Routes of all vehicles, as SUMO last told them.
        seen: (5, vehicles in the network) float64
            See `dmil.simulation.sumo.approaches.count_vehicles`.
        """
        vehicle, links = seen[0].astype(np.int64), np.diff(ways.offset)[ways.route]
        there = np.zeros_like(self._there)
        there[vehicle] = True
        # Who is not there any more has arrived. (Or SUMO teleports it; then it soon is back.)
        gone = self._there & ~there
        self._links_behind[gone] = links[gone]
        # On a junction its stop line is crossed: what counts is the link behind it.
        behind = seen[1].astype(np.int64) + seen[4].astype(np.int64)
        self._links_behind[vehicle] = np.minimum(behind, links[vehicle] - 1)
        self._there = there

    def counted(
        self, ways: RouteGeometry, intersections: int, movements: int
    ) -> npt.NDArray[np.int64]:
        """Return the vehicles that have crossed, by intersection: (intersections,) int64.

        Parameters
        ----------
        ways
            See `see`.
        intersections, movements
            How many there are; movements of the intersection with the most.
        """
        # Of a route that SUMO has replaced nothing counts: the new one begins with its past.
        links_behind = np.zeros(ways.offset.size - 1, np.int64)
        links_behind[ways.route] = self._links_behind
        behind = np.repeat(ways.offset[:-1] + links_behind, np.diff(ways.offset))
        crossed = ways.own & (np.arange(ways.movement.size) < behind)
        return np.bincount(ways.movement[crossed] // movements, minlength=intersections)
