"""The way between roads that a route only names as anchor points, as CityFlow's router finds it."""

from __future__ import annotations

import heapq
from collections.abc import Sequence
from itertools import pairwise

from dmil.network import RoadNetwork
from dmil.network.cityflow import CityflowNetwork


class AnchorRouter:
    """Joins anchor points by shortest ways (CityFlow, ``src/vehicle/router.cpp``).

    Parameters
    ----------
    network
        The roads. On one that is not CityFlow's, roads are as long as their links and are tried in
        the order of the movements.

    Notes
    -----
    A way is as long as all its roads but the first, each as long as its lanes in the mean. Of two
    ways equally long the one stays that was found first; roads equally far are taken from the heap
    as GCC's ``std::priority_queue`` does, which Python's ``heapq`` does alike.
    """

    def __init__(self, network: RoadNetwork) -> None:
        if isinstance(network, CityflowNetwork):
            self._length_m: Sequence[float] = network.lane_length_m
            self._followers: Sequence[Sequence[int]] = network.followers
        else:
            self._length_m = [link.length_m for link in network.links]
            self._followers = [[link for link, _ in pairs] for pairs in network.successors]
        self._known: dict[tuple[int, int], list[int]] = {}

    def way(self, anchors: Sequence[int]) -> list[int]:
        """Return the links of a route, the anchors among them.

        Parameters
        ----------
        anchors
            Link indices; one that comes twice in a row counts once.

        Returns
        -------
        list of int
            Link indices in order; empty if there is no way between two of them.
        """
        route = [anchors[0]]
        for start, end in pairwise(anchors):
            if start == end:
                continue
            if (start, end) not in self._known:
                self._known[start, end] = self._shortest(start, end)
            if not self._known[start, end]:
                return []
            route += self._known[start, end]
        return route

    def _shortest(self, start: int, end: int) -> list[int]:
        """Return the links after ``start`` up to ``end``, none if there is no way."""
        distance_m = {start: 0.0}
        before: dict[int, int] = {}
        done: set[int] = set()
        heap = [_Reached(0.0, start)]
        while heap:
            here = heap[0].link
            if here == end:
                break
            heapq.heappop(heap)
            if here in done:
                continue
            done.add(here)
            for link in self._followers[here]:
                found_m = distance_m[here] + self._length_m[link]
                if link not in distance_m or found_m < distance_m[link]:
                    before[link], distance_m[link] = here, found_m
                    heapq.heappush(heap, _Reached(found_m, link))
        else:
            return []
        way = [end]
        while before[way[-1]] != start:
            way.append(before[way[-1]])
        return way[::-1]


class _Reached:
    """A road and how far it is. Only that is compared: roads equally far have no order."""

    __slots__ = ("distance_m", "link")

    def __init__(self, distance_m: float, link: int) -> None:
        self.distance_m, self.link = distance_m, link

    def __lt__(self, other: _Reached) -> bool:
        return self.distance_m < other.distance_m
