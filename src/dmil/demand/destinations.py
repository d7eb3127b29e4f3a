"""How many vehicles come from where, where they go, which of equally short ways they take."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal
from weakref import WeakKeyDictionary

import numpy as np

from dmil.demand.routes import UNREACHABLE, route_table, router
from dmil.demand.vehicles import FloatArray, IntArray, LongArray, Vehicles, gather
from dmil.errors import DemandError, unknown_name
from dmil.network import RoadNetwork

Ties = Literal["straight", "coin"]
"""What decides between continuations that all lie on a shortest route: straight on while that is
one of them, and a fair coin only without it; or the coin always."""
TIES: tuple[Ties, ...] = ("straight", "coin")

_NONE = -1
"""Fills rows of links that are shorter than others."""


@dataclass(frozen=True, slots=True, eq=False)
class RouteGraph:
    """Which links lead to which fringe node at what cost, for many vehicles at once (ours).

    Pairs are numbered as in `RouteTable`. The shortest routes are not listed: a corner of a 20×20
    grid has 35 thousand million of them to the other one.

    Parameters
    ----------
    pair_offset
        (fringe + 1,) int64, origin f's pairs are ``pair_offset[f]`` to ``pair_offset[f + 1]``.
    destination
        (pairs,) int64, index into the network's fringe.
    cost
        (links,) int64, see `Router`.
    remaining
        (fringe, links + 1) int64, cost from every link to every fringe node, both ends included;
        the last column stands for no link.
    entries
        (fringe, most entries of one) int32, links at which a route begins, then −1.
    following
        (links, most successors of one) int32, links after each link, then −1.
    """

    pair_offset: LongArray
    destination: LongArray
    cost: LongArray
    remaining: LongArray
    entries: IntArray
    following: IntArray


_GRAPHS: WeakKeyDictionary[RoadNetwork, RouteGraph] = WeakKeyDictionary()


def route_graph(network: RoadNetwork) -> RouteGraph:
    """Return the costs between all links and fringe nodes of a network, computed once (ours)."""
    if network not in _GRAPHS:
        _GRAPHS[network] = _build_graph(network)
    return _GRAPHS[network]


def draw_destinations(
    network: RoadNetwork,
    second: LongArray,
    origin: LongArray,
    rng: np.random.Generator,
    ties: Ties = "straight",
) -> Vehicles:
    """Draw destinations and coins, and give every vehicle its route (paper, §VI).

    A destination is uniform over the other fringe nodes that can be reached; it is the same for
    both kinds of ties. ``second`` and ``origin`` are (vehicles,): departures in seconds,
    non-decreasing, and indices into ``network.fringe``.
    """
    if ties == "coin":
        graph = route_graph(network)
        pair = rng.integers(graph.pair_offset[origin], graph.pair_offset[origin + 1])
        offset, links = _walk(graph, origin, graph.destination[pair], rng)
        return Vehicles(second.astype(np.int32), offset, links)
    table = route_table(network)
    pair = rng.integers(table.pair_offset[origin], table.pair_offset[origin + 1])
    coin = rng.random(len(pair))
    way = np.searchsorted(table.threshold, pair + coin, side="right")
    offset, place = gather(table.link_offset, way)
    return Vehicles(second.astype(np.int32), offset, table.links[place])


def _walk(
    graph: RouteGraph, origin: LongArray, destination: LongArray, rng: np.random.Generator
) -> tuple[IntArray, IntArray]:
    """Let all vehicles choose their links one after the other, all at once in each step.

    Of k links that lie on a shortest route each is taken with probability 1/k. Returns the offsets
    and links of `Vehicles`.
    """
    count = len(origin)
    length = np.zeros(count, dtype=np.int64)
    steps: list[tuple[LongArray, IntArray]] = []
    driving = np.arange(count)
    choices = graph.entries[origin]
    while len(driving):
        goal = destination[driving]
        cost = graph.remaining[goal[:, None], choices]
        # All links after one cost at least what is left after it, so the least is what is left.
        least = np.where(cost == UNREACHABLE, np.iinfo(np.int64).max, cost).min(axis=1)
        shortest = cost == least[:, None]
        rank = np.cumsum(shortest, axis=1)
        coin = rng.integers(rank[:, -1])
        taken = np.argmax(rank > coin[:, None], axis=1)
        link = choices[np.arange(len(driving)), taken]
        steps.append((driving, link))
        length[driving] += 1
        on = least != graph.cost[link]
        driving, choices = driving[on], graph.following[link[on]]
    offset = np.append(0, np.cumsum(length))
    links = np.empty(offset[-1], dtype=np.int32)
    for step, (vehicle, link) in enumerate(steps):
        links[offset[vehicle] + step] = link
    return offset.astype(np.int32), links


def _build_graph(network: RoadNetwork) -> RouteGraph:
    ways = router(network)
    remaining = np.full((len(network.fringe), len(network.links) + 1), UNREACHABLE, dtype=np.int64)
    for node, name in enumerate(network.fringe):
        remaining[node, :-1] = ways.remaining_cost(tuple(ways.exits[name]))
    entries = _padded([ways.entries[name] for name in network.fringe])
    reached = (remaining[:, entries] != UNREACHABLE).any(axis=2).T
    np.fill_diagonal(reached, False)
    return RouteGraph(
        pair_offset=np.append(0, np.cumsum(reached.sum(axis=1))),
        destination=np.nonzero(reached)[1],
        cost=np.array(ways.cost, dtype=np.int64),
        remaining=remaining,
        entries=entries,
        following=_padded([[link for link, _ in following] for following in network.successors]),
    )


def _padded(rows: list[list[int]]) -> IntArray:
    table = np.full((len(rows), max(map(len, rows), default=0)), _NONE, dtype=np.int32)
    for row, values in enumerate(rows):
        table[row, : len(values)] = values
    return table


PAPER_RATE_VEH_PER_MIN: Mapping[str, float] = {"E": 5.0, "N": 5.0, "W": 10.0, "S": 7.0}
"""Vehicles per minute and fringe node, by side of the network (paper, §VI)."""


def check_rates(rate_veh_per_min: Mapping[str, float]) -> None:
    """Check that rates, in vehicles per minute by fringe node or side, are usable on some network.

    Raises
    ------
    DemandError
        If there is none, or one is negative or not finite.
    """
    if not rate_veh_per_min:
        raise DemandError(
            "there are no rates",
            where="rate_veh_per_min",
            expected="vehicles per minute by fringe node or side",
            mend="write for example {'E': 5, 'W': 10}",
        )
    for place, rate in rate_veh_per_min.items():
        if not (math.isfinite(rate) and rate >= 0):
            raise DemandError(
                f"the rate is {rate} vehicles per minute",
                where=f"rate_veh_per_min['{place}']",
                expected="a number of 0 or more",
            )


def rates_at_fringe(network: RoadNetwork, rate_veh_per_min: Mapping[str, float]) -> FloatArray:
    """Return the rate of every node of ``network.fringe`` in vehicles per minute: (nodes,) float64.

    Rates are given by fringe node or side letter of a grid; who is not named sends nobody.

    Raises
    ------
    DemandError
        If the network has fewer than two fringe nodes, or vehicles would start where they can
        reach no other fringe node.
    UnknownNameError
        If a key is neither a fringe node nor a side.
    """
    fringe = network.fringe
    if len(fringe) < 2:
        raise DemandError(
            f"the network has {len(fringe)} fringe nodes",
            where=network.name,
            expected="at least two, to come from and to go to",
        )
    sides = [node[0] if node[:1] in "ENWS" and node[1:].isdecimal() else "" for node in fringe]
    unknown = rate_veh_per_min.keys() - set(fringe) - set(sides)
    if unknown:
        raise unknown_name(
            "fringe node or side",
            min(unknown),
            {*fringe, *sides} - {""},
            where=f"rate_veh_per_min on {network.name}",
        )
    rates = np.array(
        [
            rate_veh_per_min.get(node, rate_veh_per_min.get(side, 0.0))
            for node, side in zip(fringe, sides, strict=True)
        ],
        dtype=np.float64,
    )
    stuck = (rates > 0) & (np.diff(route_graph(network).pair_offset) == 0)
    if stuck.any():
        node = fringe[int(np.argmax(stuck))]
        raise DemandError(
            f"vehicles starting at '{node}' can reach no other fringe node",
            where=f"rate_veh_per_min on {network.name}",
            mend=f"set the rate of '{node}' to 0, or add the missing movements to the network",
        )
    return rates
