"""From a scenario and its journeys to the flat arrays of the kernel."""

from __future__ import annotations

from collections import Counter

import numpy as np
import numpy.typing as npt

from dmil.demand import Vehicles
from dmil.errors import DemandError
from dmil.network import Intersection, Junction, Movement, RoadNetwork
from dmil.network.permissions import Classes
from dmil.scenarios import Scenario
from dmil.simulation.queue.gaps import IN_TURN_S, gap_of, in_turn, junctions_that_hold
from dmil.simulation.queue.state import IntArray, Layout, Trips
from dmil.simulation.timing import programs_of, signals_of

UNLIMITED_VEH = np.iinfo(np.int32).max


def build_layout(scenario: Scenario) -> Layout:
    """Flatten a scenario's network and traffic dynamics (specification, §2)."""
    network, dynamics = scenario.network, scenario.dynamics
    intersections = network.intersections
    width = max(len(item.movements) for item in intersections)
    places, held = _places(scenario), _held(scenario)
    # Movements at junctions fill further rows of tables that have one for each intersection.
    size = -(-(places[-1][0] + 1) // width) * width
    movement_link = np.full(size, -1, np.int32)
    lane_number: dict[tuple[str, int], int] = {}
    lanes: list[list[int]] = [[] for _ in range(size)]

    def number(link: str, served: tuple[int, ...]) -> list[int]:
        return [lane_number.setdefault((link, lane), len(lane_number)) for lane in served]

    yields: list[list[int]] = [[] for _ in range(size)]
    turns: list[bool] = []
    after_s: list[float] = []
    headway_s, gap_s = np.full(size, 1 / dynamics.saturation_flow_veh_per_s), np.zeros(size)
    # Who comes from a stop nearby is seen no earlier than there.
    stops = network.intersection_index.keys() | {junction.id for junction in held}
    seen_s = [
        max(1.0, float(np.round(time_s))) if link.start in stops else np.inf
        for link, time_s in zip(network.links, link_times_s(scenario), strict=True)
    ]
    for movement, node, j in places:
        each = node.movements[j]
        movement_link[movement] = network.link_index[each.from_link]
        lanes[movement] = number(each.from_link, _served(network, node, each, each.lanes))
        foes = node.gives_way[j] if node.gives_way else ()
        yields[movement] = [movement - j + foe for foe in foes]
        if isinstance(node, Junction) and foes:
            gap_s[movement], follow_s = gap_of(node, j)
            headway_s[movement] = max(headway_s[movement], follow_s)
            turns += [in_turn(node, j, foe) for foe in foes]
            from_links = (network.link_index[node.movements[foe].from_link] for foe in foes)
            after_s += [
                IN_TURN_S[0] if in_turn(node, j, foe) else max(0.0, gap_s[movement] - seen_s[link])
                for foe, link in zip(foes, from_links, strict=True)
            ]
        else:
            turns += [False] * len(foes)
            after_s += [0.0] * len(foes)
    for movement, _, served in _other_lanes(scenario):
        lanes.append(number(network.links[movement_link[movement]].id, served))
    lane_offset, all_lanes = _ragged(lanes)
    yield_offset, all_yields = _ragged(yields)
    start_s = scenario.sumo.begin_s if scenario.sumo else 0
    return Layout(
        signals=signals_of(network),
        programs=programs_of(network, start_s),
        movement_link=movement_link,
        lane_offset=lane_offset,
        lanes=all_lanes,
        yield_offset=yield_offset,
        yields=all_yields,
        turns=np.array(turns, np.bool_),
        after_s=np.array(after_s, np.float64),
        headway_s=headway_s,
        gap_s=gap_s,
        capacity_veh=_capacity(scenario),
        gap_wait_s=np.array([dynamics.gap_wait_s], np.int32),
        start_wave_veh_per_s=np.array([dynamics.start_wave_veh_per_s]),
    )


def _held(scenario: Scenario) -> tuple[Junction, ...]:
    return junctions_that_hold(scenario.network, storage=scenario.dynamics.storage)


def _places(scenario: Scenario) -> list[tuple[int, Intersection | Junction, int]]:
    """Return movement, node and index there of every movement that vehicles queue for, in order."""
    intersections = scenario.network.intersections
    width = max(len(item.movements) for item in intersections)
    found: list[tuple[int, Intersection | Junction, int]] = [
        (i * width + j, item, j)
        for i, item in enumerate(intersections)
        for j in range(len(item.movements))
    ]
    others = [(node, j) for node in _held(scenario) for j in range(len(node.movements))]
    first = len(intersections) * width
    return found + [(movement, *place) for movement, place in enumerate(others, start=first)]


def _served(
    network: RoadNetwork,
    node: Intersection | Junction,
    movement: Movement,
    lanes: tuple[int, ...],
) -> tuple[int, ...]:
    """Return the lanes that vehicles queue in; of more than there are behind, those on the left."""
    if isinstance(node, Intersection):
        return lanes
    return lanes[-network.links[network.link_index[movement.to_link]].lanes :]


def build_trips(scenario: Scenario, layout: Layout, vehicles: Vehicles) -> Trips:
    """Turn routes over links into the movements that vehicles queue in and the legs between (ours).

    A leg takes the free-flow time of its links, or the measured one where the scenario has it,
    rounded to whole steps; between intersections at least 1 s, so that nobody crosses two within
    a step.

    Raises
    ------
    DemandError
        If a route goes from a link to another that no movement joins.
    """
    network = scenario.network
    route, offset = vehicles.route_links.astype(np.int64), vehicles.route_offset
    count = vehicles.depart_s.size
    last = np.zeros(route.size, np.bool_)
    last[offset[1:] - 1] = True
    before = np.flatnonzero(~last)
    movement = _movement_of_pairs(scenario, route[before], route[before + 1])
    if (movement == _NO_WAY).any():
        place = before[(movement == _NO_WAY).argmax()]
        vehicle = int(np.searchsorted(offset, place, side="right")) - 1
        raise DemandError(
            f"its route goes from link '{network.links[route[place]].id}' to"
            f" '{network.links[route[place + 1]].id}', which no movement joins",
            where=f"vehicle {vehicle}",
            expected="routes along the movements of the network",
            mend="check that network and demand belong together",
        )
    visits = before[movement != _NO_SIGNAL]
    movement_offset = np.searchsorted(visits, offset)
    ends = np.sort(np.concatenate([visits, offset[1:] - 1]))
    driven_s = np.cumsum(link_times_s(scenario)[route])
    leg_s = np.round(np.diff(driven_s[ends], prepend=0.0)).astype(np.int32)
    stops = network.intersection_index.keys() | {junction.id for junction in _held(scenario)}
    inner = np.array([link.end in stops for link in network.links])
    first_leg = np.zeros(ends.size, np.bool_)
    first_leg[movement_offset[:-1] + np.arange(count)] = True
    leg_s[~first_leg & inner[route[ends]]] = np.maximum(leg_s[~first_leg & inner[route[ends]]], 1)
    movements = movement[movement != _NO_SIGNAL].astype(np.int32)
    return Trips(
        depart_s=vehicles.depart_s.astype(np.int32),
        movement_offset=movement_offset.astype(np.int32),
        movements=movements,
        lane_row=_lane_rows(scenario, layout, vehicles, movements, np.diff(movement_offset)),
        leg_link=route[ends].astype(np.int32),
        leg_s=leg_s,
    )


def _other_lanes(
    scenario: Scenario,
) -> list[tuple[int, Classes, tuple[int, ...]]]:
    """Return where vehicles of a class queue in other lanes than those of their movement.

    Returns
    -------
    list of (movement, classes, lanes)
    """
    kinds = dict.fromkeys(scenario.sumo.classes if scenario.sumo else ())
    network = scenario.network
    return [
        (movement, classes, _served(network, node, node.movements[j], lanes))
        for movement, node, j in _places(scenario)
        for classes in kinds
        if (lanes := network.lanes_to(node.movements[j], classes)) != node.movements[j].lanes
    ]


def _lane_rows(
    scenario: Scenario,
    layout: Layout,
    vehicles: Vehicles,
    movements: IntArray,
    visits: npt.NDArray[np.int64],
) -> IntArray:
    """Return for every visit its row in the layout's lanes: the movement's own, or its class's."""
    size = layout.movement_link.size
    others = _other_lanes(scenario)
    if not others or vehicles.kind is None or scenario.sumo is None:
        return movements
    classes = list(dict.fromkeys(scenario.sumo.classes))
    row: IntArray = np.tile(np.arange(size, dtype=np.int32), (len(classes), 1))
    for k, (movement, each, _) in enumerate(others):
        row[classes.index(each), movement] = size + k
    of_kind = np.array([classes.index(each) for each in scenario.sumo.classes])
    rows: IntArray = row[np.repeat(of_kind[vehicles.kind], visits), movements]
    return rows


def link_times_s(scenario: Scenario) -> npt.NDArray[np.float64]:
    """Return the time of an undisturbed vehicle on every link: (links,) float64 (ours)."""
    if scenario.link_time_s is None:
        return scenario.network.free_flow_time_s
    return np.array(scenario.link_time_s, np.float64)


_NO_SIGNAL, _NO_WAY = -1, -2


def _movement_of_pairs(
    scenario: Scenario,
    links: npt.NDArray[np.int64],
    following: npt.NDArray[np.int64],
) -> npt.NDArray[np.int64]:
    """Return the movement of every pair of links; negative without a stop or a movement."""
    network, index = scenario.network, scenario.network.link_index
    count = len(network.links)
    known = {}
    for movement, node, j in _places(scenario):
        each = node.movements[j]
        known[index[each.from_link] * count + index[each.to_link]] = movement
    for first, pairs in enumerate(network.successors):
        for second, _ in pairs:
            known.setdefault(first * count + second, _NO_SIGNAL)
    keys = np.array(sorted(known), np.int64)
    movements = np.array([known[key] for key in keys.tolist()], np.int64)
    wanted = links * count + following
    place = np.minimum(np.searchsorted(keys, wanted), keys.size - 1)
    return np.where(keys[place] == wanted, movements[place], _NO_WAY)


def _capacity(scenario: Scenario) -> IntArray:
    """Return how many vehicles have room on every link that ends where they queue (§2).

    With storage a link holds as many vehicles as have room on its open lanes, and on those of links
    that lead to it over junctions where nobody waits; where these lead to several such links, each
    gets an equal part. It holds at least one; without length, or out of the network, any number.
    """
    network, dynamics = scenario.network, scenario.dynamics
    capacity = np.full(len(network.links), UNLIMITED_VEH, np.int32)
    if not dynamics.storage:
        return capacity
    held = {junction.id for junction in _held(scenario)}
    stops = network.intersection_index.keys() | held
    upstream: list[list[int]] = [[] for _ in network.links]
    for junction in (each for each in network.junctions if each.id not in held):
        for movement in junction.movements:
            second = network.link_index[movement.to_link]
            upstream[second].append(network.link_index[movement.from_link])
    fed: dict[int, set[int]] = {}
    for k, link in enumerate(network.links):
        if link.end in stops:
            found, open_links = {k}, [k]
            while open_links:
                new = set(upstream[open_links.pop()]) - found
                found |= new
                open_links += new
            fed[k] = found
    sharing = Counter(link for links in fed.values() for link in links)
    lane_m = [link.length_m * link.open_lanes for link in network.links]
    for k, links in fed.items():
        room_m = sum(lane_m[link] / sharing[link] for link in links)
        if room_m > 0:
            capacity[k] = max(1, int(room_m / dynamics.vehicle_space_m))
    return capacity


def _ragged(rows: list[list[int]]) -> tuple[IntArray, IntArray]:
    offset = np.zeros(len(rows) + 1, np.int32)
    np.cumsum([len(row) for row in rows], out=offset[1:])
    return offset, np.array([value for row in rows for value in row], np.int32)
