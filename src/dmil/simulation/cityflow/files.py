"""What CityFlow reads: a road network with our clearance phases, one flow per vehicle."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from dmil.arrays import BoolArray
from dmil.demand import Vehicles
from dmil.errors import InputError, NetworkError
from dmil.network import Intersection, RoadNetwork
from dmil.scenarios.model import CityflowFiles

CONFIG, ROADNET, FLOW = "config.json", "roadnet.json", "flow.json"
KIND: dict[str, float] = {
    "length": 5.0,
    "width": 2.0,
    "maxPosAcc": 2.0,
    "maxNegAcc": 4.5,
    "usualPosAcc": 2.0,
    "usualNegAcc": 4.5,
    "minGap": 2.5,
    "maxSpeed": 11.111,
    "headwayTime": 2.0,
}
"""Vehicle of a flow file that says nothing: that of CityFlow's own examples."""

Pairs = frozenset[tuple[str, str]]
"""Movements as (road, road)."""


@dataclass(frozen=True)
class Lights:
    """Which light phase of the file shows what.

    Attributes
    ----------
    phases: list of list of int
        Of every intersection, the light phase of each phase; empty where no light stands.
    clearances: list of dict
        Of every intersection, (phase, phase) to the light phase between the two.
    stages: list of list of int
        Of every intersection, the light phase of each stage of its own program.
    """

    phases: list[list[int]]
    clearances: list[dict[tuple[int, int], int]]
    stages: list[list[int]]


def find_lights(network: RoadNetwork, document: dict[str, Any], all_stop: BoolArray) -> Lights:
    """Find our phases in a file; what it does not have, such as clearances, is added to it (ours).

    Parameters
    ----------
    network
        The network that was read from the file.
    document
        The file; changed in place.
    all_stop: (intersections,) bool
        Whether clearance stops those too who have green before and after it.

    Raises
    ------
    NetworkError
        If the file has not got an intersection of the network.
    """
    nodes = {node["id"]: node for node in document["intersections"]}
    found = Lights([], [], [])
    for item, stops in zip(network.intersections, all_stop.tolist(), strict=True):
        if item.id not in nodes:
            raise NetworkError(
                f"there is no intersection '{item.id}'",
                where="the CityFlow road network",
                mend="it has changed since it was read: read it again",
            )
        light = nodes[item.id].get("trafficLight") or {}
        if len(light.get("lightphases", ())) < 2:  # CityFlow lets everybody go
            found.phases.append([])
            found.clearances.append({})
            found.stages.append([])
            continue
        shown = _Shown(nodes[item.id])
        pairs = [(each.from_link, each.to_link) for each in item.movements]
        free = _pairs(pairs, item.unsignalled)
        served = [_pairs(pairs, phase) | free for phase in item.phases]
        found.phases.append([shown.index(each) for each in served])
        found.clearances.append(
            {
                (a, b): shown.index(free if stops else served[a] & served[b])
                for a in range(len(served))
                for b in range(len(served))
                if a != b
            }
        )
        found.stages.append([shown.index(each | free) for each in _stages(item, pairs)])
    return found


def _pairs(pairs: Sequence[tuple[str, str]], movements: frozenset[int]) -> Pairs:
    return frozenset(pairs[j] for j in movements)


def _stages(item: Intersection, pairs: Sequence[tuple[str, str]]) -> list[Pairs]:
    stages = item.program.stages if item.program else ()
    return [_pairs(pairs, stage.green) for stage in stages]


class _Shown:
    """The light phases of an intersection in the file, by what they serve."""

    def __init__(self, node: dict[str, Any]) -> None:
        self._phases = node["trafficLight"]["lightphases"]
        self._links = [(each["startRoad"], each["endRoad"]) for each in node["roadLinks"]]
        self._served = [
            frozenset(self._links[k] for k in phase["availableRoadLinks"]) for phase in self._phases
        ]

    def index(self, served: Pairs) -> int:
        """Return which light phase serves these movements and no other; add it if there is none."""
        if served not in self._served:
            available = [k for k, pair in enumerate(self._links) if pair in served]
            self._phases.append({"time": 5, "availableRoadLinks": available})
            self._served.append(served)
        return self._served.index(served)


def write_network(files: CityflowFiles, network: RoadNetwork, all_stop: BoolArray, to: Path) -> Any:
    """Write the network for a run into a folder; return its `Lights`.

    Raises
    ------
    InputError
        If the file cannot be read any more.
    """
    try:
        document = json.loads(files.roadnet.read_text(encoding="utf-8-sig"))
    except (OSError, ValueError) as error:
        raise InputError(f"cannot be read ({error})", where=str(files.roadnet)) from None
    lights = find_lights(network, document, all_stop)
    (to / ROADNET).write_text(json.dumps(document), encoding="utf-8")
    return lights


def write_flow(
    files: CityflowFiles, network: RoadNetwork, vehicles: Vehicles, to: Path
) -> list[float]:
    """Write vehicles, each a flow of its own; return their highest speeds in m/s (ours)."""
    names = [link.id for link in network.links]
    kinds = [KIND | kind for kind in files.kinds]
    kind = np.zeros(len(vehicles), np.int64) if vehicles.kind is None else vehicles.kind
    flows = [
        {
            "vehicle": kinds[kind[v]],
            "route": [names[link] for link in vehicles.route(v).tolist()],
            "interval": 1.0,
            "startTime": second,
            "endTime": second,
        }
        for v, second in enumerate(vehicles.depart_s.tolist())
    ]
    (to / FLOW).write_text(json.dumps(flows), encoding="utf-8")
    return [kinds[each]["maxSpeed"] for each in kind.tolist()]


def write_configuration(to: Path, *, seed: int, lane_changes: bool) -> str:
    """Write CityFlow's configuration for the files in a folder; return its path (ours)."""
    values = {
        "interval": 1.0,
        "seed": seed % 2**31,
        "dir": f"{to}/",
        "roadnetFile": ROADNET,
        "flowFile": FLOW,
        "rlTrafficLight": True,
        "laneChange": lane_changes,
        "saveReplay": False,
        "roadnetLogFile": "roadnet-log.json",
        "replayLogFile": "replay.txt",
    }
    (to / CONFIG).write_text(json.dumps(values), encoding="utf-8")
    return str(to / CONFIG)
