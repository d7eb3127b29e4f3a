"""Reader of SUMO's route files and of the vehicle types and routes in additional files."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from dmil.demand.recorded import FileDemand, in_order
from dmil.demand.sumo.acting import DEFINITIONS, device_kinds, names_device, switches
from dmil.demand.sumo.beside import (
    FOLLOWED,
    PLACES,
    Collector,
    Persons,
    Stops,
    devices_xml,
    through,
)
from dmil.demand.sumo.demand import Stream, SumoDemand
from dmil.demand.sumo.departures import Drawn, Listed, Quota, Turns, Window, within
from dmil.demand.sumo.entry import DemandEntry
from dmil.demand.sumo.flows import departure_of_vehicle, departures_of_flow
from dmil.demand.sumo.remarks import Remarks, nobody
from dmil.demand.sumo.types import VehicleType, VehicleTypes
from dmil.demand.sumo.ways import Ends, Unusable, Ways, ends_of
from dmil.errors import DemandError
from dmil.network import RoadNetwork
from dmil.network.permissions import Classes
from dmil.network.xml_file import iter_elements

VEHICLES = ("vehicle", "trip", "flow")
PERSONS = ("person", "personFlow")
ROOTS = ("routes", "additional")
ANOTHER_NETWORK = 0.9
"""Share of vehicles on unknown edges from which on the files belong to another network."""

_KEPT = (
    *("type", "color", "line", "departLane", "departPos", "departPosLat", "departSpeed"),
    *("arrivalLane", "arrivalPos", "arrivalPosLat", "arrivalSpeed"),
    *("speedFactor", "insertionChecks"),
)
_COUNTED = {**DEFINITIONS, "tlLogic": "signal-program"}
_READ = (
    *(*VEHICLES, "vType", "vTypeDistribution", "route", "routeDistribution"),
    *(*PERSONS, *PLACES, *_COUNTED),
)


def read_sumo_routes(
    paths: str | Path | Sequence[str | Path],
    network: RoadNetwork,
    *,
    additional: Sequence[str | Path] = (),
    begin_s: float = 0.0,
    end_s: float | None = None,
    scale: float = 1.0,
) -> SumoDemand:
    """Read the vehicles, trips and flows of SUMO's route files (ours).

    Trips, and flows that only say from where to where, drive the way that is fastest at free flow;
    `dmil.demand.sumo.routing.routed_by_sumo` lets them drive those of the traffic.
    Times are those of SUMO, departures are rounded up to whole seconds after ``begin_s``. Vehicles
    that the network has no way for are left out; the demand's remarks count them and whatever else
    is not as in SUMO. What acts on vehicles during the run: see `dmil.demand.sumo.acting`.

    Parameters
    ----------
    paths
        Route files (``.rou.xml``, ``.trips.xml``, ``.flows.xml``), gzipped or not.
    network
        The roads, from `dmil.network.sumo.read_sumo_network`.
    additional
        Files with further vehicle types, routes and vehicles, read first.
    begin_s
        SUMO's time at which a run begins: it is second 0 of the demand.
    end_s
        SUMO's time at which it ends; needed if a flow has no end.
    scale
        SUMO's option ``--scale``: a factor on all vehicles, beside those of their types.

    Raises
    ------
    DemandError
        If a file is missing, cut off, not XML or of another kind, says what SUMO would refuse,
        belongs to another network, or no vehicle is left that departs in time and can be driven.

    Notes
    -----
    SUMO looks for the fastest way of a trip when it departs, with small penalties for crossings
    without right of way, and refuses to run if a vehicle cannot be simulated.
    """
    files = [paths] if isinstance(paths, str | Path) else list(paths)
    reading = _Reading(network, Window(begin_s, end_s), scale)
    for path in additional:
        reading.read(path, in_order=False)
    for path in files:
        reading.read(path, in_order=True)
    return reading.demand(", ".join(map(str, files or additional)))


def has_vehicles(path: str | Path) -> bool:
    """Tell whether a route file or an additional one defines vehicles, trips or flows (ours).

    Raises
    ------
    DemandError
        If it is missing, unsafe or no XML up to the first of them.
    """
    return any(iter_elements(path, VEHICLES, root=ROOTS, error=DemandError))


class _Reading:
    """The state of one reading: what was defined, what departs, what was left out."""

    def __init__(self, network: RoadNetwork, window: Window, scale: float) -> None:
        self._network = network
        self._window = window
        self._scale, self._quota = scale, Quota()
        self._beside = Collector()
        self._types = VehicleTypes()
        self._ways = Ways(network)
        self._persons = Persons()
        self._remarks = Remarks()
        self._ids: set[tuple[str, str]] = set()
        self._kinds: dict[tuple[tuple[tuple[str, str], ...], str], int] = {}
        self._classes: list[Classes] = []
        self._depart_s: list[float] = []
        self._routes: list[tuple[int, ...]] = []
        self._kind: list[int] = []
        self._ends: list[Ends | None] = []
        self._streams: list[Stream] = []
        self._total_veh = 0
        self._unknown_veh = 0
        self._unknown: tuple[DemandEntry, str] | None = None
        self._first_s = math.inf
        self._veh_of_space_m: defaultdict[float, float] = defaultdict(float)
        self._turns: dict[str, Turns] = {}

    def read(self, path: str | Path, *, in_order: bool) -> None:
        """Take up all that a file defines; of a route file SUMO takes vehicles in order only."""
        latest_s = -math.inf
        for place, element in iter_elements(path, _READ, root=ROOTS, error=DemandError):
            entry = DemandEntry(place, element)
            if element.tag in VEHICLES:
                departures = self._departures(entry)
                if departures is None:
                    continue
                if in_order and departures.first_s < latest_s:
                    self._leave_out(entry, "unsorted", departures)
                    continue
                # Those of a public transport line do not count: SUMO reads lines ahead of time.
                if departures.mean_veh and not entry.get("line"):
                    latest_s = max(latest_s, departures.first_s)
                self._take(entry, departures)
            elif element.tag in ("vType", "vTypeDistribution"):
                self._types.define(entry)
            elif element.tag in ("route", "routeDistribution"):
                self._ways.define(entry)
                self._beside.define(entry)
            elif element.tag in PERSONS:
                self._remarks.add(self._persons.take(entry, self._types), entry.id)
            else:
                if element.tag in (*PLACES, *FOLLOWED):
                    self._beside.define(entry)
                # Signal programs of additional files are read with the network.
                if element.tag in _COUNTED and (in_order or element.tag != "tlLogic"):
                    self._remarks.add(_COUNTED[element.tag], entry.id)

    def _departures(self, entry: DemandEntry) -> Listed | Drawn | None:
        name = entry.required("id")
        # As in SUMO a flow and a vehicle may have one id: the flow's vehicles are numbered.
        sort = "flow" if entry.element.tag == "flow" else "vehicle"
        if (sort, name) in self._ids:
            raise entry.error(f"there is another {sort} of this id", mend="rename one of them")
        self._ids.add((sort, name))
        if sort == "flow":
            scale = self._scale * self._types.of(entry).scale
            found = departures_of_flow(entry, self._window, scale)
        else:
            found = departure_of_vehicle(entry, self._window)
        if found is None:
            self._leave_out(entry, "no-fixed-departure", None)
        return found

    def _take(self, entry: DemandEntry, departures: Listed | Drawn) -> None:
        """Take up a vehicle, trip or flow, of a distribution over classes each class by itself."""
        vehicle_type = self._types.of(entry)
        if isinstance(departures, Listed) and entry.element.tag != "flow":
            departures = self._scaled(departures, vehicle_type.scale)
        if not vehicle_type.members:
            self._take_of(vehicle_type, entry, departures)
            return
        names, shares, types = zip(*vehicle_type.members, strict=True)
        turns = self._turns.setdefault(entry.get("type") or "", Turns(shares, self._window))
        parts = turns.share_out(departures)
        for name, each, part in zip(names, types, parts, strict=True):
            self._take_of(each, entry.of_type(name), part)

    def _take_of(
        self, vehicle_type: VehicleType, entry: DemandEntry, departures: Listed | Drawn
    ) -> None:
        """Take up vehicles as far as they depart in time and can be driven."""
        if not vehicle_type.road:
            self._set_aside(entry, departures)
            return
        stops = self._beside.stops(entry)
        if stops and stops.edges and set(stops.edges) <= self._network.link_index.keys():
            entry = through(entry, stops.edges)
        choice = self._ways.of(entry, vehicle_type.classes)
        self._total_veh += _count(departures)
        if isinstance(choice, Unusable):
            if choice.kind == "unknown-road":
                self._unknown_veh += _count(departures)
                self._unknown = self._unknown or (entry, choice.road)
            self._leave_out(entry, choice.kind, departures, choice.road)
            return
        if departures.mean_veh:
            self._first_s = min(self._first_s, departures.first_s)
        inside = self._inside(entry, departures)
        if not inside.mean_veh:
            return
        if stops:
            links = self._network.links
            made = all(stops.lie_on([links[link].id for link in way]) for way, _ in choice)
            self._remarks.add("stops" if made else "stops-off", entry.id, _count(inside))
            stops = stops if made else None
        self._note_children(entry, vehicle_type, _count(inside))
        kind = self._kind_of(entry, vehicle_type.classes, stops)
        self._veh_of_space_m[vehicle_type.space_m] += inside.mean_veh
        if isinstance(inside, Drawn) or len(choice) > 1:
            self._streams.append(Stream(inside, choice, kind, ends_of(entry)))
            return
        self._depart_s.extend(inside.depart_s)
        self._routes.extend([choice[0][0]] * len(inside.depart_s))
        self._ends.extend([ends_of(entry)] * len(inside.depart_s))
        for depart_s in inside.depart_s.tolist():
            if stops and stops.timed:
                later_s = depart_s - departures.first_s
                kind = self._kind_of(entry, vehicle_type.classes, stops, later_s)
            self._kind.append(kind)

    def _set_aside(self, entry: DemandEntry, departures: Listed | Drawn) -> None:
        """Leave vehicles to SUMO that are none of the demand's."""
        if any(f"{side}Taz" in entry.element.attrib for side in ("from", "to")):
            self._leave_out(entry, "zone", departures)  # zones are not read
            return
        inside = self._inside(entry, departures)
        self._beside.drive(entry, inside)
        self._leave_out(entry, "no-road-vehicle", inside)

    def _inside(self, entry: DemandEntry, departures: Listed | Drawn) -> Listed | Drawn:
        """Leave out the departures before the beginning and those at or after the end."""
        inside, early, late = within(departures, self._window)
        self._remarks.add("before-begin", entry.id, early)
        self._remarks.add("after-end", entry.id, late)
        return inside

    def _scaled(self, departures: Listed, scale: float) -> Listed:
        """Let a vehicle depart as often as in SUMO, which loads none from before the beginning."""
        if departures.first_s < self._window.begin_s:
            return departures
        return Listed(np.repeat(departures.depart_s, self._quota.times(self._scale * scale)))

    def _note_children(self, entry: DemandEntry, vehicle_type: VehicleType, count: int) -> None:
        element = entry.element
        for kind in device_kinds({**vehicle_type.devices, **switches(element)}):
            self._remarks.add(kind, entry.id, count)
        if any(not names_device(parameter) for parameter in element.findall("param")):
            self._remarks.add("parameters", entry.id)
        if entry.get("departEdge") or entry.get("arrivalEdge"):
            self._remarks.add("route-part", entry.id)

    def _kind_of(
        self, entry: DemandEntry, classes: Classes, stops: Stops | None, later_s: float = 0.0
    ) -> int:
        given = tuple((name, entry.element.attrib[name]) for name in _KEPT if entry.get(name))
        inner = (stops.xml(later_s) if stops else "") + devices_xml(entry.element)
        if (given, inner) not in self._kinds:
            self._kinds[given, inner] = len(self._kinds)
            self._classes.append(classes)
        return self._kinds[given, inner]

    def _leave_out(
        self, entry: DemandEntry, kind: str, departures: Listed | Drawn | None, road: str = ""
    ) -> None:
        count = 1 if departures is None else _count(departures)
        self._remarks.add(kind, entry.id, count, place=road)

    def demand(self, where: str) -> SumoDemand:
        """Return what was read; a DemandError if nothing is left."""
        if self._unknown and self._unknown_veh >= ANOTHER_NETWORK * self._total_veh:
            entry, road = self._unknown
            raise entry.error(
                f"it goes over '{road}', which the network '{self._network.name}' does not have "
                f"for vehicles; so do {self._unknown_veh} of {self._total_veh} vehicles",
                expected="routes of this network",
                mend="check that network and routes belong together",
            )
        if not self._veh_of_space_m:
            remarks = self._remarks.all()
            raise nobody(where, self._window, self._first_s, len(self._ids), remarks)
        exact_s = np.round(np.array(self._depart_s) - self._window.begin_s, 3)
        recorded = in_order(np.ceil(exact_s), self._routes, self._kind)
        order = np.argsort(np.ceil(exact_s), kind="stable")
        ends = [self._ends[vehicle] for vehicle in order]
        return SumoDemand(
            recorded=FileDemand(self._network, recorded),
            streams=tuple(self._streams),
            begin_s=self._window.begin_s,
            kinds=tuple(dict(given) for given, _ in self._kinds),
            classes=tuple(self._classes),
            vehicle_types_xml=self._types.xml,
            persons_xml=self._persons.xml,
            vehicle_space_m=_mean(self._veh_of_space_m),
            remarks=self._remarks.all(),
            trips={vehicle: each for vehicle, each in enumerate(ends) if each is not None},
            exact_depart_s=exact_s[order],
            beside=self._beside.found(
                self._types.xml_for_sumo, tuple(inner for _, inner in self._kinds)
            ),
        )


def _count(departures: Listed | Drawn) -> int:
    """Return how many vehicles a remark counts; a flow that is drawn counts once."""
    return len(departures.depart_s) if isinstance(departures, Listed) else 1


def _mean(weights: Mapping[float, float]) -> float:
    total = sum(weight * value for value, weight in weights.items())
    return round(total / sum(weights.values()), 3)
