"""Reader of CityFlow's flow files, and of ways that they only name by anchor points."""

from __future__ import annotations

import heapq
import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, TypeAdapter

from dmil.demand.recorded import FileDemand, in_order, known_links
from dmil.demand.sumo.remarks import DemandRemark, Remarks
from dmil.errors import DemandError
from dmil.network import RoadNetwork
from dmil.network.cityflow import CityflowNetwork
from dmil.network.json_file import read_json

NO_END = -1
LAST_S = 10**8
"""Latest time that a file may name, three years after its beginning."""
MOST_VEHICLES = 10**7
"""Most vehicles of one entry: more is a slip of the pen that would fill the memory."""


class FlowRecord(BaseModel):
    """One entry of the file: vehicles of one route at a fixed headway."""

    model_config = ConfigDict(frozen=True)

    route: Annotated[tuple[str, ...], Field(min_length=1)]
    vehicle: dict[str, FiniteFloat] = {}
    interval: Annotated[FiniteFloat, Field(gt=0)]
    start: Annotated[FiniteFloat, Field(le=LAST_S, alias="startTime")] = 0.0
    end: Annotated[FiniteFloat, Field(le=LAST_S, alias="endTime")] = NO_END


_FILE = TypeAdapter(tuple[FlowRecord, ...])


@dataclass(frozen=True, eq=False)
class CityflowDemand(FileDemand):
    """The vehicles of a CityFlow flow file (ours).

    Parameters
    ----------
    remarks
        What was left out of the file, and why.
    kinds
        The file's kinds of vehicles, their lengths, speeds and accelerations.
    """

    remarks: tuple[DemandRemark, ...] = ()
    kinds: tuple[dict[str, float], ...] = ({},)


def read_cityflow_flow(
    path: str | Path, network: RoadNetwork, *, horizon_s: int | None = None
) -> CityflowDemand:
    """Read vehicles in CityFlow's flow format (ours).

    Each entry stands for vehicles at ``startTime`` and every ``interval`` seconds after it, up to
    and including ``endTime``; they appear at the next whole second, as with CityFlow's steps of
    1 s. Before second 0 nothing runs: with an earlier ``startTime`` they begin at 0. The roads of a
    route are anchor points: where one does not follow the other, the shortest way joins them, see
    `AnchorRouter`.

    What CityFlow drops is dropped, counted and told in the demand's ``remarks``: routes without a
    way or of a single road, and entries that end before they begin, or before second 0.

    Parameters
    ----------
    path
        The file.
    network
        The roads, from `dmil.network.read_cityflow_roadnet`.
    horizon_s
        Needed if an entry has no end (``endTime`` -1): its vehicles depart before this second.

    Raises
    ------
    DemandError
        If the file is missing, cut off, not JSON or of another shape, or a route names a road that
        the network does not have.

    Notes
    -----
    The vehicles' lengths, speeds and accelerations are for CityFlow only: for the queue simulator
    see the scenario's ``QueueDynamics``.
    """
    flows = read_json(path, _FILE, content="a CityFlow flow file", error=DemandError)
    depart_s: list[int] = []
    routes: list[list[int]] = []
    remarks, router = Remarks(), AnchorRouter(network)
    kinds: dict[str, int] = {}
    kind: list[int] = []
    for index, flow in enumerate(flows):
        where = f"{path}: [{index}]"
        route = router.way(known_links(network, flow.route, where=where))
        seconds = _departures_s(flow, horizon_s, where)
        if not seconds and flow.end != NO_END:
            remarks.add("ends-first", f"[{index}]")
        elif len(route) > 1:
            depart_s.extend(seconds)
            routes.extend([route] * len(seconds))
            own = json.dumps(flow.vehicle, sort_keys=True)
            kind.extend([kinds.setdefault(own, len(kinds))] * len(seconds))
        elif route:
            remarks.add("one-road", f"[{index}]", len(seconds), place=flow.route[0])
        else:
            remarks.add("no-way", f"[{index}]", len(seconds), place=flow.route[0])
    # Vehicles of one kind are told apart by nothing.
    vehicles = in_order(
        np.array(depart_s, dtype=np.float64), routes, kind if len(kinds) > 1 else None
    )
    found = tuple(map(json.loads, kinds)) or ({},)
    return CityflowDemand(network, vehicles, remarks=remarks.all(), kinds=found)


def _departures_s(flow: FlowRecord, horizon_s: int | None, where: str) -> list[int]:
    """Return the whole seconds in which an entry's vehicles appear."""
    start_s, end_s = max(0, math.ceil(flow.start)), flow.end
    if end_s == NO_END:
        if horizon_s is None:
            raise DemandError(
                "it has no end (endTime is -1)",
                where=where,
                expected="an end, or a horizon at which to stop",
                mend="give horizon_s (--steps)",
            )
        end_s = horizon_s - 1
    # 1e-9: three headways of a third of a second are one second.
    headways = (end_s - start_s) / flow.interval
    if headways > MOST_VEHICLES:
        raise DemandError(
            f"it stands for {headways:.3g} vehicles",
            where=where,
            expected=f"at most {MOST_VEHICLES:,}",
            mend="correct interval or endTime",
        )
    count = max(0, math.floor(headways + 1e-9) + 1)
    return [start_s + math.ceil(k * flow.interval - 1e-9) for k in range(count)]


class AnchorRouter:
    """Joins anchor points by shortest ways (CityFlow, ``src/vehicle/router.cpp``).

    Parameters
    ----------
    network
        The roads. On one that is not CityFlow's, roads are as long as their links and are tried in
        the order of the movements.

    Notes
    -----
    A way is as long as all its roads but the first, each as long as its lanes in the mean. Of two
    ways equally long the one stays that was found first; roads equally far are taken from the heap
    as GCC's ``std::priority_queue`` does, which Python's ``heapq`` does alike.
    """

    def __init__(self, network: RoadNetwork) -> None:
        if isinstance(network, CityflowNetwork):
            self._length_m: Sequence[float] = network.lane_length_m
            self._followers: Sequence[Sequence[int]] = network.followers
        else:
            self._length_m = [link.length_m for link in network.links]
            self._followers = [[link for link, _ in pairs] for pairs in network.successors]
        self._known: dict[tuple[int, int], list[int]] = {}

    def way(self, anchors: Sequence[int]) -> list[int]:
        """Return the links of a route, the anchors among them; none if there is no way between two.

        An anchor that comes twice in a row counts once.
        """
        route = [anchors[0]]
        for start, end in pairwise(anchors):
            if start == end:
                continue
            if (start, end) not in self._known:
                self._known[start, end] = self._shortest(start, end)
            if not self._known[start, end]:
                return []
            route += self._known[start, end]
        return route

    def _shortest(self, start: int, end: int) -> list[int]:
        """Return the links after ``start`` up to ``end``, none if there is no way."""
        distance_m = {start: 0.0}
        before: dict[int, int] = {}
        done: set[int] = set()
        heap = [_Reached(0.0, start)]
        while heap:
            here = heap[0].link
            if here == end:
                break
            heapq.heappop(heap)
            if here in done:
                continue
            done.add(here)
            for link in self._followers[here]:
                found_m = distance_m[here] + self._length_m[link]
                if link not in distance_m or found_m < distance_m[link]:
                    before[link], distance_m[link] = here, found_m
                    heapq.heappush(heap, _Reached(found_m, link))
        else:
            return []
        way = [end]
        while before[way[-1]] != start:
            way.append(before[way[-1]])
        return way[::-1]


class _Reached:
    """A road and how far it is. Only that is compared: roads equally far have no order."""

    __slots__ = ("distance_m", "link")

    def __init__(self, distance_m: float, link: int) -> None:
        self.distance_m, self.link = distance_m, link

    def __lt__(self, other: _Reached) -> bool:
        return self.distance_m < other.distance_m
