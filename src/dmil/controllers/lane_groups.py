"""Lane groups: movements that share lanes queue together, so they are one queue to a controller.

A group is what factored memories speak of: its queue, who approaches it, whether it is served. Here
is what it has of a network: how much of it is green in a phase, whom it feeds and who feeds it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dmil.controllers.protocol import Situation
from dmil.network import Intersection, RoadNetwork

IntArray = npt.NDArray[np.int32]
FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

NOWHERE = -1
"""Link ahead of a movement that leads out of the network, or to where many ways lead on."""


class LaneGroups(NamedTuple):
    """The lane groups of a network that need a signal, as flat arrays (ours).

    A *slot* is a movement: ``intersection * movements of the widest intersection + movement``.
    Groups, and phases, are numbered over all intersections in the network's order.

    Attributes
    ----------
    group_offset: (intersections + 1,) int32
        Where the groups of an intersection begin.
    phase_offset: (intersections + 1,) int32
        Where the phases of an intersection begin.
    slot_offset: (groups + 1,) int32
        Where the movements of a group begin in ``slots``.
    slots: (movements of all groups,) int32
    lanes: (groups,) float64
        Number of lanes.
    lane_veh: (groups,) float64
        Vehicles that a lane discharges in a decision interval of green.
    link: (groups,) int32
        Link that they belong to.
    served_offset: (phases + 1,) int32
        Where the groups that a phase serves begin in ``served``.
    served: (groups of all phases,) int32
    partly: (groups of all phases,) bool
        Whether the phase serves some movements of the group only.
    flow_offset: (phases + 1,) int32
        Where the movements that may go in a phase, with and without a signal, begin in ``flows``.
    flows: (movements of all phases,) int32
        Slots.
    ahead: (slots,) int32
        Link of an intersection that a movement leads to, `NOWHERE` if there is none.
    capacity_veh: (slots,) float64
        Vehicles that a movement discharges in a decision interval of green; lanes that it shares
        count in part.
    links_groups: (links,) float64
        Number of groups on a link, at least 1.
    unseen: (links,) float64
        Part of the decision interval in which vehicles can reach the end of a link that are not on
        it yet at its beginning.
    is_fed: (links,) bool
        Whether vehicles come to it from an intersection.
    """

    group_offset: IntArray
    phase_offset: IntArray
    slot_offset: IntArray
    slots: IntArray
    lanes: FloatArray
    lane_veh: FloatArray
    link: IntArray
    served_offset: IntArray
    served: IntArray
    partly: BoolArray
    flow_offset: IntArray
    flows: IntArray
    ahead: IntArray
    capacity_veh: FloatArray
    links_groups: FloatArray
    unseen: FloatArray
    is_fed: BoolArray


def lane_groups(situation: Situation) -> LaneGroups:
    """Return the lane groups of a network (ours).

    Parameters
    ----------
    situation
        Network, signal timing and saturation flow.
    """
    network, interval_s = situation.network, situation.decision_interval_s
    width = max(len(item.movements) for item in network.intersections)
    links = len(network.links)
    groups: list[list[int]] = []
    served: list[list[int]] = []
    flows: list[list[int]] = []
    partly: list[bool] = []
    group_offset, phase_offset, lanes, group_link = [0], [0], [], []
    ahead = np.full(len(network.intersections) * width, NOWHERE, np.int32)
    capacity_veh = np.zeros(ahead.size)
    flow_veh = situation.dynamics.saturation_flow_veh_per_s * interval_s
    to_signals = _ways_to_signals(network)
    for i, item in enumerate(network.intersections):
        first = len(groups)
        members = _sharing_lanes(item)
        for group in members:
            groups.append([i * width + j for j in group])
            lanes.append(len({lane for j in group for lane in item.movements[j].lanes}) or 1)
            group_link.append(network.link_index[item.movements[group[0]].from_link])
        users = _users_of_lanes(item)
        for j, movement in enumerate(item.movements):
            ahead[i * width + j] = to_signals[network.link_index[movement.to_link]]
            own = sum(1 / users[movement.from_link, lane] for lane in movement.lanes) or 1.0
            capacity_veh[i * width + j] = flow_veh * own
        for phase in item.phases:
            flows.append([i * width + j for j in sorted(phase | item.unsignalled)])
            touched = [g for g, group in enumerate(members) if phase.intersection(group)]
            served.append([first + g for g in touched])
            partly += [not phase.issuperset(members[g]) for g in touched]
        group_offset.append(len(groups))
        phase_offset.append(len(served))
    on_link = np.bincount(group_link, minlength=links)
    is_fed = np.zeros(links, np.bool_)
    is_fed[ahead[ahead != NOWHERE]] = True
    return LaneGroups(
        group_offset=np.array(group_offset, np.int32),
        phase_offset=np.array(phase_offset, np.int32),
        slot_offset=_offsets(groups),
        slots=_flat(groups),
        lanes=np.array(lanes, np.float64),
        lane_veh=np.full(len(lanes), flow_veh),
        link=np.array(group_link, np.int32),
        served_offset=_offsets(served),
        served=_flat(served),
        partly=np.array(partly, np.bool_),
        flow_offset=_offsets(flows),
        flows=_flat(flows),
        ahead=ahead,
        capacity_veh=capacity_veh,
        links_groups=np.maximum(on_link, 1.0),
        unseen=np.clip(1.0 - network.free_flow_time_s / interval_s, 0.0, None),
        is_fed=is_fed,
    )


def _sharing_lanes(item: Intersection) -> list[list[int]]:
    """Return the signalled movements of an intersection, those that share lanes together."""
    found: list[tuple[set[tuple[str, int]], list[int]]] = []
    for j, movement in enumerate(item.movements):
        if j in item.unsignalled:
            continue
        lanes = {(movement.from_link, lane) for lane in movement.lanes}
        joined = [group for group in found if group[0] & lanes]
        found = [group for group in found if not group[0] & lanes]
        members = [member for group in joined for member in group[1]]
        found.append((lanes.union(*(group[0] for group in joined)), [*members, j]))
    return sorted(sorted(members) for _, members in found)


def _users_of_lanes(item: Intersection) -> dict[tuple[str, int], int]:
    """Return how many movements use each lane, by link and number of the lane."""
    users: dict[tuple[str, int], int] = {}
    for movement in item.movements:
        for lane in movement.lanes:
            users[movement.from_link, lane] = users.get((movement.from_link, lane), 0) + 1
    return users


def _ways_to_signals(network: RoadNetwork) -> list[int]:
    """Return for every link the link of an intersection that it leads to, itself if it is one.

    Across junctions without signals as long as there is one way only.
    """
    index = network.intersection_index
    found = []
    for link in range(len(network.links)):
        passed = {link}
        at = link
        while network.links[at].end not in index:
            following = network.successors[at]
            if len(following) != 1 or following[0][0] in passed:
                at = NOWHERE
                break
            at = following[0][0]
            passed.add(at)
        found.append(at)
    return found


def _offsets(parts: Sequence[Sequence[int]]) -> IntArray:
    return np.cumsum([0, *map(len, parts)], dtype=np.int32)


def _flat(parts: Sequence[Sequence[int]]) -> IntArray:
    return np.array([number for part in parts for number in part], np.int32)
