"""Where everything of a network stands in a picture, in px."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dmil.network import TURNS, Intersection, RoadNetwork
from dmil.network.geometry import LANE_M, RoadGeometry, fitted
from dmil.network.lines import Points, bend_into, hull, length_of

LONGEST_PX, LONGEST_OF_MANY_PX, MANY_LINKS = 720, 1080, 100
LEAST_PX, MARGIN_PX = (424, 184), 28
WIDER, VEHICLE_M = 2.5, 7.5
"""Lanes are drawn wider than they are, or nothing could be seen on them."""
THINNEST_LANE_PX, SHORTEST_VEHICLE_PX = 2.2, 1.5
LANES_PER_LINK, VEHICLES_PER_LINK = 18, 20
"""A lane is at most so many times narrower, a vehicle so many times shorter than a usual link is
long, so that networks of short links show their queues, too."""


@dataclass(frozen=True, slots=True)
class Surface:
    """A piece of road by its (corners, 2) float64; signalled if at, to or from an intersection."""

    corners: Points
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

    stop: Points
    back: Points
    width_px: float
    room_px: float
    way: Points | None


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
        plain = RoadGeometry(network, straight=True)
        signalled = set(network.intersection_index)
        longest_px = LONGEST_PX if len(plain.links) <= MANY_LINKS else LONGEST_OF_MANY_PX
        lines = [plain.course(link) for link in plain.links]
        points = np.vstack(lines) if lines else np.array([[0.0, 0.0], [1.0, 1.0]])
        view, (width, height) = fitted(points, longest_px, MARGIN_PX, LEAST_PX)
        self.size_px = round(width), round(height) + top_px
        self._place = view._replace(bottom=view.bottom + top_px).place
        lengths = [
            length_of(line)
            for line, link in zip(lines, plain.links.values(), strict=True)
            if link.end in signalled
        ]
        usual_px = float(np.median(lengths)) * view.scale if lengths else LONGEST_PX
        self.lane_px = max(
            THINNEST_LANE_PX, min(WIDER * LANE_M * view.scale, usual_px / LANES_PER_LINK)
        )
        self.vehicle_px = max(
            SHORTEST_VEHICLE_PX, min(VEHICLE_M * view.scale, usual_px / VEHICLES_PER_LINK)
        )
        self._geometry = RoadGeometry(network, lane_m=self.lane_px / view.scale, straight=True)
        self.roads = [
            Surface(
                np.vstack([self._line(link.id), self._line(link.id, link.lanes)[::-1]]),
                not signalled.isdisjoint((link.start, link.end)),
            )
            for link in plain.links.values()
        ]
        self.nodes = [Surface(self._node(name), name in signalled) for name in plain.room_m]
        self.strips = [self._strips(item) for item in network.intersections]

    def _line(self, link: str, across: float = 0.0) -> Points:
        return self._place(self._geometry.line(link, across))

    def _node(self, name: str) -> Points:
        corners = [
            self._line(link.id, across)[-1 if link.end == name else 0]
            for link in self._geometry.links.values()
            if name in (link.start, link.end)
            for across in (0, link.lanes)
        ]
        return hull(np.array(corners))

    def _strips(self, item: Intersection) -> list[Strip | None]:
        """Share the width of each approach among its movements, right turns at the kerb."""
        sharing: dict[str, list[int]] = {}
        links = self._geometry.links
        order = sorted(
            range(len(item.movements)), key=lambda j: -TURNS.index(item.movements[j].turn)
        )
        for j in order:
            sharing.setdefault(item.movements[j].from_link, []).append(j)
        strips: list[Strip | None] = [None] * len(item.movements)
        for name, movements in sharing.items():
            if name not in links:
                continue
            lanes = links[name].lanes
            for k, j in enumerate(movements):
                share = (k + 0.5) / len(movements)
                first, stop = line = self._line(name, lanes * share)
                room_px = length_of(line)
                onto = links.get(item.movements[j].to_link)
                strips[j] = Strip(
                    stop=stop,
                    back=(first - stop) / room_px,
                    width_px=lanes * self.lane_px / len(movements),
                    room_px=room_px,
                    # On the same side of the next road.
                    way=bend_into(line, self._line(onto.id, onto.lanes * share), 0.5)
                    if onto
                    else None,
                )
        return strips
