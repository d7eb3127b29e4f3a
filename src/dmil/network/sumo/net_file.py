"""From a ``.net.xml`` to records: sumolib understands it, our own walk feeds and guards it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, SubElement

from dmil.errors import MissingExtraError, NetworkError
from dmil.network.lines import Point
from dmil.network.permissions import ALL_CLASSES, MOTOR_CLASSES, Classes, Permissions, permitted
from dmil.network.sumo.records import Connection, CrossingRecord, Edge, NetFile
from dmil.network.sumo.signal_programs import SignalPrograms
from dmil.network.xml_file import XmlWalk


def read_net_file(
    path: str | Path, *, additional: Sequence[str | Path] = (), begin_s: float = 0.0
) -> NetFile:
    """Read a SUMO network file (ours).

    Parameters
    ----------
    path
        The file, gzipped or not.
    additional
        Files with further signal programs and timetables of programs.
    begin_s
        SUMO's time at which a run begins; timetables depend on it.

    Raises
    ------
    NetworkError
        If it is missing, cut off, not XML, unsafe, no SUMO network, or names what does not exist.
    MissingExtraError
        If sumolib is not installed.
    """
    try:
        from sumolib.net import NetReader
    except ImportError:
        raise MissingExtraError("sumo") from None
    guard = _Guard(
        str(path), NetReader(withPrograms=False, withFoes=False), SignalPrograms(begin_s)
    )
    walk = XmlWalk(path, guard.start, guard.end, root=("net",), error=NetworkError)
    guard.walk = walk
    walk.run()
    guard.programs.read(additional)
    net = guard.reader.getNet()
    letters = {
        item.getID(): max((way[2] for way in item.getConnections()), default=-1)
        for item in net.getTrafficLights()
    }
    logics = guard.programs.used(letters, str(path))
    signals = {logic.id for logic in logics}
    edges = _edges(net, guard.permitted)
    return NetFile(
        path=str(path),
        edges=edges,
        permissions=_permissions(net, guard, edges),
        position_m=_positions(net, str(path)),
        connections=_connections(net, guard, signals, str(path)),
        logics=logics,
        foes=guard.foes,
        response=guard.response,
        foreign={
            name: guard.junction_type.get(name, "") for name in letters if name not in signals
        },
        added_programs_xml=guard.programs.added_xml,
        crossings=tuple(guard.crossings(net)),
        left_hand=guard.left_hand,
    )


@dataclass(slots=True)
class _Guard:
    """Hands the file's elements to sumolib, less what costs time, and keeps the matrices."""

    path: str
    reader: Any
    programs: SignalPrograms
    walk: XmlWalk | None = None
    left_hand: bool = False
    junction: str = ""
    lanes_into: dict[str, list[str]] = field(default_factory=dict)
    junction_type: dict[str, str] = field(default_factory=dict)
    logic: Element | None = None
    foes: dict[tuple[str, int], frozenset[int]] = field(default_factory=dict)
    response: dict[tuple[str, int], frozenset[int]] = field(default_factory=dict)
    _crossing: str = ""
    _length_m: dict[str, float] = field(default_factory=dict)
    _signalled: list[tuple[str, str, int]] = field(default_factory=list)
    permitted: dict[str, Classes] = field(default_factory=dict)
    """By lane, and by connection, which is named like its two lanes."""

    def permits(self, way: Any) -> Classes:
        """Return who may take a connection: who may use it and the lanes on both sides."""
        ends = way.getFromLane().getID(), way.getToLane().getID()
        return self.permitted[ends[0]] & self.permitted[ends[1]] & self.permitted[" ".join(ends)]

    def start(self, name: str, attributes: dict[str, str]) -> None:
        given = dict(attributes)
        try:
            if name == "request":
                self._request(attributes)
            elif name == "tlLogic":
                self.logic = Element(name, attributes)
            elif name == "phase" and self.logic is not None:
                SubElement(self.logic, name, attributes)
            elif name != "param":
                self._prepare(name, attributes)
                self.reader.startElement(name, attributes)
        except KeyError as cause:
            missing = cause.args[0]
            problem = f"its attribute '{missing}' is missing"
            if missing in given.values():
                problem = f"it names '{missing}', which is not in the file before it"
            raise self._error(name, given, problem) from None
        except IndexError:
            raise self._error(name, given, "it names a lane that does not exist") from None
        except (ValueError, OverflowError, AttributeError, TypeError) as cause:
            raise self._error(name, given, f"it cannot be understood ({cause})") from None

    def crossings(self, net: Any) -> Iterator[CrossingRecord]:
        """Return the crossings that controllers stop; their rows follow those of all ways."""
        for edge, signal, letter in self._signalled:
            junction, _, number = edge[1:].rpartition("_c")
            lanes = (
                _lane(net, lane, junction, self.path)
                for lane in self.lanes_into[junction]
                if not lane.startswith(":")
            )
            ways = sum(len(lane.getOutgoing()) for lane in lanes)
            yield CrossingRecord(signal, letter, junction, ways + int(number), self._length_m[edge])

    def end(self, name: str) -> None:
        if name == "tlLogic" and self.logic is not None:
            self.programs.define(self.logic, self.walk.place if self.walk else self.path)
            self.logic = None
        self.reader.endElement(name)

    def _prepare(self, name: str, attributes: dict[str, str]) -> None:
        if name == "net":
            self.left_hand = attributes.get("lefthand") in ("true", "1", "yes", "on")
        elif name == "edge":
            self._crossing = attributes["id"] if attributes.get("function") == "crossing" else ""
        elif name == "lane" and self._crossing:
            self._length_m[self._crossing] = float(attributes["length"])
        elif name == "connection" and "tl" in attributes and attributes["to"] in self._length_m:
            letter = int(attributes["linkIndex"])
            self._signalled.append((attributes["to"], attributes["tl"], letter))
        if name == "lane":
            self.permitted[attributes["id"]] = _permitted(attributes)
        elif name == "connection":
            ends = (f"{attributes[end]}_{attributes[f'{end}Lane']}" for end in ("from", "to"))
            through = self.permitted.get(attributes.get("via", ""), ALL_CLASSES)
            self.permitted[" ".join(ends)] = through & _permitted(attributes)
        if name in ("edge", "junction"):
            attributes.pop("shape", None)  # outlines: not needed, and slow to convert
        if name == "junction" and attributes.get("type") != "internal":
            self.junction = attributes["id"]
            self.lanes_into[self.junction] = attributes["incLanes"].split()
            self.junction_type[self.junction] = attributes.get("type", "")

    def _request(self, attributes: dict[str, str]) -> None:
        row = self.junction, int(attributes["index"])
        # The last letter is about row 0.
        self.foes[row], self.response[row] = (
            frozenset(k for k, letter in enumerate(reversed(attributes[name])) if letter == "1")
            for name in ("foes", "response")
        )

    def _error(self, name: str, attributes: dict[str, str], problem: str) -> NetworkError:
        names = " ".join(
            f'{key}="{attributes[key]}"' for key in ("id", "from") if key in attributes
        )
        return NetworkError(
            f"<{name}{' ' if names else ''}{names}>: {problem}",
            where=str(self.walk.place) if self.walk else self.path,
            expected="a SUMO network (<net>) as netconvert or netgenerate write it",
            mend="correct this, or rebuild the network with netconvert",
        )


def _permitted(attributes: dict[str, str]) -> Classes:
    return permitted(attributes.get("allow"), attributes.get("disallow"))


def _edges(net: Any, permissions: dict[str, Classes]) -> dict[str, Edge]:
    edges = {}
    for edge in net.getEdges(withInternal=False):
        lanes = edge.getLanes()
        allowed = tuple(permissions[lane.getID()] for lane in lanes)
        used = [lane for lane, each in zip(lanes, allowed, strict=True) if each & MOTOR_CLASSES]
        if used:
            edges[edge.getID()] = Edge(
                edge.getID(),
                edge.getFromNode().getID(),
                edge.getToNode().getID(),
                max(lane.getLength() for lane in used),
                max(lane.getSpeed() for lane in used),
                len(lanes),
                tuple(
                    point for point in used[-1].getShape() or () if all(map(math.isfinite, point))
                ),
                allowed,
            )
    return edges


def _permissions(net: Any, guard: _Guard, edges: dict[str, Edge]) -> Permissions:
    """Return who may use which lane of the edges, and go from which to which: bicycles, too."""
    ways: dict[tuple[str, str], dict[int, Classes]] = {}
    for name in edges:
        for lane in net.getEdge(name).getLanes():
            for way in lane.getOutgoing():
                there = way.getTo().getID()
                if there in edges:
                    lanes, index = ways.setdefault((name, there), {}), lane.getIndex()
                    lanes[index] = lanes.get(index, Classes()) | guard.permits(way)
    return Permissions({edge.id: edge.permitted for edge in edges.values()}, ways)


def _positions(net: Any, path: str) -> dict[str, Point]:
    positions = {}
    for node in net.getNodes():
        if node.getCoord3D() is None:
            raise NetworkError(
                f"there is no junction '{node.getID()}', but edges start or end there",
                where=path,
                mend="rebuild the network with netconvert",
            )
        positions[node.getID()] = node.getCoord()
    return positions


def _lane(net: Any, lane: str, junction: str, path: str) -> Any:
    try:
        return net.getLane(lane)
    except (KeyError, IndexError, ValueError):
        raise NetworkError(
            f"there is no lane '{lane}', but junction {junction} names it",
            where=path,
            mend="rebuild the network with netconvert",
        ) from None


def _connections(net: Any, guard: _Guard, signals: set[str], path: str) -> tuple[Connection, ...]:
    """Return the ways of vehicles; the rows of a junction count all ways, those of others too."""
    found = []
    for junction, lanes in guard.lanes_into.items():
        # Lanes of walking areas come last, and their rows after those that are counted here.
        outer = [_lane(net, lane, junction, path) for lane in lanes if not lane.startswith(":")]
        ways = [way for lane in outer for way in lane.getOutgoing()]
        for row, way in enumerate(ways):
            allowed = guard.permits(way)
            if allowed & MOTOR_CLASSES:
                found.append(
                    Connection(
                        way.getFrom().getID(),
                        way.getTo().getID(),
                        way.getFromLane().getIndex(),
                        way.getDirection(),
                        way.getTLSID() if way.getTLSID() in signals else "",
                        way.getTLLinkIndex(),
                        junction,
                        row,
                        allowed,
                    )
                )
    return tuple(found)
