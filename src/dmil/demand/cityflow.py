"""Reader of CityFlow's flow files."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, TypeAdapter

from dmil.demand.recorded import FileDemand, first_gap, in_order, link_indices
from dmil.demand.routes import router
from dmil.errors import DemandError
from dmil.network import RoadNetwork
from dmil.network.json_file import read_json

NO_END = -1
LAST_S = 10**8
"""Latest time that a file may name, three years after its beginning."""
MOST_VEHICLES = 10**7
"""Most vehicles of one entry: more is a slip of the pen that would fill the memory."""


class Flow(BaseModel):
    """One entry of the file: vehicles of one route at a fixed headway."""

    model_config = ConfigDict(frozen=True)

    route: Annotated[tuple[str, ...], Field(min_length=1)]
    interval: Annotated[FiniteFloat, Field(gt=0)]
    start: Annotated[FiniteFloat, Field(ge=0, le=LAST_S, alias="startTime")] = 0.0
    end: Annotated[FiniteFloat, Field(le=LAST_S, alias="endTime")] = NO_END


_FILE = TypeAdapter(tuple[Flow, ...])


def read_cityflow_flow(
    path: str | Path, network: RoadNetwork, *, horizon_s: int | None = None
) -> FileDemand:
    """Read vehicles in CityFlow's flow format (ours).

    Each entry stands for vehicles at ``startTime`` and every ``interval`` seconds after it, up to
    and including ``endTime``; they appear at the next whole second, as with CityFlow's steps of
    1 s. A route of two roads that do not follow each other names origin and destination only: the
    shortest way by free-flow time joins them.

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
        If the file is missing, cut off, not JSON or of another shape, or a vehicle's route is not
        possible on the network.

    Notes
    -----
    The vehicles' lengths, speeds and accelerations are not read: see the scenario's
    ``QueueDynamics``. CityFlow joins the two roads by the shortest length.
    """
    flows = read_json(path, _FILE, content="a CityFlow flow file", error=DemandError)
    depart_s: list[int] = []
    routes: list[list[int]] = []
    known: dict[tuple[str, ...], list[int]] = {}
    for index, flow in enumerate(flows):
        where = f"{path}: [{index}]"
        if flow.route not in known:
            route = _joined(flow.route, network, where)
            known[flow.route] = link_indices(network, route, where=where)
        seconds = _departures_s(flow, horizon_s, where)
        depart_s.extend(seconds)
        routes.extend([known[flow.route]] * len(seconds))
    return FileDemand(network, in_order(np.array(depart_s, dtype=np.float64), routes))


def _departures_s(flow: Flow, horizon_s: int | None, where: str) -> list[int]:
    """Return the whole seconds in which an entry's vehicles appear."""
    start_s, end_s = math.ceil(flow.start), flow.end
    if end_s == NO_END:
        if horizon_s is None:
            raise DemandError(
                "it has no end (endTime is -1)",
                where=where,
                expected="an end, or a horizon at which to stop",
                mend="give horizon_s (--steps)",
            )
        end_s = horizon_s - 1
    elif end_s < flow.start:
        raise DemandError(
            f"endTime {flow.end:g} is before startTime {flow.start:g}",
            where=where,
            mend="correct one of them; for no end write -1",
        )
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


def _joined(route: tuple[str, ...], network: RoadNetwork, where: str) -> tuple[str, ...]:
    """Return the route, with the way between two roads that are only origin and destination."""
    if len(route) != 2 or not all(road in network.link_index for road in route):
        return route
    start, end = (network.link_index[road] for road in route)
    if first_gap(network, (start, end)) is None:
        return route
    ways = router(network).between_links([start], [end])
    if not ways:
        raise DemandError(
            f"there is no way from '{route[0]}' to '{route[1]}'",
            where=where,
            mend="check that network and vehicles belong together",
        )
    return tuple(network.links[link].id for link in ways[0][0])
