"""Which movement a vehicle comes to next, and how far it is from that stop line."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dmil.demand import Vehicles
from dmil.network import RoadNetwork

IntArray = npt.NDArray[np.int32]
LongArray = npt.NDArray[np.int64]
FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

HALTING_M_PER_S = 0.1
"""Slower vehicles halt (SUMO's own threshold)."""


class Ways(NamedTuple):
    """For every link of every route: what comes next. A place is an index into the route links.

    Attributes
    ----------
    offset: (vehicles + 1,) int64
        Where a vehicle's route begins.
    limit_m_per_s: (places,) float64
        Speed limit.
    slot: (places,) int64
        Intersection × orientations + movement of the next movement on the route that a controller
        governs; −1 after the last one.
    own: (places,) bool
        Whether the place's own link leads to it, and no junction without signals lies in between.
    ahead_m, ahead_s: (places,) float64
        From the beginning of the link to its stop line, length and time of free flow.
    passed: (places,) int64
        Governed movements crossed before the place.
    """

    offset: LongArray
    limit_m_per_s: FloatArray
    slot: LongArray
    own: BoolArray
    ahead_m: FloatArray
    ahead_s: FloatArray
    passed: LongArray


class Seen(NamedTuple):
    """Where the vehicles in the network are.

    Attributes
    ----------
    vehicle: (seen,) int64
    place: (seen,) int64
        See `Ways`; on a junction that of the link behind it.
    position_m: (seen,) float64
        From the beginning of that link.
    speed_m_per_s: (seen,) float64
        Negative where there is none.
    """

    vehicle: LongArray
    place: LongArray
    position_m: FloatArray
    speed_m_per_s: FloatArray


def build_ways(network: RoadNetwork, vehicles: Vehicles) -> Ways:
    """Look ahead along all routes (ours)."""
    link, offset = vehicles.route_links, vehicles.route_offset
    slot = _slots(network, vehicles)
    length_m = np.array([item.length_m for item in network.links])
    limit_m_per_s = np.array([item.speed_m_per_s for item in network.links])
    governed = np.concatenate([slot >= 0, [False]])
    # The next governed movement at or after a place, then only if it lies on the same route.
    following = np.where(governed, np.arange(governed.size), governed.size - 1)
    following = np.minimum.accumulate(following[::-1])[::-1][:-1]
    end = np.repeat(offset[1:], np.diff(offset))
    there = following < end
    last = np.where(there, following, np.arange(link.size))
    to_m = np.concatenate([[0.0], np.cumsum(length_m[link])])
    to_s = np.concatenate([[0.0], np.cumsum(network.free_flow_time_s[link])])
    crossed = np.concatenate([[0], np.cumsum(governed[:-1])])
    start = np.repeat(offset[:-1], np.diff(offset))
    return Ways(
        offset=offset.astype(np.int64),
        limit_m_per_s=limit_m_per_s[link],
        slot=np.where(there, np.append(slot, -1)[following], -1),
        own=there & (following == np.arange(link.size)),
        ahead_m=to_m[last + 1] - to_m[:-1],
        ahead_s=to_s[last + 1] - to_s[:-1],
        passed=crossed[:-1] - crossed[start],
    )


def locate(ways: Ways, numbers: FloatArray) -> Seen:
    """Place vehicles on their routes (ours).

    Parameters
    ----------
    ways
        Of all vehicles.
    numbers: (5, seen) float64
        Vehicle, index on its route of the link that it is on or has left, position on its lane in
        m, speed in m/s, whether it is on a junction.
    """
    vehicle = numbers[0].astype(np.int64)
    on_junction = numbers[4]
    place = ways.offset[vehicle] + (numbers[1] + on_junction).astype(np.int64)
    place = np.minimum(place, ways.offset[vehicle + 1] - 1)
    return Seen(vehicle, place, numbers[2] * (1 - on_junction), numbers[3])


def count_vehicles(
    ways: Ways,
    seen: Seen,
    shape: tuple[int, int],
    *,
    within_s: int,
    detection_m: float,
) -> tuple[IntArray, IntArray]:
    """Count vehicles that halt before a stop line, and those that reach it soon (ours).

    A vehicle counts if it is on the link that leads to the stop line, or on one before it with only
    junctions without signals in between and at most ``detection_m`` away.

    Parameters
    ----------
    ways, seen
        Routes, and where on them the vehicles are.
    shape
        Intersections and orientations.
    within_s
        A moving vehicle counts as approaching if it is nearer than this in free flow.
    detection_m
        How far detectors reach beyond the incoming link.

    Returns
    -------
    queue_veh, approaching_veh: (intersections, orientations) int32
    """
    place = seen.place
    away_m = ways.ahead_m[place] - seen.position_m
    away_s = ways.ahead_s[place] - seen.position_m / ways.limit_m_per_s[place]
    near = (ways.slot[place] >= 0) & (ways.own[place] | (away_m <= detection_m))
    speed = seen.speed_m_per_s
    halting = near & (speed >= 0) & (speed < HALTING_M_PER_S)
    coming = near & (speed >= HALTING_M_PER_S) & (away_s <= within_s)
    size = shape[0] * shape[1]
    queue, approaching = (
        np.bincount(ways.slot[place[chosen]], minlength=size).reshape(shape).astype(np.int32)
        for chosen in (halting, coming)
    )
    return queue, approaching


def reached_stop_lines(ways: Ways, seen: Seen) -> int:
    """Return how many links to a governed movement the vehicles have come to, in all (ours)."""
    return int((ways.passed[seen.place] + ways.own[seen.place]).sum())


def _slots(network: RoadNetwork, vehicles: Vehicles) -> LongArray:
    """Return the governed movement at the end of every link of every route; −1 if none."""
    orientations = max(len(item.movements) for item in network.intersections)
    links = len(network.links)
    pairs = {a * links + b: i * orientations + j for (a, b), (i, j) in _sorted_pairs(network)}
    keys = np.fromiter(pairs.keys(), np.int64, len(pairs))
    slots = np.fromiter(pairs.values(), np.int64, len(pairs))
    link = vehicles.route_links.astype(np.int64)
    wanted = link * links
    wanted[:-1] += link[1:]
    wanted[vehicles.route_offset[1:] - 1] = -1
    found = np.minimum(np.searchsorted(keys, wanted), keys.size - 1)
    return np.where(keys[found] == wanted, slots[found], -1)


def _sorted_pairs(network: RoadNetwork) -> list[tuple[tuple[int, int], tuple[int, int]]]:
    return sorted(network.movement_index.items())
