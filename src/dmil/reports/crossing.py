"""An intersection as it lies on the ground: lanes, stop lines, ways across, in metres."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from dmil.network import Intersection, RoadNetwork
from dmil.network.geometry import RoadGeometry
from dmil.network.lines import Points, hull, inside

AHEAD_M = 2.5
"""How far ways across go on into the road that they lead to."""
AROUND_M = (9.0, 20.0)
"""How far the roads are shown beyond their stop lines: most of what lies between these, within
limits."""


class DrawnRoad(NamedTuple):
    """A piece of road: its middle line, (points, 2) in metres, and how many lanes it has."""

    line: Points
    lanes: int


class Crossing:
    """The geometry of one intersection.

    Parameters
    ----------
    network
        The roads.
    item
        The intersection.

    Attributes
    ----------
    geometry: RoadGeometry
    low, high: (2,) float64
        Corners of the square that is shown.
    roads, others: list of DrawnRoad
        Links into and out of the intersection, and what else is in the square.
    ways: list of lists of (points, 2) float64 arrays
        For every movement the ways of its lanes.
    stops: dict of (str, int) to (2, 2) float64 array
        Link and lane to its stop line.
    hull: (corners, 2) float64
        The area between the stop lines.
    """

    def __init__(self, network: RoadNetwork, item: Intersection) -> None:
        self.geometry = geometry = RoadGeometry(network)
        self.stops = {
            (movement.from_link, lane): geometry.stop_line(movement.from_link, lane)
            for movement in item.movements
            for lane in movement.lanes
        }
        self.ways = [geometry.ways(movement, AHEAD_M) for movement in item.movements]
        ends = [point for stop in self.stops.values() for point in stop]
        ends += [way[-1] for ways in self.ways for way in ways]
        corners = np.array(ends)
        self.hull = hull(corners)
        middle = (corners.min(axis=0) + corners.max(axis=0)) / 2
        half = float(np.abs(corners - middle).max())
        half += float(np.clip(0.8 * half, *AROUND_M))
        self.low, self.high = middle - half, middle + half
        into, out_of = zip(
            *((each.from_link, each.to_link) for each in item.movements), strict=True
        )
        mine = tuple(dict.fromkeys(into + out_of))
        self.roads = [self._road(link) for link in mine]
        self.others = self._others(mine)

    def _road(self, link: str) -> DrawnRoad:
        return DrawnRoad(self.geometry.middle(link), self.geometry.links[link].lanes)

    def _others(self, mine: tuple[str, ...]) -> list[DrawnRoad]:
        """Return the other links in the square, and the ways across junctions without signals."""
        geometry = self.geometry
        near = [link for link in geometry.links if self._touches(geometry.course(link))]
        roads = [self._road(link) for link in near if link not in mine]
        ids = {*near, *mine}
        for junction in geometry.network.junctions:
            for movement in junction.movements:
                if {movement.from_link, movement.to_link} <= ids and movement.turn != "uturn":
                    here, there = self._road(movement.from_link), self._road(movement.to_link)
                    ends = np.array([here.line[-1], there.line[0]])
                    roads.append(DrawnRoad(ends, min(here.lanes, there.lanes)))
        return roads

    def _touches(self, points: Points) -> bool:
        outside = (points.max(axis=0) < self.low) | (points.min(axis=0) > self.high)
        return not outside.any() and bool(inside(points, self.low, self.high))
