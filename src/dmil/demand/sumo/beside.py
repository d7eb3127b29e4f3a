"""What SUMO runs beside the vehicles that both simulators drive: bicycles, trams, persons, stops.

The queue simulator knows none of it. In SUMO it is traffic that others meet: nothing is measured of
vehicles whose id is no number.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement

from dmil.demand.sumo.acting import acts_in_sumo, names_device
from dmil.demand.sumo.departures import Drawn, Listed
from dmil.demand.sumo.entry import DemandEntry, lines_of, seconds_of, text_of
from dmil.demand.sumo.types import VehicleTypes

PLACES = ("busStop", "trainStop", "containerStop", "chargingStation", "parkingArea")
"""Elements that stops name."""
FOLLOWED = ("rerouter", "variableSpeedSign")
"""Elements that act on vehicles in SUMO alone."""
_PREFIX = "beside:"
_TIMES = ("id", "depart", "begin", "end", "number", "period", "vehsPerHour", "perHour")
_WAITS = ("triggered", "expected", "expectedContainers", "containerTriggered", "join", "split")
_SHIFTED = ("until", "arrival")


@dataclass(frozen=True, slots=True)
class Beside:
    """What SUMO is told beside roads, signals and the vehicles of the demand (ours).

    Parameters
    ----------
    definitions_xml
        Stopping places, routes, rerouters and signs, as XML elements without a root element.
    vehicles_xml
        Vehicles that the demand does not have, in order of departure, likewise.
    types_xml
        The vehicle types, with the devices that SUMO alone acts on, likewise.
    inner_xml
        What stands in ``<vehicle>`` after the route, for every kind of the demand's.
    """

    definitions_xml: str = ""
    vehicles_xml: str = ""
    types_xml: str = ""
    inner_xml: tuple[str, ...] = ()


NOTHING = Beside()


@dataclass(frozen=True, slots=True)
class Stops:
    """The stops of a vehicle (ours).

    Parameters
    ----------
    elements
        As in the file, those of its route first.
    edges
        Where they are, in their order; None if that is not known.
    """

    elements: tuple[Element, ...]
    edges: tuple[str, ...] | None

    @property
    def timed(self) -> bool:
        """Whether one names a time of its own, which is another for each vehicle of a flow."""
        return any(name in each.attrib for each in self.elements for name in _SHIFTED)

    def lie_on(self, edges: Sequence[str]) -> bool:
        """Tell whether a vehicle on a route of these edges comes past all of them in order."""
        place = 0
        for edge in self.edges or ():
            if edge not in edges[place:]:
                return False
            place += edges[place:].index(edge)
        return self.edges is not None

    def xml(self, later_s: float = 0.0) -> str:
        """Return them as XML elements for a vehicle that departs so much later than the first."""
        text = ""
        for each in self.elements:
            text += text_of(Element("stop", {**each.attrib, **_moved(each, later_s)}))
        return text


class Collector:
    """Collects what stands beside the demand while files are read (ours)."""

    def __init__(self) -> None:
        self._places: dict[str, str] = {}
        self._routes: dict[str, Element] = {}
        self._used: dict[str, None] = {}
        self._definitions: list[str] = []
        self._acting: list[str] = []
        self._vehicles: list[tuple[float, str]] = []

    def define(self, entry: DemandEntry) -> None:
        """Take up a stopping place, a route, or what acts on vehicles in SUMO alone."""
        element = entry.element
        if element.tag in PLACES:
            self._places[entry.id] = _edge(element.get("lane", ""))
            self._definitions.append(text_of(element))
        elif element.tag in FOLLOWED:
            followed = deepcopy(element)
            if "file" in element.attrib:
                folder = Path(entry.place.path).parent.resolve()
                followed.set("file", str(folder / element.attrib["file"]))
            self._acting.append(text_of(followed))
            for each in element.iter("routeProbReroute"):
                self._use(each.get("id", ""))
        elif entry.id:
            self._routes[entry.id] = element

    def stops(self, entry: DemandEntry) -> Stops | None:
        """Return the stops of a vehicle, trip or flow and of its route; None without any (ours)."""
        route = self._routes.get(entry.get("route") or "")
        routes = [route] if route is not None else []
        routes += [child for child in entry.element if child.tag.startswith("route")]
        own = entry.element.findall("stop")
        found = [stop for each in routes for stop in each.iter("stop")] + own
        if not found:
            return None
        edges: list[str] = []
        several = any(each.tag == "routeDistribution" for each in routes) and found != own
        for stop in found:
            names = [stop.get(place) for place in PLACES]
            place = next((self._places.get(name) for name in names if name), None)
            edge = place or stop.get("edge") or _edge(stop.get("lane", ""))
            waits = any(stop.get(name) not in (None, "false", "0") for name in _WAITS)
            timed = stop.get("duration") or stop.get("until")
            if not edge or waits or not timed or several:
                return Stops(tuple(found), None)
            edges.append(edge)
        return Stops(tuple(found), tuple(edges))

    def drive(self, entry: DemandEntry, departures: Listed | Drawn) -> None:
        """Let SUMO drive the vehicles of an element, as often and when they depart (ours)."""
        if not departures.mean_veh:
            return
        element = deepcopy(entry.element)
        self._use(element.get("route", ""))
        for child in element:
            if child.tag == "routeDistribution":
                for name in (child.get("routes") or "").split():
                    self._use(name)
            self._use(child.get("refId", ""))
        for parameter in filter(names_device, element.findall("param")):
            if not acts_in_sumo(parameter):
                element.remove(parameter)
        stops = self.stops(entry)
        for name in _TIMES:
            element.attrib.pop(name, None)
        if isinstance(departures, Drawn):
            self._flow(entry, element, departures)
            return
        element.attrib.pop("probability", None)
        element.tag = "vehicle" if _has_route(element) else "trip"
        first_s = departures.first_s
        if stops and stops.timed:
            _set_inside(element, self._routes.get(element.attrib.get("route", "")))
        for depart_s in departures.depart_s.tolist():
            each = deepcopy(element)
            each.set("id", self._id(entry))
            each.set("depart", f"{depart_s:.3f}")
            if stops and stops.timed:
                for stop in each.iter("stop"):
                    stop.attrib.update(_moved(stop, depart_s - first_s))
            self._vehicles.append((depart_s, text_of(each)))

    def _id(self, entry: DemandEntry) -> str:
        """Return an id that no other vehicle has: of a distribution several kinds share one."""
        return f"{_PREFIX}{entry.id}.{len(self._vehicles)}"

    def _flow(self, entry: DemandEntry, element: Element, drawn: Drawn) -> None:
        """Leave departures at random to SUMO."""
        element.tag = "flow"
        rate = drawn.rate_per_s * drawn.scale
        element.set("id", self._id(entry))
        element.set("begin", f"{drawn.begin_s:.3f}")
        element.attrib.pop("probability", None)
        if drawn.each_second:
            element.set("probability", repr(min(1.0, rate)))
        else:
            element.set("period", f"exp({rate!r})")
        if drawn.number is None:
            element.set("end", f"{drawn.end_s:.3f}")
        else:
            element.set("number", str(drawn.number))
        self._vehicles.append((drawn.begin_s, text_of(element)))

    def found(self, types_xml: str, inner_xml: tuple[str, ...]) -> Beside:
        """Return what was collected, together with the types and inner elements, see `Beside`."""
        routes = [text_of(self._routes[name]) for name in self._used]
        return Beside(
            definitions_xml=lines_of([*self._definitions, *routes, *self._acting]),
            vehicles_xml=lines_of([text for _, text in sorted(self._vehicles, key=lambda v: v[0])]),
            types_xml=types_xml,
            inner_xml=inner_xml,
        )

    def _use(self, name: str) -> None:
        """Note that a route is needed, behind those that it names itself."""
        route = self._routes.get(name)
        if route is None or name in self._used:
            return
        inner = [route.get("refId", ""), *(route.get("routes") or "").split()]
        for each in [*inner, *(child.get("refId", "") for child in route)]:
            self._use(each)
        self._used[name] = None


def through(entry: DemandEntry, edges: Sequence[str]) -> DemandEntry:
    """Return a trip that goes by way of the edges where it stops, as in SUMO.

    One with a route stays as it is.
    """
    if _has_route(entry.element):
        return entry
    via = (entry.get("via") or "").split()
    ends = {entry.get("from"), entry.get("to"), *via}
    further = [edge for edge in dict.fromkeys(edges) if edge not in ends]
    if not further:
        return entry
    element = deepcopy(entry.element)
    element.set("via", " ".join([*via, *further]))
    return DemandEntry(entry.place, element)


def devices_xml(element: Element) -> str:
    """Return a vehicle's own parameters about devices that SUMO alone acts on (ours)."""
    return "".join(text_of(each) for each in element.findall("param") if acts_in_sumo(each))


def _set_inside(element: Element, route: Element | None) -> None:
    """Write a route that a vehicle names into it, so that its stops have times of their own."""
    if route is not None and route.tag == "route" and "edges" in route.attrib:
        del element.attrib["route"]
        inside = deepcopy(route)
        inside.attrib.pop("id", None)
        element.insert(0, inside)


def _moved(stop: Element, later_s: float) -> dict[str, str]:
    times = {name: seconds_of(stop.attrib[name]) for name in _SHIFTED if name in stop.attrib}
    return {name: f"{at_s + later_s:g}" for name, at_s in times.items() if at_s is not None}


def _has_route(element: Element) -> bool:
    return "route" in element.attrib or any(child.tag.startswith("route") for child in element)


def _edge(lane: str) -> str:
    return lane.rpartition("_")[0]


_WHO = frozenset({"id", "type", "depart", "departPos", "departPosLat", "speedFactor", "color"})
_FLOW = (_WHO - {"depart"}) | {
    *("begin", "end", "period", "perHour", "personsPerHour", "vehsPerHour", "probability", "number")
}
_WALK = frozenset(
    {"edges", "from", "to", "fromJunction", "toJunction", "duration", "speed", "departPos"}
    | {"departPosLat", "departLane", "arrivalPos", "arrivalPosLat"}
)
_WAIT = frozenset({"lane", "edge", "startPos", "endPos", "friendlyPos", "duration", "until"})
_STAGES = {"walk": _WALK, "personTrip": _WALK, "stop": _WAIT | {"actType"}}
"""What a person may do without a vehicle and without a place of an additional file."""


class Persons:
    """The persons of all files, who walk: vehicles meet them, and they wait for green (ours)."""

    def __init__(self) -> None:
        self._found: list[tuple[float, str]] = []
        self._ids: set[str] = set()

    @property
    def xml(self) -> str:
        """The elements in the order of departure, one a line, without a root element."""
        ordered = sorted(self._found, key=lambda each: each[0])
        return lines_of(text for _, text in ordered)

    def take(self, entry: DemandEntry, types: VehicleTypes) -> str:
        """Take up a ``<person>`` or ``<personFlow>``; return the kind of remark that it is.

        That is ``person`` if it only walks, else ``person-elsewhere``: who rides, or goes to a stop
        or a place of an additional file, is left out.

        Raises
        ------
        DemandError
            If there is another one of its id, its type is not defined before it, or a time is none.
        """
        name = entry.required("id")
        if name in self._ids:
            raise entry.error("there is another person of this id", mend="rename one of them")
        self._ids.add(name)
        if entry.get("type"):
            types.of(entry)
        element = _walking(entry)
        if element is None:
            return "person-elsewhere"
        first_s = entry.seconds("depart" if element.tag == "person" else "begin", 0.0)
        self._found.append((first_s or 0.0, text_of(element)))
        return "person"


def _walking(entry: DemandEntry) -> Element | None:
    """Copy what is known of an element; None if it says more than walking."""
    given = entry.element
    known = _WHO if given.tag == "person" else _FLOW
    stages = [child for child in given if child.tag != "param"]
    if not stages or not known.issuperset(given.attrib) or given.get("depart") == "triggered":
        return None
    if any(not _STAGES.get(each.tag, frozenset()).issuperset(each.attrib) for each in stages):
        return None
    copy = Element(given.tag, given.attrib)
    for each in stages:
        SubElement(copy, each.tag, each.attrib)
    return copy
