"""Lane groups: movements that share lanes queue together, so they are one queue to a controller.

A group is what factored memories speak of: its queue, who approaches it, whether it is served. Here
is what it has of a network: how much of it is green in a phase, whom it feeds and who feeds it.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dmil.arrays import BoolArray, IntArray, Single
from dmil.controllers.protocol import RunContext
from dmil.network import Intersection, RoadNetwork
from dmil.scenarios import signal_times

ZERO = np.float32(0.0)
FULL = 0.8
"""Part of its storage from which on a lane counts as full."""
Indices = npt.NDArray[np.uint32]
"""Places in other arrays: without a sign, because compiled code then need not ask for it."""


class LaneGroups(NamedTuple):
    """The lane groups of a network that need a signal, as flat arrays (ours).

    A movement has the flat index ``intersection * movements of the widest intersection + number``.
    Groups, and phases, are numbered over all intersections in the network's order.

    Attributes
    ----------
    group_offset: (intersections + 1,) int32
        Where the groups of an intersection begin.
    phase_offset: (intersections + 1,) int32
        Where the phases of an intersection begin.
    all_stop: (intersections,) bool
        Whether a change of phase stops those too who keep their green.
    movement_offset: (groups + 1,) uint32
        Where the movements of a group begin in ``movements``.
    movements: (movements of all groups,) uint32
    lanes: (groups,) float32
        Number of lanes.
    lane_veh: (groups,) float32
        Vehicles that a lane discharges in a decision interval of green.
    link: (groups,) uint32
        Link that they belong to.
    link_share: (groups,) float32
        Part of the groups of their link that they are: 1 divided by their number.
    served_offset: (phases + 1,) uint32
        Where the groups that a phase serves begin in ``served``.
    served: (groups of all phases,) uint32
    partly: (groups of all phases,) bool
        Whether the phase serves some movements of the group only.
    served_block: (most groups of a phase, most phases, intersections) uint32
        The same as a block: group, plus the number of groups where it is served in part, so that
        it is a place among ``ways * groups`` gains. Where a phase serves fewer groups: the place
        behind them; where an intersection has fewer phases: the one behind that. It is as wide as
        the widest intersection needs.
    flow_offset: (phases + 1,) uint32
        Where the movements that may go in a phase, with and without a signal, begin in ``flows``.
    flows: (movements of all phases,) uint32
        Movements.
    ahead: (movements,) uint32
        Link of an intersection that a movement leads to, `links` if it leads out of the network,
        or to where many ways lead on.
    slots_ahead: (movements of all groups,) uint32
        The same for ``movements``.
    in_time_veh: (movements,) float32
        Vehicles that a movement discharges in a decision interval of green, lanes that it shares
        counting in part, and that reach the end of the link ahead within it.
    unseen: (links + 1,) float32
        Part of the decision interval in which vehicles can reach the end of a link that are not on
        it yet at its beginning; 0 for the link that stands for none.
    waves: (links + 1,) float32
        The same where green at the end of the link is worth a wave: unless asked for everywhere,
        only where the intersection there has a choice of phases.
    all_seen: (groups,) bool
        Whether all vehicles that reach its end within the interval are on its link already.
    unannounced: (groups,) float32
        Part of the interval in which vehicles can reach its end that are not on its link yet, where
        no intersection feeds it that could announce them; else 0.
    entries: (some groups,) uint32
        Groups that no intersection feeds and that fill up, so that vehicles wait unseen behind
        them; none unless asked for.
    entry_full_veh: (some groups,) float32
        Vehicles per lane from which on they count as full.
    """

    group_offset: IntArray
    phase_offset: IntArray
    all_stop: BoolArray
    movement_offset: Indices
    movements: Indices
    lanes: Single
    lane_veh: Single
    link: Indices
    link_share: Single
    served_offset: Indices
    served: Indices
    partly: BoolArray
    served_block: Indices
    flow_offset: Indices
    flows: Indices
    ahead: Indices
    movement_ahead: Indices
    in_time_veh: Single
    unseen: Single
    waves: Single
    all_seen: BoolArray
    unannounced: Single
    entries: Indices
    entry_full_veh: Single

    @property
    def ways(self) -> int:
        """In how many ways phases serve groups: wholly, and where that occurs in part."""
        return 2 if self.partly.any() else 1


def lane_groups(
    context: RunContext, *, waves_everywhere: bool = True, outside: bool = False
) -> LaneGroups:
    """Return the lane groups of a network, with its signal timing and saturation flow (ours)."""
    network, interval_s = context.network, context.decision_interval_s
    width = max(len(item.movements) for item in network.intersections)
    links = len(network.links)
    groups: list[list[int]] = []
    served: list[list[int]] = []
    flows: list[list[int]] = []
    partly: list[bool] = []
    group_offset, phase_offset, lanes, group_link = [0], [0], [], []
    ahead = np.full(len(network.intersections) * width, links, np.uint32)
    capacity_veh = np.zeros(ahead.size)
    flow_veh = context.dynamics.saturation_flow_veh_per_s * interval_s
    to_signals = _ways_to_signals(network)
    for i, item in enumerate(network.intersections):
        first = len(groups)
        members = _sharing_lanes(item)
        for group in members:
            groups.append([i * width + j for j in group])
            lanes.append(len({lane for j in group for lane in item.movements[j].lanes}) or 1)
            group_link.append(network.link_index[item.movements[group[0]].from_link])
        users = Counter((m.from_link, lane) for m in item.movements for lane in m.lanes)
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
    link = np.array(group_link, np.uint32)
    is_fed = np.zeros(links + 1, np.bool_)
    is_fed[ahead] = True
    unseen = np.zeros(links + 1, np.float32)
    unseen[:links] = np.clip(1.0 - network.free_flow_time_s / interval_s, 0.0, None)
    fills = outside and context.dynamics.storage
    entries = np.flatnonzero(~is_fed[link]) if fills else np.zeros(0, np.int64)
    length_m = np.array([item.length_m for item in network.links])
    room_veh = length_m[link[entries]] / context.dynamics.vehicle_space_m
    return LaneGroups(
        group_offset=np.array(group_offset, np.int32),
        phase_offset=np.array(phase_offset, np.int32),
        all_stop=signal_times(context.timing, network).all_stop.copy(),
        movement_offset=_offsets(groups),
        movements=_flat(groups),
        lanes=np.array(lanes, np.float32),
        lane_veh=np.full(len(lanes), flow_veh, np.float32),
        link=link,
        link_share=(1.0 / np.bincount(link)[link]).astype(np.float32),
        served_offset=_offsets(served),
        served=_flat(served),
        partly=np.array(partly, np.bool_),
        served_block=_served_block(phase_offset, served, partly, len(groups)),
        flow_offset=_offsets(flows),
        flows=_flat(flows),
        ahead=ahead,
        movement_ahead=ahead[_flat(groups)],
        in_time_veh=(capacity_veh * unseen[ahead]).astype(np.float32),
        unseen=unseen,
        waves=unseen if waves_everywhere else np.where(_ends_at_choice(network), unseen, ZERO),
        all_seen=unseen[link] == 0.0,
        unannounced=np.where(is_fed, ZERO, unseen)[link],
        entries=entries.astype(np.uint32),
        entry_full_veh=(FULL * room_veh).astype(np.float32),
    )


def _ends_at_choice(network: RoadNetwork) -> BoolArray:
    """Tell of every link, and of none, whether an intersection with a choice is at its end."""
    several = {item.id for item in network.intersections if len(item.phases) > 1}
    return np.array([*(link.end in several for link in network.links), False])


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


def _ways_to_signals(network: RoadNetwork) -> list[int]:
    """Return for every link the link of an intersection that it leads to, itself if it is one.

    Across junctions without signals as long as there is one way only, else the number of links.
    """
    index = network.intersection_index
    found = []
    for link in range(len(network.links)):
        passed = {link}
        at = link
        while network.links[at].end not in index:
            following = network.successors[at]
            if len(following) != 1 or following[0][0] in passed:
                at = len(network.links)
                break
            at = following[0][0]
            passed.add(at)
        found.append(at)
    return found


def _served_block(
    phase_offset: Sequence[int],
    served: Sequence[Sequence[int]],
    partly: Sequence[bool],
    groups: int,
) -> Indices:
    """Return what phases serve as a block: see `LaneGroups`."""
    ways = 2 if any(partly) else 1
    shape = max(1, *map(len, served)), int(np.diff(phase_offset).max()), len(phase_offset) - 1
    block = np.full(shape, ways * groups, np.uint32)
    block[0] = ways * groups + 1
    in_part = iter(partly)
    for i, (first, last) in enumerate(pairwise(phase_offset)):
        for phase in range(first, last):
            # A phase may serve nobody.
            block[0, phase - first, i] = ways * groups
            for k, group in enumerate(served[phase]):
                block[k, phase - first, i] = group + groups * next(in_part)
    return block


def _offsets(parts: Sequence[Sequence[int]]) -> Indices:
    return np.cumsum([0, *map(len, parts)], dtype=np.uint32)


def _flat(parts: Sequence[Sequence[int]]) -> Indices:
    return np.array([number for part in parts for number in part], np.uint32)
