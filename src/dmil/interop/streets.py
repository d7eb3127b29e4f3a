"""Where everything of a network stands in a picture, in px."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from dmil.network import Intersection, Link, RoadNetwork
from dmil.network.model import TURNS

Point = npt.NDArray[np.float64]

LONGEST_PX, LONGEST_OF_MANY_PX, MANY_LINKS = 720, 1080, 100
LEAST_PX, MARGIN_PX = (480, 240), 28
LANE_M, VEHICLE_M = 8.0, 7.5
"""Lanes are drawn wider than they are, or nothing could be seen on them."""
THINNEST_LANE_PX, SHORTEST_VEHICLE_PX = 2.2, 1.5
LANES_PER_LINK, VEHICLES_PER_LINK = 18, 20
"""A lane is at most so many times narrower, a vehicle so many times shorter than a usual link is
long, so that networks of short links show their queues, too."""


@dataclass(frozen=True, slots=True)
class Surface:
    """A piece of road.

    Attributes
    ----------
    corners: (corners, 2) float64
    signalled: bool
        Whether it belongs to an intersection or leads to or from one.
    """

    corners: Point
    signalled: bool


@dataclass(frozen=True, slots=True)
class Strip:
    """Where the vehicles of a movement queue, and their way across the intersection.

    Attributes
    ----------
    stop: (2,) float64
        Middle of the stop line.
    back: (2,) float64
        Unit vector from there to the end of the queue.
    width_px, room_px: float
        Width and length of the place for the queue.
    way: (points, 2) float64 or None
        From the stop line to the next link; None where that has no length in a picture.
    """

    stop: Point
    back: Point
    width_px: float
    room_px: float
    way: Point | None


class Streets:
    """The network laid out in a picture, North up.

    Parameters
    ----------
    network
        The roads.
    top_px
        What to leave free at the top.

    Attributes
    ----------
    size_px: tuple of int
        Width and height.
    lane_px, vehicle_px: float
        Width of a lane and length of a vehicle.
    roads, nodes: list of Surface
        Every link that has a length, the ends of its middle line first, and every node where roads
        meet.
    strips: list of list of Strip or None
        For every intersection and movement; None where the link has no length in a picture.
    """

    def __init__(self, network: RoadNetwork, top_px: int) -> None:
        place_m = {name: np.array(xy, np.float64) for name, xy in network.position_m.items()}
        self._links = [
            link for link in network.links if _apart(place_m.get(link.start), place_m.get(link.end))
        ]
        used = [place_m[name] for link in self._links for name in (link.start, link.end)]
        low, high = (np.min(used, axis=0), np.max(used, axis=0)) if used else (0.0, np.ones(2))
        extent_m = np.maximum(high - low, 1.0)
        longest_px = LONGEST_PX if len(self._links) <= MANY_LINKS else LONGEST_OF_MANY_PX
        scale = (longest_px - 2 * MARGIN_PX) / float(extent_m.max())
        inner_px = np.maximum(extent_m * scale + 2 * MARGIN_PX, LEAST_PX)
        self.size_px = round(float(inner_px[0])), round(float(inner_px[1])) + top_px
        middle_px = np.array([inner_px[0] / 2, top_px + inner_px[1] / 2])
        middle_m = (low + high) / 2
        self._place = {
            name: middle_px + (xy - middle_m) * scale * (1, -1) for name, xy in place_m.items()
        }
        signalled = set(network.intersection_index)
        lengths = [self._length(link) for link in self._links if link.end in signalled]
        usual_px = float(np.median(lengths)) if lengths else LONGEST_PX
        self.lane_px = max(THINNEST_LANE_PX, min(LANE_M * scale, usual_px / LANES_PER_LINK))
        self.vehicle_px = max(
            SHORTEST_VEHICLE_PX, min(VEHICLE_M * scale, usual_px / VEHICLES_PER_LINK)
        )
        self._radius = self._radii(network)
        self.roads = [
            Surface(self._road(link), link.start in signalled or link.end in signalled)
            for link in self._links
        ]
        self.nodes = [Surface(self._node(name), name in signalled) for name in self._radius]
        drawn = {link.id: link for link in self._links}
        self.strips = [self._strips(item, drawn) for item in network.intersections]

    def _length(self, link: Link) -> float:
        return math.dist(self._place[link.start], self._place[link.end])

    def _direction(self, link: Link) -> Point:
        way: Point = self._place[link.end] - self._place[link.start]
        return np.asarray(way / np.hypot(*way))

    def _radii(self, network: RoadNetwork) -> dict[str, float]:
        """Return how far from each node its links end, so that crossing roads have room."""
        radius = {}
        for name in self._place:
            links = [link for link in self._links if name in (link.start, link.end)]
            if links and name not in network.fringe:
                widest = max(link.lanes for link in links) * self.lane_px
                shortest = min(self._length(link) for link in links)
                radius[name] = min(widest + self.lane_px, 0.35 * shortest)
        return radius

    def _ends(self, link: Link) -> tuple[Point, Point, Point]:
        """Return both ends of a link's middle line and a vector across it to the right."""
        along = self._direction(link)
        first = self._place[link.start] + along * self._radius.get(link.start, 0.0)
        last = self._place[link.end] - along * self._radius.get(link.end, 0.0)
        return first, last, np.array([-along[1], along[0]]) * link.lanes * self.lane_px

    def _road(self, link: Link) -> Point:
        first, last, across = self._ends(link)
        return np.array([first, last, last + across, first + across])

    def _node(self, name: str) -> Point:
        corners = []
        for link in self._links:
            if name in (link.start, link.end):
                first, last, across = self._ends(link)
                end = last if link.end == name else first
                corners += [end, end + across]
        middle = self._place[name]
        angles = [math.atan2(*(corner - middle)[::-1]) for corner in corners]
        return np.array([corners[k] for k in np.argsort(angles)])

    def _strips(self, item: Intersection, drawn: dict[str, Link]) -> list[Strip | None]:
        """Share the width of each approach among its movements, right turns at the kerb."""
        sharing: dict[str, list[int]] = {}
        order = sorted(range(len(item.movements)), key=lambda j: -TURNS.index(_turn(item, j)))
        for j in order:
            sharing.setdefault(item.movements[j].from_link, []).append(j)
        strips: list[Strip | None] = [None] * len(item.movements)
        for name, movements in sharing.items():
            if name not in drawn:
                continue
            first, last, across = self._ends(drawn[name])
            along = self._direction(drawn[name])
            for k, j in enumerate(movements):
                share = (k + 0.5) / len(movements)
                stop = last + across * share
                onto = drawn.get(item.movements[j].to_link)
                strips[j] = Strip(
                    stop=stop,
                    back=-along,
                    width_px=float(np.hypot(*across)) / len(movements),
                    room_px=math.dist(first, last),
                    way=None if onto is None else self._way(stop, along, onto, share),
                )
        return strips

    def _way(self, stop: Point, along: Point, onto: Link, share: float) -> Point:
        """Bend from a stop line to the beginning of the next link, on the same side of the road."""
        first, _, across = self._ends(onto)
        end, out = first + across * share, self._direction(onto)
        # Where the line ahead meets the next link's line backwards, unless they are parallel.
        sine = along[0] * out[1] - along[1] * out[0]
        gap = end - stop
        ahead = (gap[0] * out[1] - gap[1] * out[0]) / sine if abs(sine) > 0.1 else 0.0
        near = 0.0 < ahead < 1.5 * math.dist(stop, end)
        bend = stop + along * ahead if near else (stop + end) / 2
        t = np.linspace(0.0, 1.0, 13)[:, None]
        return np.asarray((1 - t) ** 2 * stop + 2 * t * (1 - t) * bend + t**2 * end)


def _turn(item: Intersection, j: int) -> str:
    return item.movements[j].turn


def _apart(start: Point | None, end: Point | None) -> bool:
    return start is not None and end is not None and math.dist(start, end) > 0
