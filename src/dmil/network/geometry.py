"""Where roads, lanes, stop lines and ways across intersections lie, in metres; for all pictures.

x to the East and y to the North. A line is an array of points, (points, 2) float64.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property
from typing import NamedTuple

import numpy as np

from dmil.network.lines import Points, bend_into, beside, direction, length_of, without_end
from dmil.network.model import Link, Movement, RoadNetwork

LANE_M = 3.2
"""Width of a lane: no file's, but SUMO's default."""


class View(NamedTuple):
    """Where the metres of a map are in a picture, whose y goes down.

    Parameters
    ----------
    low: (2,) float64
        The place that is shown at ``left`` and ``bottom``.
    scale
        Picture's units per metre.
    """

    low: Points
    scale: float
    left: float
    bottom: float

    def place(self, points: object) -> Points:
        """Return where points are in the picture: (…, 2) float64."""
        moved = (np.asarray(points, np.float64) - self.low) * self.scale
        return np.stack([self.left + moved[..., 0], self.bottom - moved[..., 1]], axis=-1)


def fitted(
    points: Points, longest_px: float, margin_px: float, least_px: float | tuple[float, float]
) -> tuple[View, tuple[float, float]]:
    """Return a view of some points, (points, 2) float64, and the size of its picture.

    ``longest_px`` is the picture's longer side, with a margin around the points; width and height
    are ``least_px`` at least, without margins.
    """
    low, high = points.min(axis=0), points.max(axis=0)
    extent_m = np.maximum(high - low, 1.0)
    scale = (longest_px - 2 * margin_px) / float(extent_m.max())
    inner = np.maximum(extent_m * scale, least_px)
    left, below = (margin_px + (inner - extent_m * scale) / 2).tolist()
    width, height = (inner + 2 * margin_px).round().tolist()
    return View(low, scale, left, height - below), (width, height)


class RoadGeometry:
    """The roads of a network in the plane.

    Links run where the file says, else straight from node to node, less the room that crossing
    roads need; their lanes lie beside each other, to the right of that line where traffic keeps to
    the right.

    Parameters
    ----------
    network
        The roads; links whose nodes have no place, or the same one, are left out.
    lane_m
        Width of a lane, where it is drawn wider than it is.
    straight
        Whether to leave aside what the file says.

    Attributes
    ----------
    side: int
        1 where traffic keeps to the right, else −1.
    links: dict of str to Link
    """

    def __init__(
        self, network: RoadNetwork, *, lane_m: float = LANE_M, straight: bool = False
    ) -> None:
        self.network, self.lane_m = network, lane_m
        self.side = -1 if network.left_hand else 1
        self._known = {} if straight else network.line_m
        self.links = {link.id: link for link in network.links if self._has_length(link)}
        self._first_lane: dict[str, Points] = {}

    def _has_length(self, link: Link) -> bool:
        ends = {self.network.position_m.get(node) for node in (link.start, link.end)}
        return link.id in self._known or (len(ends) == 2 and None not in ends)

    def course(self, link: str) -> Points:
        """Return the line along a link, as the file has it or straight from node to node."""
        network = self.network
        road = network.links[network.link_index[link]]
        line = self._known.get(link) or [
            network.position_m[node] for node in (road.start, road.end)
        ]
        return np.array(line, np.float64)

    def line(self, link: str, across: float) -> Points:
        """Return the line along a link at a place across it, from end to end.

        Parameters
        ----------
        link
            Its id.
        across
            In lanes from its left edge: 0 there, 0.5 in the middle of the leftmost lane. (With
            traffic on the left, from its right edge.)
        """
        if link not in self._first_lane:
            self._first_lane[link] = self._cut(link)
        return beside(self._first_lane[link], self.side * (across - 0.5) * self.lane_m)

    def lane(self, link: str, lane: int) -> Points:
        """Return the middle line of a lane, numbered as in the file, up to its stop line."""
        return self._from_right(link, self.from_right(link, [lane])[0])

    def middle(self, link: str) -> Points:
        """Return the middle line of a link."""
        return self.line(link, self.links[link].lanes / 2)

    def stop_line(self, link: str, lane: int) -> Points:
        """Return both ends of a lane's stop line."""
        line = self.lane(link, lane)
        along = direction(line, at_end=True)
        across = np.array([along[1], -along[0]]) * self.lane_m * 0.42
        return np.array([line[-1] - across, line[-1] + across])

    def from_right(self, link: str, lanes: Iterable[int]) -> list[int]:
        """Return lanes, numbered as in the file, counted from the right, in this order."""
        last = self.links[link].lanes - 1
        return sorted(last - lane if self.network.lanes_from_left else lane for lane in lanes)

    def ways(self, movement: Movement, beyond_m: float = 0.0) -> list[Points]:
        """Return the ways of a movement across its node, one for each of its lanes from the right.

        Right turns keep right, left turns left, and who goes straight stays in line.

        Parameters
        ----------
        movement
            One of the network's.
        beyond_m
            How far they go on into the next link.
        """
        start, goal = movement.from_link, movement.to_link
        lanes = self.from_right(start, movement.lanes)
        onto = self._used.get(goal, [])
        rank = self._used[start].index(lanes[0])
        if self.links[goal].end in self._closed or len(onto) < len(lanes):
            # Which lanes lead on does not tell which ones are driven on.
            onto, rank = list(range(self.links[goal].lanes)), lanes[0]
        far = max(len(onto) - len(lanes), 0)
        first = {"right": 0, "straight": min(rank, far)}.get(movement.turn, far)
        least = 7.0 if movement.turn == "uturn" else 0.5
        return [
            bend_into(
                self._from_right(start, lane),
                self._from_right(goal, onto[min(first + k, len(onto) - 1)]),
                least,
                beyond_m,
            )
            for k, lane in enumerate(lanes)
        ]

    def _from_right(self, link: str, lane: int) -> Points:
        return self.line(link, self.links[link].lanes - lane - 0.5)

    @cached_property
    def _closed(self) -> frozenset[str]:
        return road_ends(self.network)

    @cached_property
    def _used(self) -> dict[str, list[int]]:
        """The lanes, from the right, that vehicles leave by; others may be for pedestrians."""
        used: dict[str, set[int]] = {}
        for movement in (each for node in self.network.nodes for each in node.movements):
            used.setdefault(movement.from_link, set()).update(movement.lanes)
        return {link: self.from_right(link, used[link]) for link in used if link in self.links}

    @cached_property
    def room_m(self) -> dict[str, float]:
        """How far from a node its straight links end, so that crossing roads have room."""
        fringe = set(self.network.fringe)
        joined: dict[str, list[Link]] = {}
        for link in self.links.values():
            for node in {link.start, link.end} - fringe:
                joined.setdefault(node, []).append(link)
        return {
            node: min(
                (max(link.lanes for link in links) + 1.2) * self.lane_m,
                0.35 * min(length_of(self.course(link.id)) for link in links),
            )
            for node, links in joined.items()
        }

    def _cut(self, link: str) -> Points:
        """Return the middle line of the leftmost lane."""
        line, place = self.course(link), self.network.position_m
        start, end = self.links[link].start, self.links[link].end
        if (tuple(line[0]), tuple(line[-1])) != (place.get(start), place.get(end)):
            return line  # the file's, from stop line to stop line
        line = without_end(line, self.room_m.get(end, 0.0))
        line = without_end(line[::-1], self.room_m.get(start, 0.0))[::-1]
        return beside(line, self.side * self.lane_m / 2)


def road_ends(network: RoadNetwork) -> frozenset[str]:
    """Return the nodes where roads end: vehicles cannot cross them, at most turn round (ours)."""
    turning = (
        node.id
        for node in network.nodes
        if all(movement.turn == "uturn" for movement in node.movements)
    )
    return frozenset((*network.fringe, *turning))
