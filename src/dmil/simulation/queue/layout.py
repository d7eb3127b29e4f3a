"""From a scenario and its journeys to the flat arrays of the kernel."""

from __future__ import annotations

from collections import Counter

import numpy as np

from dmil.demand import Vehicles
from dmil.errors import DemandError
from dmil.network import RoadNetwork
from dmil.scenarios import Scenario, SignalTiming
from dmil.simulation.queue.state import Layout, Trips
from dmil.simulation.timing import Rules

UNLIMITED_VEH = np.iinfo(np.int32).max


def build_layout(scenario: Scenario) -> Layout:
    """Flatten a scenario's network and traffic dynamics (specification, §2).

    A link takes its free-flow time, rounded to whole steps; between intersections at least 1 s, so
    that nobody crosses two intersections within a step. With storage a link holds as many vehicles
    as have room on its lanes, at least one; without length, or out of the network, any number.
    """
    network, dynamics = scenario.network, scenario.dynamics
    intersections = network.intersections
    orientations = max(len(item.movements) for item in intersections)
    phases = max(len(item.phases) for item in intersections)
    size = len(intersections) * orientations
    served = np.zeros((len(intersections), phases, orientations), np.bool_)
    unsignalled = np.zeros((len(intersections), orientations), np.bool_)
    slot_link = np.full(size, -1, np.int32)
    headway_s = np.ones(size)
    for i, item in enumerate(intersections):
        unsignalled[i, list(item.unsignalled)] = True
        for p, phase in enumerate(item.phases):
            served[i, p, list(phase | item.unsignalled)] = True
        sharing = Counter((m.from_link, lane) for m in item.movements for lane in m.lanes)
        for j, movement in enumerate(item.movements):
            slot_link[i * orientations + j] = network.link_index[movement.from_link]
            lanes = sum(1 / sharing[movement.from_link, lane] for lane in movement.lanes)
            flow = lanes * dynamics.saturation_flow_veh_per_s
            headway_s[i * orientations + j] = 1 / flow
    inner = {item.id for item in intersections}
    travel_s = np.array(
        [
            max(round(link.free_flow_time_s), int({link.start, link.end} <= inner))
            for link in network.links
        ],
        np.int32,
    )
    capacity = np.full(len(network.links), UNLIMITED_VEH, np.int32)
    if dynamics.storage:
        for k, link in enumerate(network.links):
            if link.end in inner:
                room = link.length_m * link.lanes / dynamics.vehicle_space_m
                capacity[k] = max(1, int(room)) if link.length_m > 0 else UNLIMITED_VEH
    return Layout(
        phase_count=np.array([len(item.phases) for item in intersections], np.int32),
        served=served,
        unsignalled=unsignalled,
        slot_link=slot_link,
        headway_s=headway_s,
        travel_s=travel_s,
        capacity_veh=capacity,
    )


def rules_of(timing: SignalTiming) -> Rules:
    """Return the signal timing of a scenario for kernels (ours)."""
    return Rules(
        decision_interval_s=timing.decision_interval_s,
        clearance_s=timing.clearance_s,
        min_green_s=timing.min_green_s,
        startup_lost_s=timing.startup_lost_s,
    )


def build_trips(network: RoadNetwork, layout: Layout, vehicles: Vehicles) -> Trips:
    """Turn routes over links into the slots that vehicles queue in (ours).

    Raises
    ------
    DemandError
        If a route goes from a link to another that no movement joins.
    """
    orientations = layout.served.shape[2]
    links = len(network.links)
    movement_keys, movement_slots = [], []
    for i, item in enumerate(network.intersections):
        for j, movement in enumerate(item.movements):
            pair = network.link_index[movement.from_link], network.link_index[movement.to_link]
            movement_keys.append(pair[0] * links + pair[1])
            movement_slots.append(i * orientations + j)
    order = np.argsort(np.array(movement_keys, np.int64))
    keys = np.array(movement_keys, np.int64)[order]
    slots_of_keys = np.array(movement_slots, np.int32)[order]

    route, offset = vehicles.route_links.astype(np.int64), vehicles.route_offset
    count = vehicles.depart_s.size
    last = np.zeros(route.size, np.bool_)
    last[offset[1:] - 1] = True
    before = np.flatnonzero(~last[:-1])
    wanted = route[before] * links + route[before + 1]
    place = np.minimum(np.searchsorted(keys, wanted), keys.size - 1)
    if wrong := np.flatnonzero(keys[place] != wanted).tolist():
        first, second = divmod(int(wanted[wrong[0]]), links)
        vehicle = int(np.searchsorted(offset, before[wrong[0]], side="right")) - 1
        raise DemandError(
            f"its route goes from link '{network.links[first].id}' to"
            f" '{network.links[second].id}', which no movement joins",
            where=f"vehicle {vehicle}",
            expected="routes along the movements of the network",
            mend="check that network and demand belong together",
        )
    return Trips(
        depart_s=vehicles.depart_s.astype(np.int32),
        slot_offset=(offset - np.arange(count + 1)).astype(np.int32),
        slots=slots_of_keys[place],
        entry_link=route[offset[:-1]].astype(np.int32),
        exit_link=route[offset[1:] - 1].astype(np.int32),
    )
