"""Shortest routes by free-flow time, listed for every pair of fringe nodes.

Where several continuations lie on a shortest route, straight on is preferred; else the vehicle's
coin, drawn in advance, decides. For ties that a coin alone decides see `dmil.demand.destinations`.
"""

from __future__ import annotations

import heapq
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np

from dmil.demand.vehicles import FloatArray, IntArray, LongArray
from dmil.network import RoadNetwork
from dmil.network.permissions import Classes

MOST_ALTERNATIVES = 64
"""Ties beyond this many routes per pair are cut: the first continuation is taken."""
MOST_KEPT = 5_000_000
"""Costs that a router keeps, about 40 bytes each; the oldest are forgotten and found again."""

Way = tuple[tuple[int, ...], float]
"""Link indices in order, and the probability that a vehicle takes them."""

UNREACHABLE = -1
"""Cost to an end that a link does not lead to."""


class Router:
    """Finds all shortest routes of a network, keeping what it has computed (ours).

    Costs are whole microseconds of free-flow time plus one per link: sums are exact, so that ties
    are ties, and of routes that take equally long the one over fewer links is the shorter.

    Parameters
    ----------
    network
        The roads.
    classes
        What the vehicles are, which decides where they may go.

    Attributes
    ----------
    cost: list of int
        One per link.
    entries, exits: dict
        Fringe node to the indices of the links that lead from it and to it.
    """

    def __init__(self, network: RoadNetwork, classes: Classes = frozenset()) -> None:
        self._successors = network.successors_for(classes)
        self.cost = [round(link.free_flow_time_s * 1e6) + 1 for link in network.links]
        self.exits: dict[str, list[int]] = {node: [] for node in network.fringe}
        self.entries: dict[str, list[int]] = {node: [] for node in network.fringe}
        for index in network.exit_links:
            self.exits[network.links[index].end].append(index)
        for index in network.entry_links:
            self.entries[network.links[index].start].append(index)
        self._predecessors: list[list[int]] = [[] for _ in network.links]
        for link, following in enumerate(self._successors):
            for successor, _ in following:
                self._predecessors[successor].append(link)
        self._remaining: dict[tuple[int, ...], list[int]] = {}

    def between_nodes(self, origin: str, destination: str) -> list[Way]:
        """Return the shortest routes between two fringe nodes as (link indices, probability)."""
        return self.between_links(self.entries[origin], self.exits[destination])

    def between_links(self, starts: list[int], ends: list[int]) -> list[Way]:
        """Return the shortest routes from any start link to any end link, both included.

        There is none if there is no way. The probabilities are those of a fair coin at every tie.
        """
        remaining = self.remaining_cost(tuple(ends))
        reachable = [link for link in starts if remaining[link] != UNREACHABLE]
        if not reachable:
            return []
        best = min(remaining[link] for link in reachable)
        first = [link for link in reachable if remaining[link] == best]
        open_routes: deque[Way] = deque(((link,), 1.0 / len(first)) for link in first)
        finished: list[Way] = []
        while open_routes:
            route, probability = open_routes.popleft()
            here = route[-1]
            if remaining[here] == self.cost[here]:
                finished.append((route, probability))
                continue
            choices = self._continuations(here, remaining)
            if len(open_routes) + len(finished) + len(choices) > MOST_ALTERNATIVES:
                choices = choices[:1]
            open_routes.extend(((*route, link), probability / len(choices)) for link in choices)
        return finished

    def first_between(self, starts: Sequence[int], ends: Sequence[int]) -> tuple[int, ...]:
        """Return one shortest route: the first start, and at every tie the first continuation.

        It begins with one of the starts and ends with one of the ends; empty if there is no way.
        """
        remaining = self.remaining_cost(tuple(ends))
        reachable = [link for link in starts if remaining[link] != UNREACHABLE]
        if not reachable:
            return ()
        route = [min(reachable, key=remaining.__getitem__)]
        while remaining[route[-1]] != self.cost[route[-1]]:
            route.append(self._continuations(route[-1], remaining)[0])
        return tuple(route)

    def _continuations(self, here: int, remaining: list[int]) -> list[int]:
        """Return the next links that lie on a shortest route, only the straight ones if any."""
        onward = remaining[here] - self.cost[here]
        shortest = [pair for pair in self._successors[here] if remaining[pair[0]] == onward]
        straight = [link for link, turn in shortest if turn == "straight"]
        return straight or [link for link, _ in shortest]

    def remaining_cost(self, ends: tuple[int, ...]) -> list[int]:
        """Return every link's cost to the nearest end, its own included (Dijkstra backwards).

        It is `UNREACHABLE` where no way leads to an end.
        """
        if ends in self._remaining:
            return self._remaining[ends]
        remaining = [UNREACHABLE] * len(self.cost)
        heap = [(self.cost[link], link) for link in ends]
        heapq.heapify(heap)
        while heap:
            cost, link = heapq.heappop(heap)
            if remaining[link] != UNREACHABLE:
                continue
            remaining[link] = cost
            for previous in self._predecessors[link]:
                if remaining[previous] == UNREACHABLE:
                    heapq.heappush(heap, (cost + self.cost[previous], previous))
        if len(self._remaining) * len(remaining) > MOST_KEPT:
            del self._remaining[next(iter(self._remaining))]
        self._remaining[ends] = remaining
        return remaining


@dataclass(frozen=True, slots=True, eq=False)
class RouteTable:
    """All routes between fringe nodes as arrays, so that many vehicles are routed at once (ours).

    Pairs are numbered origin by origin; origin f's pairs are ``pair_offset[f]`` to
    ``pair_offset[f + 1]`` (exclusive), one for every other fringe node that can be reached.

    Parameters
    ----------
    pair_offset
        (fringe + 1,) int64.
    threshold
        (alternatives,) float64, pair number plus cumulated probability of the alternative.
    link_offset, links
        Alternative a's route is ``links[link_offset[a]:link_offset[a + 1]]``.
    """

    pair_offset: LongArray
    threshold: FloatArray
    link_offset: LongArray
    links: IntArray


_ROUTERS: WeakKeyDictionary[RoadNetwork, dict[Classes, Router]] = WeakKeyDictionary()
_TABLES: WeakKeyDictionary[RoadNetwork, RouteTable] = WeakKeyDictionary()


def router(network: RoadNetwork, classes: Classes = frozenset()) -> Router:
    """Return the network's router for vehicles of some classes, made once (ours)."""
    routers = _ROUTERS.setdefault(network, {})
    if classes not in routers:
        routers[classes] = Router(network, classes)
    return routers[classes]


def route_table(network: RoadNetwork) -> RouteTable:
    """Return the routes between all fringe nodes of a network, computed once (ours)."""
    if network not in _TABLES:
        _TABLES[network] = _build_table(network)
    return _TABLES[network]


def _build_table(network: RoadNetwork) -> RouteTable:
    ways = router(network)
    pair_offset = [0]
    threshold: list[float] = []
    link_offset = [0]
    links: list[int] = []
    pairs = 0
    for origin in network.fringe:
        for destination in network.fringe:
            alternatives = ways.between_nodes(origin, destination)
            if origin == destination or not alternatives:
                continue
            below = 0.0
            for route, probability in alternatives:
                below += probability
                threshold.append(pairs + below)
                links.extend(route)
                link_offset.append(len(links))
            threshold[-1] = pairs + 1.0  # not a rounding error less
            pairs += 1
        pair_offset.append(pairs)
    return RouteTable(
        np.array(pair_offset, dtype=np.int64),
        np.array(threshold, dtype=np.float64),
        np.array(link_offset, dtype=np.int64),
        np.array(links, dtype=np.int32),
    )
