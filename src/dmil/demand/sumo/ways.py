"""Which links vehicles drive along: routes, distributions of routes, and trips."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from itertools import pairwise

from dmil.demand.recorded import first_gap
from dmil.demand.routes import Way, router
from dmil.demand.sumo.entry import DemandEntry
from dmil.demand.sumo.types import probabilities
from dmil.network import RoadNetwork
from dmil.network.permissions import Classes

Choice = tuple[Way, ...]
"""Routes of link indices, each with the probability that a vehicle takes it."""
Ends = tuple[tuple[str, str], ...]
"""What a trip says of its way: attributes of ``<trip>`` and their values."""

_ENDS = ("from", "to", "fromJunction", "toJunction", "via")


@dataclass(frozen=True, slots=True)
class Unusable:
    """Why vehicles cannot drive a route: the kind of remark, and the edge or junction (ours)."""

    kind: str
    road: str


def ends_of(entry: DemandEntry) -> Ends | None:
    """Return from where to where a vehicle, trip or flow goes, None if it has a route (ours)."""
    if entry.get("route") is not None or any(
        child.tag in ("route", "routeDistribution") for child in entry.element
    ):
        return None
    return tuple((name, entry.element.attrib[name]) for name in _ENDS if entry.get(name))


class Ways:
    """Finds the routes of vehicles on a network (ours)."""

    def __init__(self, network: RoadNetwork) -> None:
        self._network = network
        self._routes: dict[str, Choice | Unusable] = {}
        self._edges: dict[tuple[str, int], Choice | Unusable] = {}
        self._trips: dict[tuple[Classes, *tuple[str | None, ...]], Choice | Unusable] = {}
        self._gaps: dict[tuple[Classes, tuple[int, ...]], int | None] = {}
        self._out_of: defaultdict[str, list[int]] = defaultdict(list)
        self._into: defaultdict[str, list[int]] = defaultdict(list)
        for index, link in enumerate(network.links):
            self._out_of[link.start].append(index)
            self._into[link.end].append(index)

    def define(self, entry: DemandEntry) -> None:
        """Take up a ``<route>`` or ``<routeDistribution>`` that vehicles name by its id.

        Raises
        ------
        DemandError
            If it has no id or one that exists, or something in it is missing.
        """
        name = entry.required("id")
        if name in self._routes:
            raise entry.error(
                "there is another route of this id", mend="rename or remove one of them"
            )
        self._routes[name] = self._defined(entry)

    def of(self, entry: DemandEntry, classes: Classes) -> Choice | Unusable:
        """Return the ways of a vehicle, trip or flow, if vehicles of its classes may take them.

        Raises
        ------
        DemandError
            If it names a route that is not defined before it, or none at all.
        """
        choice = self._choice(entry, classes)
        if isinstance(choice, Unusable):
            return choice
        for links, _ in choice:
            key = classes, links
            if key not in self._gaps:
                self._gaps[key] = first_gap(self._network, links, classes)
            gap = self._gaps[key]
            if gap is not None:
                return Unusable("no-way", self._network.links[links[gap]].id)
        return choice

    def _choice(self, entry: DemandEntry, classes: Classes) -> Choice | Unusable:
        name = entry.get("route")
        if name is not None:
            return self._named(entry, name)
        for child in entry.element:
            if child.tag in ("route", "routeDistribution"):
                return self._defined(DemandEntry(entry.place, child))
        return self._trip(entry, classes)

    def _named(self, entry: DemandEntry, name: str) -> Choice | Unusable:
        if name not in self._routes:
            raise entry.error(
                f"there is no route '{name}'",
                expected="one that is defined before it",
                mend="move the route in front of it, or name the file that has it",
            )
        return self._routes[name]

    def _defined(self, entry: DemandEntry) -> Choice | Unusable:
        if entry.element.tag == "route":
            if "edges" not in entry.element.attrib and entry.get("refId"):
                return self._named(entry, entry.required("refId"))
            return self._along(entry)
        members: list[tuple[Choice | Unusable, float]] = []
        for child in entry.element.findall("route"):
            member = DemandEntry(entry.place, child)
            weight = member.number("probability") if "probability" in child.attrib else 1.0
            members.append((self._defined(member), weight))
            if member.id:
                self._routes.setdefault(member.id, members[-1][0])
        names = (entry.get("routes") or "").split()
        weights = probabilities(entry, len(names))
        members += [(self._named(entry, name), w) for name, w in zip(names, weights, strict=True)]
        total = sum(weight for _, weight in members)
        if not total > 0:
            raise entry.error("it has no routes", expected="at least one of a probability above 0")
        joined: list[Way] = []
        for choice, weight in members:
            if isinstance(choice, Unusable):
                return choice
            joined += [(links, share * weight / total) for links, share in choice if weight]
        return tuple(joined)

    def _along(self, entry: DemandEntry) -> Choice | Unusable:
        """Return the route over the edges that an element lists."""
        text = entry.required("edges")
        repeat = int(entry.number("repeat", most=1000)) if entry.get("repeat") else 0
        if (text, repeat) not in self._edges:
            self._edges[text, repeat] = self._checked(text.split() * (1 + repeat))
        return self._edges[text, repeat]

    def _checked(self, edges: list[str]) -> Choice | Unusable:
        known = self._network.link_index
        for edge in edges:
            if edge not in known:
                return Unusable("unknown-road", edge)
        return ((tuple(known[edge] for edge in edges), 1.0),)

    def _trip(self, entry: DemandEntry, classes: Classes) -> Choice | Unusable:
        key = tuple(entry.get(name) for name in _ENDS)
        start, end = key[0] or key[2], key[1] or key[3]
        if start and end:
            if (classes, *key) not in self._trips:
                self._trips[classes, *key] = self._shortest(key, classes)
            return self._trips[classes, *key]
        zones = ("Taz", "XY", "LonLat")
        if any(
            f"{side}{zone}" in entry.element.attrib for side in ("from", "to") for zone in zones
        ):
            return Unusable("zone", "")
        if entry.element.find("stop") is not None:
            return Unusable("stops-only", start or "")
        raise entry.error(
            "it has no route" if not (start or end) else f"it has no '{'to' if start else 'from'}'",
            expected="a route, or from and to",
        )

    def _shortest(self, key: tuple[str | None, ...], classes: Classes) -> Choice | Unusable:
        """Return the fastest way of a trip at free flow, through its via edges."""
        start, end, start_node, end_node, via = key
        points: list[list[int]] = []
        for edge in (start, *(via or "").split(), end):
            if edge is not None:
                if edge not in self._network.link_index:
                    return Unusable("unknown-road", edge)
                points.append([self._network.link_index[edge]])
        if start is None and start_node is not None:
            if start_node not in self._out_of:
                return Unusable("unknown-road", start_node)
            points.insert(0, self._out_of[start_node])
        if end is None and end_node is not None:
            if end_node not in self._into:
                return Unusable("unknown-road", end_node)
            points.append(self._into[end_node])
        links: tuple[int, ...] = ()
        ways = router(self._network, classes)
        for starts, ends in pairwise(points):
            leg = ways.first_between(links[-1:] or starts, ends)
            if not leg:
                here = self._network.links[(links[-1:] or starts)[0]].id
                return Unusable("no-way", here)
            links += leg[1:] if links else leg
        return ((links, 1.0),)
