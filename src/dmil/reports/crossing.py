"""An intersection as it lies on the ground: lanes, stop lines, ways across, in metres."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from dmil.doctor import Case
from dmil.doctor.roads import Line, road_ends
from dmil.network import Intersection, Junction, Link
from dmil.reports.paths import (
    Points,
    beginning,
    bend,
    beside,
    direction,
    ending,
    inside,
    without_end,
)

LANE_M = 3.2
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
    case
        What is examined.
    item
        The intersection.

    Attributes
    ----------
    side: int
        1 where traffic keeps to the right, else −1.
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

    def __init__(self, case: Case, item: Intersection) -> None:
        self._case, self._item = case, item
        self.side = -1 if case.sumo and case.sumo.left_hand else 1
        self._links = {link.id: link for link in case.network.links}
        self._into = dict.fromkeys(movement.from_link for movement in item.movements)
        self._out_of = dict.fromkeys(movement.to_link for movement in item.movements)
        # Without a file's lines, links run from middle to middle and need room in between.
        widest = max(self._links[name].lanes for name in (*self._into, *self._out_of))
        self._room_m = 0.0 if case.sumo else (widest + 1.2) * LANE_M
        self._used, self._closed = self._lanes_used(), road_ends(case.network)
        self.stops = {
            (movement.from_link, lane): self._stop(self._links[movement.from_link], lane)
            for movement in item.movements
            for lane in movement.lanes
        }
        self.ways = [self._ways(j) for j in range(len(item.movements))]
        ends = [point for stop in self.stops.values() for point in stop]
        ends += [way[-1] for ways in self.ways for way in ways]
        corners = np.array(ends)
        self.hull = _hull(corners)
        middle = (corners.min(axis=0) + corners.max(axis=0)) / 2
        half = float(np.abs(corners - middle).max())
        half += float(np.clip(0.8 * half, *AROUND_M))
        self.low, self.high = middle - half, middle + half
        mine = {*self._into, *self._out_of}
        self.roads = [
            DrawnRoad(self._middle(self._links[name]), self._links[name].lanes) for name in mine
        ]
        self.others = self._others(mine)

    def origin(self, link: str) -> Points:
        """Return the middle line of a road into the intersection.

        Parameters
        ----------
        link
            Its id.
        """
        return self._middle(self._links[link])

    def _others(self, mine: set[str]) -> list[DrawnRoad]:
        """Return the other links in the square, and the ways across junctions without signals."""
        network = self._case.network
        near = [link for link in network.links if self._touches(self._case.lines[link.id])]
        roads = [DrawnRoad(self._middle(link), link.lanes) for link in near if link.id not in mine]
        ids = {link.id for link in near} | mine
        for junction in network.junctions:
            for movement in junction.movements:
                if {movement.from_link, movement.to_link} <= ids and movement.turn != "uturn":
                    here, there = self._links[movement.from_link], self._links[movement.to_link]
                    ends = np.array([self._middle(here)[-1], self._middle(there)[0]])
                    roads.append(DrawnRoad(ends, min(here.lanes, there.lanes)))
        return roads

    def _touches(self, line: Line) -> bool:
        points = np.array(line)
        outside = (points.max(axis=0) < self.low) | (points.min(axis=0) > self.high)
        return not outside.any() and bool(inside(points, self.low, self.high))

    def _from_right(self, link: str, lanes: Iterable[int]) -> list[int]:
        """Return lanes counted from the right, in this order."""
        last = self._links[link].lanes - 1
        return sorted(last - lane if self._case.lanes_from_left else lane for lane in lanes)

    def _lanes_used(self) -> dict[str, list[int]]:
        """Find the lanes, from the right, that vehicles leave by; others may be for pedestrians."""
        used: dict[str, set[int]] = {}
        network = self._case.network
        nodes: tuple[Intersection | Junction, ...] = (*network.intersections, *network.junctions)
        for movement in (each for node in nodes for each in node.movements):
            used.setdefault(movement.from_link, set()).update(movement.lanes)
        return {name: self._from_right(name, lanes) for name, lanes in used.items()}

    def _line(self, link: Link) -> Points:
        """Return the line of the leftmost lane, cut where the intersection begins."""
        line = np.array(self._case.lines[link.id], np.float64)
        if self._case.sumo:
            return line
        whole = float(np.hypot(*np.diff(line, axis=0).T).sum())
        room = min(self._room_m, 0.4 * whole)
        ends = {item.id for item in self._case.network.intersections}
        if link.end in ends:
            line = without_end(line, room)
        if link.start in ends:
            line = without_end(line[::-1], room)[::-1]
        return beside(line, self.side * LANE_M / 2)

    def _lane(self, link: Link, lane: int) -> Points:
        return beside(self._line(link), self.side * (link.lanes - 1 - lane) * LANE_M)

    def _middle(self, link: Link) -> Points:
        return beside(self._line(link), self.side * (link.lanes - 1) * LANE_M / 2)

    def _stop(self, link: Link, lane: int) -> Points:
        line = self._lane(link, *self._from_right(link.id, [lane]))
        along = direction(line, at_end=True)
        across = np.array([along[1], -along[0]]) * LANE_M * 0.42
        return np.array([line[-1] - across, line[-1] + across])

    def _ways(self, j: int) -> list[Points]:
        movement = self._item.movements[j]
        start, goal = self._links[movement.from_link], self._links[movement.to_link]
        lanes = self._from_right(start.id, movement.lanes)
        onto = self._used.get(goal.id, [])
        rank = self._used[start.id].index(lanes[0])
        if goal.end in self._closed or len(onto) < len(lanes):
            # Which lanes lead on does not tell which ones are driven on.
            onto, rank = list(range(goal.lanes)), lanes[0]
        # Right turns keep right, left turns left, and who goes straight stays in line.
        far = max(len(onto) - len(lanes), 0)
        first_lane = {"right": 0, "straight": min(rank, far)}.get(movement.turn, far)
        ways = []
        for k, lane in enumerate(lanes):
            target = onto[min(first_lane + k, len(onto) - 1)]
            first = ending(self._lane(start, lane), 5.0)
            last = beginning(self._lane(goal, target), 5.0)
            distance = float(np.hypot(*(last[0] - first[-1])))
            reach = max(0.4 * distance, 7.0 if movement.turn == "uturn" else 0.5)
            ahead, onward = direction(first, at_end=True), direction(last, at_end=False)
            curve = bend(first[-1], ahead, last[0], onward, reach)
            ways.append(np.vstack([curve, last[0] + onward * 2.5]))
        return ways


def _hull(points: Points) -> Points:
    """Return the corners of the smallest convex area around points, in order."""

    def half(ordered: list[tuple[float, float]]) -> list[tuple[float, float]]:
        kept: list[tuple[float, float]] = []
        for x, y in ordered:
            while len(kept) > 1:
                (ax, ay), (bx, by) = kept[-2:]
                if (bx - ax) * (y - ay) - (by - ay) * (x - ax) > 0:
                    break
                kept.pop()
            kept.append((x, y))
        return kept[:-1]

    ordered = sorted({(float(x), float(y)) for x, y in points})
    return np.array([*half(ordered), *half(ordered[::-1])])
