"""Writer of SUMO road networks and their signals' states: plain XML, and netconvert."""

from __future__ import annotations

import importlib.util
import os
import re
import subprocess
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from dmil.errors import MissingExtraError, NetworkError
from dmil.network.model import TURNS, Intersection, Link, Movement, RoadNetwork
from dmil.network.program import Stage
from dmil.network.sumo.records import SumoSignals
from dmil.network.xml_file import attributes_xml

LEAST_LENGTH_M = 0.2
"""SUMO has no shorter lanes."""
ENTRY_LENGTH_M = 100.0
"""Length of links that the network gives none: vehicles need a road to come from."""


@dataclass(frozen=True, slots=True)
class WrittenNetwork:
    """A road network as a SUMO file (ours).

    Parameters
    ----------
    net_file
        The ``.net.xml``.
    edges
        Id of SUMO's edge for every link.
    signals
        Ids and states of the signals, one per intersection.
    """

    net_file: Path
    edges: tuple[str, ...]
    signals: tuple[SumoSignals, ...]


def write_sumo_network(network: RoadNetwork, folder: str | Path) -> WrittenNetwork:
    """Write a network for SUMO (ours).

    Lanes are numbered from the right, as SUMO does: where the right turns of a link use lanes of
    higher numbers than its left turns, the numbers are reversed. A movement's lanes lead to as many
    lanes side by side. Movements that always may go give way. Where a program ends a green without
    clearance, its last 3 s are yellow. Links keep their length whatever the picture; those of
    length 0 get 100 m. Ids lose the characters that SUMO does not take.

    Parameters
    ----------
    network
        The roads and signals.
    folder
        Where the plain files and ``network.net.xml`` go; it is made if need be.

    Raises
    ------
    NetworkError
        If a link begins and ends at one node, two nodes are at one place, or netconvert refuses.
    MissingExtraError
        If SUMO is not installed.
    """
    for link in network.links:
        if link.start == link.end:
            raise NetworkError(
                f"link '{link.id}' begins and ends at '{link.start}'",
                where=network.name,
                expected="links between two nodes",
                mend="a network of several junctions under one controller comes from SUMO; use "
                "the file that it was read from",
            )
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    names = _Names(network)
    signals = tuple(signals_of(item, names.node[item.id]) for item in network.intersections)
    _write(folder / "plain.nod.xml", "nodes", _nodes(network, names))
    _write(folder / "plain.edg.xml", "edges", _edges(network, names))
    _write(folder / "plain.con.xml", "connections", _connections(network, names))
    _write(folder / "plain.tll.xml", "tlLogics", _programs(network, names, signals))
    net_file = folder / "network.net.xml"
    _netconvert(folder, net_file, network.name)
    return WrittenNetwork(net_file, tuple(names.link.values()), signals)


def sumo_program(name: str) -> tuple[Path, dict[str, str]]:
    """Return a program of the installed SUMO, such as ``netconvert``, and its environment (ours).

    Raises
    ------
    MissingExtraError
        If SUMO is not installed.
    """
    package = importlib.util.find_spec("sumo")
    if package is None or not package.submodule_search_locations:
        raise MissingExtraError("sumo")
    home = Path(package.submodule_search_locations[0])
    return home / "bin" / name, {**os.environ, "SUMO_HOME": str(home)}


def sumo_lane(network: RoadNetwork, movement: Movement, lane: int) -> str:
    """Return what SUMO calls a lane of a movement in a network that was written (ours)."""
    names = _Names(network)
    return f"{names.link[movement.from_link]}_{names.lane(movement, lane)}"


class _Names:
    """Ids that SUMO takes, for nodes and links, and the lanes counted from the right."""

    def __init__(self, network: RoadNetwork) -> None:
        self.node = _valid([*(item.id for item in network.nodes), *network.fringe])
        self.link = _valid(link.id for link in network.links)
        self.lanes = {link.id: link.lanes for link in network.links}
        self._reversed = _reversed_links(network)

    def lane(self, movement: Movement, lane: int) -> int:
        """Return a lane of the link that a movement comes from, 0 is the rightmost."""
        link = movement.from_link
        return self.lanes[link] - 1 - lane if link in self._reversed else lane


def _valid(ids: Iterable[str]) -> dict[str, str]:
    result: dict[str, str] = {}
    taken = set()
    for name in ids:
        plain = re.sub(r"[^\w.#+-]", "_", name, flags=re.ASCII) or "_"
        unique, copies = plain, 1
        while unique in taken:
            copies += 1
            unique = f"{plain}.{copies}"
        taken.add(unique)
        result[name] = unique
    return result


def _reversed_links(network: RoadNetwork) -> set[str]:
    """Return the links whose lanes are counted from the left, as CityFlow does."""
    leftward: Counter[str] = Counter()
    for node in network.nodes:
        for first in node.movements:
            for second in node.movements:
                turns = TURNS.index(first.turn) - TURNS.index(second.turn)
                if first.from_link == second.from_link and turns < 0:
                    leftward[first.from_link] += _side(second) - _side(first)
    mostly = sum(leftward.values()) < 0
    return {
        link.id
        for link in network.links
        if leftward[link.id] < 0 or (mostly and leftward[link.id] == 0)
    }


def _side(movement: Movement) -> int:
    return min(movement.lanes, default=0) + max(movement.lanes, default=0)


def _nodes(network: RoadNetwork, names: _Names) -> list[str]:
    scale = _scale(network)
    kinds = {item.id: "traffic_light" for item in network.intersections}
    lines = []
    for node, name in names.node.items():
        x, y = (scale * place for place in network.position_m[node])
        kind = kinds.get(node, "priority")
        lines.append(_element("node", id=name, x=f"{x:.2f}", y=f"{y:.2f}", type=kind))
    return lines


def _scale(network: RoadNetwork) -> float:
    """Return by how much to enlarge the picture so that junctions do not overlap."""
    factor = 1.0
    for link in network.links:
        (ax, ay), (bx, by) = network.position_m[link.start], network.position_m[link.end]
        distance_m = ((ax - bx) ** 2 + (ay - by) ** 2) ** 0.5
        if distance_m == 0:
            raise NetworkError(
                f"nodes '{link.start}' and '{link.end}' are at the same place",
                where=network.name,
                expected="different positions of nodes that a link joins",
            )
        factor = max(factor, (20 + 8 * link.lanes) / distance_m)
    return factor


def _edges(network: RoadNetwork, names: _Names) -> list[str]:
    return [
        _element(
            "edge",
            **{"from": names.node[link.start], "to": names.node[link.end]},
            id=names.link[link.id],
            numLanes=link.lanes,
            speed=link.speed_m_per_s,
            length=_length_m(link),
        )
        for link in network.links
    ]


def _length_m(link: Link) -> float:
    return max(link.length_m, LEAST_LENGTH_M) if link.length_m > 0 else ENTRY_LENGTH_M


def _connections(network: RoadNetwork, names: _Names) -> list[str]:
    return [
        _connection(movement, lane, target, names)
        for node in network.nodes
        for movement in node.movements
        for lane, target in _lane_pairs(movement, names)
    ]


def _lane_pairs(movement: Movement, names: _Names) -> list[tuple[int, int]]:
    """Return the lanes that a movement joins: right turns at the right, left ones at the left."""
    lanes = sorted(names.lane(movement, lane) for lane in movement.lanes)
    there = names.lanes[movement.to_link]
    free = max(there - len(lanes), 0)
    if movement.turn == "straight":
        first = min(lanes[0], free)
    else:
        first = 0 if movement.turn == "right" else free
    return [(lane, min(first + place, there - 1)) for place, lane in enumerate(lanes)]


def _connection(movement: Movement, lane: int, target: int, names: _Names, **signal: object) -> str:
    edges = {"from": names.link[movement.from_link], "to": names.link[movement.to_link]}
    return _element("connection", **edges, fromLane=lane, toLane=target, **signal)


def _programs(network: RoadNetwork, names: _Names, signals: Sequence[SumoSignals]) -> list[str]:
    lines = []
    for item, shown in zip(network.intersections, signals, strict=True):
        offset_s = item.program.offset_s if item.program else 0
        logic = _element("tlLogic", id=shown.id, type="static", programID="0", offset=offset_s)
        lines.append(logic.replace("/>", ">"))
        lines += [_element("phase", duration=s, state=state) for s, state in stages_of(item)]
        lines.append("</tlLogic>")
        for j, movement in enumerate(item.movements):
            pairs = _lane_pairs(movement, names)
            for (lane, target), index in zip(pairs, shown.links[j], strict=True):
                lines.append(
                    _connection(movement, lane, target, names, tl=shown.id, linkIndex=index)
                )
    return lines


def _element(tag: str, **attributes: object) -> str:
    return f"<{tag}{attributes_xml(attributes)}/>"


def _write(file: Path, root: str, lines: Iterable[str]) -> None:
    text = "\n".join(['<?xml version="1.0" encoding="UTF-8"?>', f"<{root}>", *lines])
    file.write_text(f"{text}\n</{root}>\n", encoding="utf-8")


def _netconvert(folder: Path, net_file: Path, where: str) -> None:
    program, environment = sumo_program("netconvert")
    options = [
        *("--node-files", str(folder / "plain.nod.xml")),
        *("--edge-files", str(folder / "plain.edg.xml")),
        *("--connection-files", str(folder / "plain.con.xml")),
        *("--tllogic-files", str(folder / "plain.tll.xml")),
        *("--output-file", str(net_file)),
        *("--no-turnarounds", "true"),
        *("--xml-validation", "never"),
        "--no-warnings",
    ]
    done = subprocess.run(
        [str(program), *options], env=environment, capture_output=True, text=True, check=False
    )
    if done.returncode != 0 or not net_file.exists():
        said = [line for line in done.stderr.splitlines() if line.startswith("Error:")]
        raise NetworkError(
            f"netconvert refuses it: {' / '.join(said) or done.stderr.strip()}", where=where
        )


GREEN_S, YELLOW_S = 20.0, 3.0
"""Stages of the program of an intersection that has none of its own."""


def signals_of(item: Intersection, name: str) -> SumoSignals:
    """Return a state string for every phase, with one letter per lane of a movement (ours)."""
    first, links = 0, []
    for movement in item.movements:
        links.append(tuple(range(first, first + len(movement.lanes))))
        first += len(movement.lanes)
    states = tuple(_state(item, phase) for phase in item.phases)
    return SumoSignals(name, states, tuple(links))


def _state(item: Intersection, green: frozenset[int], losing: frozenset[int] = frozenset()) -> str:
    """Return the state in which some movements have green and some yellow."""
    letters = []
    for j, movement in enumerate(item.movements):
        if j in item.unsignalled or (j in green and _yields(item, j, green)):
            letter = "g"
        elif j in green:
            letter = "G"
        else:
            letter = "y" if j in losing else "r"
        letters += [letter] * len(movement.lanes)
    return "".join(letters)


def _yields(item: Intersection, j: int, green: frozenset[int]) -> bool:
    """Whether a movement gives way to another one that has green in the same phase."""
    if item.gives_way:
        return not green.isdisjoint(item.gives_way[j])
    movement = item.movements[j]
    others = [item.movements[k] for k in green if item.movements[k].approach != movement.approach]
    if movement.turn == "straight":
        return False
    return any(
        other.to_link == movement.to_link or (movement.turn != "right" and other.turn == "straight")
        for other in others
    )


def stages_of(item: Intersection) -> list[tuple[float, str]]:
    """Return durations in s and states of the own program, or of each phase in turn (ours).

    A green that no clearance follows ends with yellow.
    """
    if item.program:
        stages = list(item.program.stages)
    else:
        stages = [Stage(GREEN_S + YELLOW_S, phase) for phase in item.phases]
    result = []
    for k, stage in enumerate(stages):
        before, after = stages[k - 1], stages[(k + 1) % len(stages)]
        losing = before.green - stage.green if stage.clearance else frozenset()
        ends = stage.green - after.green
        abrupt = bool(ends) and not stage.clearance and not after.clearance
        yellow_s = YELLOW_S if abrupt and stage.duration_s > YELLOW_S else 0.0
        result.append((stage.duration_s - yellow_s, _state(item, stage.green, losing)))
        if yellow_s:
            result.append((yellow_s, _state(item, stage.green & after.green, ends)))
    return result
