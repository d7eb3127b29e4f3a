"""Reader of CityFlow's road network files."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

from pydantic import TypeAdapter

from dmil.errors import NetworkError
from dmil.network.checks import check_network
from dmil.network.cityflow_geometry import (
    RoadLink,
    RoadnetFile,
    RoadnetIntersection,
    RoadnetRoad,
    road_length_m,
    way_segments,
)
from dmil.network.cityflow_phases import Served, give_way, sort_phases
from dmil.network.json_file import read_json
from dmil.network.model import TURNS, Intersection, Link, Movement, RoadNetwork, Turn
from dmil.network.naming import approach_names, order_counter_clockwise, phase_name
from dmil.network.plan_times import stops_all

_FILE = TypeAdapter(RoadnetFile)
_TURN: dict[str, Turn] = {
    "turn_right": "right",
    "go_straight": "straight",
    "turn_left": "left",
    "turn_u": "uturn",
}


@dataclass(frozen=True, eq=False)
class CityflowNetwork(RoadNetwork):
    """A road network with what CityFlow's router knows of it (ours).

    Parameters
    ----------
    lane_length_m
        For every link the mean length of its lanes, without the intersections it joins.
    followers
        For every link those that can follow, in the order in which the router tries them.
    """

    lane_length_m: tuple[float, ...] = field(default=(), repr=False)
    followers: tuple[tuple[int, ...], ...] = field(default=(), repr=False)


def read_cityflow_roadnet(path: str | Path) -> CityflowNetwork:
    """Read a road network in CityFlow's format (ours).

    Virtual intersections, and those without road links, become fringe nodes. Road links that are
    in every phase of a light become unsignalled movements. Yellow and clearance phases are no
    actions, but their time is kept as the intersection's ``clearance_s``; which they are, see
    `dmil.network.cityflow_phases.sort_phases`. The other phases are the actions, in the file's
    order, and the times of all the fixed-time plan. An intersection without light, or with a light
    of a single phase, has one phase. Turns give way to those whose way they cross, see
    `dmil.network.cityflow_phases.give_way`.

    Parameters
    ----------
    path
        The file, usually named ``roadnet*.json``.

    Raises
    ------
    NetworkError
        If the file is missing, cut off, not JSON, of another shape or inconsistent.

    Notes
    -----
    A link is as long as the line through its road's points; a road's speed is the highest of its
    lanes.
    """
    file = read_json(path, _FILE, content="a CityFlow road network", error=NetworkError)
    roads = {road.id: road for road in file.roads}
    junctions = {node.id: node for node in file.intersections}
    intersections = tuple(
        _intersection(junction, roads, f"{path}: intersections[{index}]")
        for index, junction in enumerate(file.intersections)
        if not junction.is_fringe
    )
    network = CityflowNetwork(
        name=Path(path).stem,
        links=tuple(
            Link(
                road.id,
                road.start,
                road.end,
                sum(
                    math.dist((here.x, here.y), (there.x, there.y))
                    for here, there in pairwise(road.points)
                ),
                max(lane.max_speed for lane in road.lanes),
                len(road.lanes),
            )
            for road in file.roads
        ),
        intersections=intersections,
        fringe=tuple(node.id for node in file.intersections if node.is_fringe),
        position_m={node.id: (node.point.x, node.point.y) for node in file.intersections},
        line_m={
            road.id: tuple((point.x, point.y) for point in road.points)
            for road in file.roads
            if len(road.points) > 2
        },
        lanes_from_left=True,
        lane_length_m=tuple(road_length_m(road, junctions) for road in file.roads),
        followers=_followers(file),
    )
    check_network(network, where=str(path))
    return network


def _followers(file: RoadnetFile) -> tuple[tuple[int, ...], ...]:
    """Return which roads follow each one, in the order in which its end lists its roads."""
    index = {road.id: k for k, road in enumerate(file.roads)}
    found: dict[str, list[int]] = {road.id: [] for road in file.roads}
    for node in file.intersections:
        joined = {(link.start_road, link.end_road) for link in node.road_links}
        for start in [] if node.is_fringe else dict.fromkeys(start for start, _ in joined):
            listed = index if node.roads is None else node.roads
            found[start] = [index[end] for end in listed if (start, end) in joined]
    return tuple(map(tuple, found.values()))


def _intersection(
    junction: RoadnetIntersection, roads: dict[str, RoadnetRoad], where: str
) -> Intersection:
    lanes = _lanes(junction, roads, where)
    angles = {
        link.start_road: _angle_of_origin(roads[link.start_road]) for link in junction.road_links
    }
    approaches = order_counter_clockwise(angles)

    def place(index: int) -> tuple[int, int, float]:
        link = junction.road_links[index]
        approach = approaches.index(link.start_road)
        # Of several exits of one turn, the one furthest to the right comes first.
        towards = _angle_of_destination(roads[link.end_road]) - angles[link.start_road]
        return approach, TURNS.index(_TURN[link.type]), round(towards % (2 * math.pi), 9)

    order = sorted(range(len(junction.road_links)), key=place)
    movements = tuple(
        _movement(junction.road_links[index], approaches, lanes[index]) for index in order
    )
    served = _served(junction, {index: position for position, index in enumerate(order)}, where)
    phases = sort_phases(served)
    sides = approach_names([angles[link] for link in approaches])
    ways = [way_segments(junction.road_links[index], roads, junction.width) for index in order]
    return Intersection(
        id=junction.id,
        movements=movements,
        phases=phases.actions,
        unsignalled=phases.unsignalled,
        program=phases.program,
        phase_names=tuple(phase_name(phase, movements, sides) for phase in phases.actions),
        clearance_s=phases.clearance_s,
        # Its lights show a phase of their own between two others, usually one without green.
        all_stop=stops_all(phases.program.stages if phases.program else (), untold=True),
        gives_way=give_way(movements, ways, served),
    )


def _movement(link: RoadLink, approaches: list[str], lanes: tuple[int, ...]) -> Movement:
    approach = approaches.index(link.start_road)
    return Movement(link.start_road, link.end_road, _TURN[link.type], approach, lanes)


def _lanes(
    junction: RoadnetIntersection, roads: dict[str, RoadnetRoad], where: str
) -> list[tuple[int, ...]]:
    """Return the lanes that every road link starts on."""
    used: list[tuple[int, ...]] = []
    for index, link in enumerate(junction.road_links):
        place = f"{where}.roadLinks[{index}]"
        for key, name in (("startRoad", link.start_road), ("endRoad", link.end_road)):
            if name not in roads:
                raise NetworkError(
                    f"there is no road '{name}'",
                    where=f"{place}.{key}",
                    mend="add the road, or correct its name",
                )
        count = len(roads[link.start_road].lanes)
        for lane_link in link.lane_links:
            if lane_link.start_lane >= count:
                raise NetworkError(
                    f"it starts on lane {lane_link.start_lane} of road {link.start_road}",
                    where=f"{place}.laneLinks",
                    expected=f"a lane from 0 to {count - 1}",
                )
        used.append(tuple(sorted({lane.start_lane for lane in link.lane_links})))
    return used


def _served(junction: RoadnetIntersection, rank: dict[int, int], where: str) -> list[Served]:
    """Return what the file's phases serve; a junction without light has one of everything."""
    served: list[Served] = []
    for index, phase in enumerate(junction.light.phases if junction.light else ()):
        missing = [link for link in phase.available if link not in rank]
        if missing:
            raise NetworkError(
                f"there is no road link {missing[0]}",
                where=f"{where}.trafficLight.lightphases[{index}].availableRoadLinks",
                expected=f"0 to {len(rank) - 1}",
            )
        served.append((frozenset(rank[link] for link in phase.available), phase.time))
    if not served:
        served = [(frozenset(rank.values()), 0.0)]
    if not any(phase for phase, _ in served):
        raise NetworkError(
            "no phase of its light serves a road link",
            where=f"{where}.trafficLight.lightphases",
            mend="give the phases their road links, or remove the light",
        )
    return served


def _angle_of_origin(road: RoadnetRoad) -> float:
    """Return the angle, counter-clockwise from East, of the side that a road's traffic is from."""
    return _angle_of_destination(road.model_copy(update={"points": road.points[::-1]}))


def _angle_of_destination(road: RoadnetRoad) -> float:
    """Return the angle, counter-clockwise from East, of the side that a road leads to."""
    start = road.points[0]
    for point in road.points[1:]:
        if (point.x, point.y) != (start.x, start.y):
            return math.atan2(point.y - start.y, point.x - start.x)
    return 0.0
