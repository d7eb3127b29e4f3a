"""Persons that walk: SUMO drives them, so that vehicles meet them and they wait for green."""

from __future__ import annotations

from xml.etree.ElementTree import Element, SubElement

from dmil.demand.sumo.entry import DemandEntry, lines_of, text_of
from dmil.demand.sumo.types import VehicleTypes

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
    """The persons of all files, as SUMO is told about them (ours)."""

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
