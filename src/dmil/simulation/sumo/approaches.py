"""Which stop line a vehicle comes to next, how far it is, and how many have crossed each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dmil.compilation import kernel
from dmil.demand import Vehicles
from dmil.network import RoadNetwork

IntArray = npt.NDArray[np.int32]
LongArray = npt.NDArray[np.int64]
FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

HALTING_M_PER_S = 0.1
"""Slower vehicles halt (SUMO's own threshold)."""


class RouteGeometry(NamedTuple):
    """For every link of every route: what comes next. A place is an index into the route links.

    Attributes
    ----------
    route: (vehicles,) int64
        Which route a vehicle drives: its own number until SUMO sends it elsewhere.
    offset: (routes + 1,) int64
        Where a route begins.
    limit_m_per_s: (places,) float64
        Speed limit.
    movement: (places,) int64
        Intersection × movements + movement of the next movement on the route that a controller
        governs; −1 after the last one.
    own: (places,) bool
        Whether the place's own link leads to it, and no junction without signals lies in between.
    ahead_m, ahead_s: (places,) float64
        From the beginning of the link to its stop line, length and time of free flow.
    passed: (places,) int64
        Governed movements crossed before the place.
    """

    route: LongArray
    offset: LongArray
    limit_m_per_s: FloatArray
    movement: LongArray
    own: BoolArray
    ahead_m: FloatArray
    ahead_s: FloatArray
    passed: LongArray


def build_ways(network: RoadNetwork, vehicles: Vehicles) -> RouteGeometry:
    """Look ahead along all routes (ours)."""
    offset = vehicles.route_offset.astype(np.int64)
    return _ways(network, np.arange(len(vehicles)), offset, vehicles.route_links.astype(np.int64))


def rerouted(
    network: RoadNetwork, ways: RouteGeometry, routes: Mapping[int, Sequence[str]]
) -> RouteGeometry:
    """Return the ways after SUMO has sent some vehicles elsewhere (ours).

    ``routes`` has the ids of the edges that SUMO says a vehicle drives, from its first. One that
    the network does not have for vehicles counts as a link on which nobody is counted.
    """
    known, elsewhere = network.link_index, len(network.links)
    links = [[known.get(edge, elsewhere) for edge in edges] for edges in routes.values()]
    offset = np.cumsum([0, *map(len, links)])
    route = ways.route.copy()
    route[list(routes)] = np.arange(len(links)) + len(ways.offset) - 1
    new = _ways(network, route, offset, np.concatenate(links).astype(np.int64))
    joined = {
        name: np.concatenate([getattr(ways, name), getattr(new, name)])
        for name in RouteGeometry._fields
    }
    joined["offset"] = np.concatenate([ways.offset, ways.offset[-1] + offset[1:]])
    return RouteGeometry(**{**joined, "route": route})


def _ways(
    network: RoadNetwork, route: LongArray, offset: LongArray, link: LongArray
) -> RouteGeometry:
    """Look ahead along routes; link ``len(network.links)`` stands for those not in the network."""
    movement = _movements(network, offset, link)
    length_m = np.array([*(item.length_m for item in network.links), 0.0])
    limit_m_per_s = np.array([*(item.speed_m_per_s for item in network.links), np.inf])
    free_flow_s = np.append(network.free_flow_time_s, 0.0)
    governed = np.concatenate([movement >= 0, [False]])
    # The next governed movement at or after a place, then only if it lies on the same route.
    following = np.where(governed, np.arange(governed.size), governed.size - 1)
    following = np.minimum.accumulate(following[::-1])[::-1][:-1]
    end = np.repeat(offset[1:], np.diff(offset))
    there = (following < end) & (link < len(network.links))
    last = np.where(there, following, np.arange(link.size))
    to_m = np.concatenate([[0.0], np.cumsum(length_m[link])])
    to_s = np.concatenate([[0.0], np.cumsum(free_flow_s[link])])
    crossed = np.concatenate([[0], np.cumsum(governed[:-1])])
    start = np.repeat(offset[:-1], np.diff(offset))
    return RouteGeometry(
        route=route,
        offset=offset,
        limit_m_per_s=limit_m_per_s[link],
        movement=np.where(there, np.append(movement, -1)[following], -1),
        own=there & (following == np.arange(link.size)),
        ahead_m=to_m[last + 1] - to_m[:-1],
        ahead_s=to_s[last + 1] - to_s[:-1],
        passed=crossed[:-1] - crossed[start],
    )


def count_vehicles(
    ways: RouteGeometry,
    seen: FloatArray,
    shape: tuple[int, int],
    *,
    within_s: int,
    detection_m: float,
) -> tuple[IntArray, IntArray, int]:
    """Count vehicles that halt before a stop line, and those that reach it soon (ours).

    A vehicle counts if it is on the link that leads to the stop line, or on one before it with only
    junctions without signals in between and at most ``detection_m`` away.

    Parameters
    ----------
    ways
        Routes of all vehicles.
    seen: (5, vehicles in the network) float64
        Vehicle, index on its route of the link that it is on or has left, position on its lane in
        m, speed in m/s (negative where there is none), whether it is on a junction.
    shape
        Intersections and movements.
    within_s
        A moving vehicle counts as approaching if it is nearer than this in free flow.
    detection_m
        How far detectors reach beyond the incoming link.

    Returns
    -------
    queue_veh, approaching_veh: (intersections, movements) int32
    halting_veh: int
        Vehicles that halt anywhere in the network.
    """
    queue, approaching = np.zeros(shape, np.int32), np.zeros(shape, np.int32)
    halting = _count(ways, seen, queue.ravel(), approaching.ravel(), within_s, detection_m)
    return queue, approaching, halting


@kernel
def reached_stop_lines(ways: RouteGeometry, seen: FloatArray) -> int:
    """Return how many links to a governed movement the vehicles have come to, in all (ours)."""
    reached = 0
    for k in range(seen.shape[1]):
        place = _place(ways, seen, k)
        reached += ways.passed[place] + ways.own[place]
    return reached


@kernel
def _count(
    ways: RouteGeometry,
    seen: FloatArray,
    queue: IntArray,
    approaching: IntArray,
    within_s: int,
    detection_m: float,
) -> int:
    """Add vehicles to the counts of their movements; return how many halt."""
    halting = 0
    for k in range(seen.shape[1]):
        place, speed = _place(ways, seen, k), seen[3, k]
        halts = 0 <= speed < HALTING_M_PER_S
        halting += halts
        # Who is on a junction is at the beginning of the link behind it.
        position_m = 0.0 if seen[4, k] else seen[2, k]
        away_m = ways.ahead_m[place] - position_m
        if ways.movement[place] < 0 or not (ways.own[place] or away_m <= detection_m):
            continue
        away_s = ways.ahead_s[place] - position_m / ways.limit_m_per_s[place]
        if halts:
            queue[ways.movement[place]] += 1
        elif speed >= HALTING_M_PER_S and away_s <= within_s:
            approaching[ways.movement[place]] += 1
    return halting


@kernel
def _place(ways: RouteGeometry, seen: FloatArray, k: int) -> int:
    """Return where on its route a vehicle is; on a junction the place of the link behind it."""
    route = ways.route[int(seen[0, k])]
    place: int = ways.offset[route] + int(seen[1, k]) + int(seen[4, k])
    last: int = ways.offset[route + 1] - 1
    return min(place, last)


def passed_in_all(ways: RouteGeometry, vehicle: LongArray) -> int:
    """Return how many governed movements lie on the routes of some vehicles, in all (ours)."""
    return int(ways.passed[ways.offset[ways.route[vehicle] + 1] - 1].sum())


def _movements(network: RoadNetwork, offset: LongArray, link: LongArray) -> LongArray:
    """Return the governed movement at the end of every link of every route; −1 if none."""
    width = max(len(item.movements) for item in network.intersections)
    links = len(network.links) + 1
    pairs = {
        a * links + b: i * width + j for (a, b), (i, j) in sorted(network.movement_index.items())
    }
    keys = np.fromiter(pairs.keys(), np.int64, len(pairs))
    movements = np.fromiter(pairs.values(), np.int64, len(pairs))
    wanted = link * links
    wanted[:-1] += link[1:]
    wanted[offset[1:] - 1] = -1
    found = np.minimum(np.searchsorted(keys, wanted), keys.size - 1)
    return np.where(keys[found] == wanted, movements[found], -1)


class Crossings:
    """Follows all vehicles of a run, of which there are ``vehicles``, along their routes (ours).

    They are seen at decisions only: one that enters and arrives between two of them is missed.
    """

    def __init__(self, vehicles: int) -> None:
        self._links_behind = np.zeros(vehicles, np.int64)
        self._there = np.zeros(vehicles, np.bool_)

    def see(self, ways: RouteGeometry, seen: FloatArray) -> None:
        """Take in where the vehicles of the network are, see `count_vehicles`."""
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

        ``movements`` is the number of movements of the intersection with the most.
        """
        # Of a route that SUMO has replaced nothing counts: the new one begins with its past.
        links_behind = np.zeros(ways.offset.size - 1, np.int64)
        links_behind[ways.route] = self._links_behind
        behind = np.repeat(ways.offset[:-1] + links_behind, np.diff(ways.offset))
        crossed = ways.own & (np.arange(ways.movement.size) < behind)
        return np.bincount(ways.movement[crossed] // movements, minlength=intersections)
