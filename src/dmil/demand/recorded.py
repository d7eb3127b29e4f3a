"""Vehicles of a file: departures and routes as recorded, or other days like the recorded one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from dmil.demand.vehicles import (
    FloatArray,
    IntArray,
    ScalableDemand,
    Vehicles,
    check_horizon,
    check_load,
)
from dmil.errors import DemandError
from dmil.network import RoadNetwork
from dmil.network.permissions import Classes


@dataclass(frozen=True, eq=False)
class FileDemand:
    """Recorded vehicles (paper, §III: "real-world data").

    Parameters
    ----------
    network
        The roads that the routes are on.
    recorded
        All vehicles of the record, in order of departure.
    load
        Mean number of times that every vehicle departs; see `scaled`.
    """

    network: RoadNetwork
    recorded: Vehicles
    load: float = 1.0

    @classmethod
    def from_routes(
        cls,
        network: RoadNetwork,
        depart_s: Sequence[float],
        routes: Sequence[Sequence[str]],
        *,
        where: str = "vehicles",
    ) -> FileDemand:
        """Build the demand from departure times and link ids.

        Parameters
        ----------
        network
            The roads.
        depart_s
            Departure of every vehicle in seconds, in any order; parts of a second are rounded up.
        routes
            Link ids of every vehicle in the order in which it drives along them.
        where
            What errors say the vehicles come from.

        Raises
        ------
        DemandError
            Naming the first vehicle whose departure or route is not possible.
        """
        if len(depart_s) != len(routes):
            raise DemandError(
                f"there are {len(depart_s)} departures and {len(routes)} routes",
                where=where,
                expected="one of each for every vehicle",
            )
        known: dict[tuple[str, ...], list[int]] = {}
        chosen: list[list[int]] = []
        for vehicle, (second, route) in enumerate(zip(depart_s, routes, strict=True)):
            if not (math.isfinite(second) and second >= 0):
                raise DemandError(
                    f"it departs at {second} s",
                    where=f"{where}[{vehicle}]",
                    expected="a time of 0 s or more",
                )
            key = tuple(route)
            if key not in known:
                known[key] = link_indices(network, key, where=f"{where}[{vehicle}]")
            chosen.append(known[key])
        return cls(network, in_order(np.ceil(np.asarray(depart_s, dtype=np.float64)), chosen))

    @property
    def last_departure_s(self) -> int:
        """Second of the last departure, -1 if there is no vehicle."""
        return int(self.recorded.depart_s[-1]) if len(self.recorded) else -1

    def vehicles(self, network: RoadNetwork, horizon_s: int, rng: np.random.Generator) -> Vehicles:
        """Return the recorded vehicles that depart before the horizon, and count the others.

        Nothing is drawn at load 1: the record is the same for every seed.

        Raises
        ------
        DemandError
            If the network is not the one of the routes.
        """
        check_horizon(horizon_s)
        if network is not self.network and network.links != self.network.links:
            raise DemandError(
                f"its routes are on the network '{self.network.name}', not on '{network.name}'",
                where="FileDemand",
                mend="read the vehicles again with this network",
            )
        times = np.ones(len(self.recorded), dtype=np.int64)
        if self.load != 1.0:
            whole = math.floor(self.load)
            times = whole + (rng.random(len(times)) < self.load - whole)
        chosen = np.repeat(np.arange(len(times)), times)
        within = self.recorded.depart_s[chosen] < horizon_s
        return self.recorded.take(chosen[within], dropped=int(np.sum(~within)))

    def scaled(self, load: float) -> FileDemand:
        """Return the demand with ``load`` times as many vehicles in the mean.

        Every vehicle departs ⌊load⌋ times in its second, and with the probability of the remainder
        once more; below 1, vehicles are left out at random.
        """
        check_load(load)
        return replace(self, load=self.load * load)


def link_indices(network: RoadNetwork, route: Sequence[str], *, where: str) -> list[int]:
    """Return the indices of a route's links after checking that vehicles can drive it.

    Raises
    ------
    DemandError
        Naming the place ``where``, if the route is empty, has an unknown link, or two of its links
        are not joined by a movement.
    """
    indices = known_links(network, route, where=where)
    gap = first_gap(network, indices)
    if gap is not None:
        raise DemandError(
            f"its route goes from '{route[gap]}' to '{route[gap + 1]}', but no movement joins them",
            where=where,
            mend="add the movement to the network, or correct the route",
        )
    return indices


def known_links(network: RoadNetwork, route: Sequence[str], *, where: str) -> list[int]:
    """Return the indices of a route's links; whether they follow each other is not checked (ours).

    Raises
    ------
    DemandError
        If the route is empty or has an unknown link.
    """
    if not route:
        raise DemandError("its route is empty", where=where, expected="at least one link")
    for link in route:
        if link not in network.link_index:
            raise DemandError(
                f"its route is over '{link}', which the network does not have",
                where=where,
                expected=f"a link of the network '{network.name}'",
                mend="check that network and vehicles belong together",
            )
    return [network.link_index[link] for link in route]


def first_gap(
    network: RoadNetwork, route: Sequence[int], classes: Classes = frozenset()
) -> int | None:
    """Return after which link of a route vehicles may not go to the next, None if they may.

    A link at which they may not begin counts as well. Without classes movements alone decide.
    """
    allowed = network.permissions
    if allowed and route and not allowed.open_to(network.links[route[0]].id, classes):
        return 0
    successors = network.successors_for(classes)
    for place, (here, there) in enumerate(pairwise(route)):
        if all(there != link for link, _ in successors[here]):
            return place
    return None


def in_order(
    depart_s: FloatArray | IntArray,
    routes: Sequence[Sequence[int] | IntArray],
    kind: Sequence[int] | IntArray | None = None,
) -> Vehicles:
    """Sort vehicles by departure; those of one second stay in the order of the record.

    ``depart_s`` is (vehicles,) in whole seconds; ``kind`` has their rows in the demand's table,
    see `Vehicles`.
    """
    order = np.argsort(depart_s, kind="stable")
    offset = np.zeros(len(routes) + 1, dtype=np.int32)
    np.cumsum([len(route) for route in routes], out=offset[1:])
    links = np.array([link for route in routes for link in route], dtype=np.int32)
    kinds = None if kind is None else np.array(kind, dtype=np.int32)
    return Vehicles(depart_s.astype(np.int32), offset, links, kind=kinds).take(order)


SHIFT_S = 60


@dataclass(frozen=True, eq=False)
class ResampledDemand:
    """Days as a recorded one might have been, another for every seed (ours).

    As many vehicles as recorded are drawn from the record with replacement, and each departs up to
    some time sooner or later, uniformly: routes and rates over the hour stay, who comes when does
    not. One recorded day alone says nothing of how sure a difference between controllers is.

    Parameters
    ----------
    base
        The recorded demand.
    shift_s
        Most seconds that a departure moves; it stays within the run.

    Raises
    ------
    DemandError
        If the shift is negative.
    """

    base: ScalableDemand
    shift_s: int = SHIFT_S

    def __post_init__(self) -> None:
        if self.shift_s < 0:
            raise DemandError(
                f"departures move by {self.shift_s} s",
                where="shift_s",
                expected="a whole number of 0 or more",
            )

    def vehicles(self, network: RoadNetwork, horizon_s: int, rng: np.random.Generator) -> Vehicles:
        """Draw the vehicles of a day; see `Demand`."""
        recorded = self.base.vehicles(network, horizon_s, rng)
        count = len(recorded)
        if not count:
            return recorded
        day = recorded.take(rng.integers(0, count, count), dropped=recorded.dropped)
        moved_s = day.depart_s + rng.integers(-self.shift_s, self.shift_s + 1, count)
        depart_s = np.clip(moved_s, 0, horizon_s - 1).astype(np.int32)
        order = np.argsort(depart_s, kind="stable")
        return replace(
            day.take(order, dropped=recorded.dropped),
            depart_s=np.ascontiguousarray(depart_s[order]),
        )

    def scaled(self, load: float) -> ResampledDemand:
        """Return the demand over the scaled record."""
        return replace(self, base=self.base.scaled(load))
