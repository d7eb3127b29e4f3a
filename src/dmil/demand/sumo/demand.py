"""The vehicles of SUMO's files as a demand."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from dmil.demand.recorded import FileDemand, in_order
from dmil.demand.sumo.beside import NOTHING, Beside
from dmil.demand.sumo.departures import Drawn, Listed
from dmil.demand.sumo.remarks import DemandRemark
from dmil.demand.sumo.ways import Choice, Ends
from dmil.demand.vehicles import FloatArray, Vehicles, check_horizon
from dmil.network import RoadNetwork
from dmil.network.permissions import Classes


@dataclass(frozen=True, slots=True)
class Stream:
    """Vehicles of one definition of which something is random (ours).

    Parameters
    ----------
    departures
        When they depart, in SUMO's seconds.
    choice
        Routes and their probabilities.
    kind
        Row in the demand's table.
    ends
        From where to where they go, if no file says their route.
    """

    departures: Listed | Drawn
    choice: Choice
    kind: int
    ends: Ends | None = None

    def draw(self, begin_s: float, horizon_s: int, rng: np.random.Generator) -> Vehicles:
        """Draw the departures, then the routes if there are several.

        ``begin_s`` is SUMO's second that is second 0 of the run, which ends ``horizon_s`` after it.
        """
        times = self.departures.draw(begin_s + horizon_s, rng) - begin_s
        depart_s = np.ceil(np.round(times[times >= 0], 3))
        way = np.zeros(len(depart_s), dtype=np.int64)
        if len(self.choice) > 1:
            below = np.cumsum([probability for _, probability in self.choice])[:-1]
            way = np.searchsorted(below, rng.random(len(depart_s)), side="right")
        routes = [self.choice[index][0] for index in way]
        return in_order(depart_s, routes, [self.kind] * len(routes))


@dataclass(frozen=True, eq=False)
class SumoDemand:
    """Vehicles, trips and flows of SUMO's files (ours).

    Parameters
    ----------
    recorded
        The vehicles of which nothing is random.
    streams
        The others.
    begin_s
        SUMO's second that is second 0 of a run.
    kinds
        Attributes that SUMO's ``<vehicle>`` has beside id, departure and route, such as ``type``
        and ``departSpeed``; ``Vehicles.kind`` are indices into it.
    classes
        The vehicle classes of every such kind.
    vehicle_types_xml
        The ``<vType>`` and ``<vTypeDistribution>`` elements, one a line, without a root element.
    vehicle_space_m
        Mean length and least gap of the vehicles.
    remarks
        What was left out of the files, and why.
    trips
        For those of the recorded vehicles whose route no file says: from where to where they go.
    exact_depart_s: (recorded vehicles,) float64
        Their departures before they were rounded up to whole seconds.
    persons_xml
        The persons who walk, as XML elements in the order of departure, without a root element.
    beside
        What SUMO runs beside them.
    """

    recorded: FileDemand
    streams: tuple[Stream, ...]
    begin_s: float
    kinds: tuple[dict[str, str], ...]
    classes: tuple[Classes, ...]
    vehicle_types_xml: str
    vehicle_space_m: float
    remarks: tuple[DemandRemark, ...]
    trips: Mapping[int, Ends]
    exact_depart_s: FloatArray
    persons_xml: str = ""
    beside: Beside = NOTHING

    @property
    def last_departure_s(self) -> int:
        """Second of the last departure that is to be expected, -1 if there is no vehicle."""
        drawn = [math.ceil(each.departures.last_s - self.begin_s) for each in self.streams]
        return max([self.recorded.last_departure_s, *drawn])

    @property
    def unrouted(self) -> list[Ends]:
        """From where to where those go whose route no file says: trips, then streams."""
        return [*self.trips.values(), *(each.ends for each in self.streams if each.ends)]

    @property
    def class_counts(self) -> dict[Classes, float]:
        """How many vehicles of which classes there are, of random flows the mean number."""
        found = dict.fromkeys(self.classes, 0.0)
        recorded = self.recorded.recorded.kind
        for kind, count in enumerate(np.bincount([] if recorded is None else recorded)):
            found[self.classes[kind]] += float(count)
        for each in self.streams:
            found[self.classes[each.kind]] += each.departures.mean_veh
        return found

    def on_network(self, network: RoadNetwork) -> SumoDemand:
        """Return the demand on the same roads with other lanes open."""
        return replace(self, recorded=replace(self.recorded, network=network))

    def vehicles(self, network: RoadNetwork, horizon_s: int, rng: np.random.Generator) -> Vehicles:
        """Return the vehicles that depart before the horizon, and count the others.

        Nothing is drawn if nothing of the files is random and the load is 1.

        Raises
        ------
        DemandError
            If the network is not the one of the routes.
        """
        check_horizon(horizon_s)
        drawn = [each.draw(self.begin_s, horizon_s, rng) for each in self.streams]
        everyone = _together([self.recorded.recorded, *drawn]) if drawn else self.recorded.recorded
        return replace(self.recorded, recorded=everyone).vehicles(network, horizon_s, rng)

    def scaled(self, load: float) -> SumoDemand:
        """Return the demand with ``load`` times as many vehicles in the mean.

        Every vehicle departs ⌊load⌋ times in its second, and with the probability of the remainder
        once more; below 1, vehicles are left out at random.
        """
        return replace(self, recorded=self.recorded.scaled(load))

    def on_ways(
        self, ways: Mapping[int, Sequence[int]], choices: Mapping[int, Choice]
    ) -> SumoDemand:
        """Return the demand with other ways for some of the vehicles.

        Parameters
        ----------
        ways
            Number of a recorded vehicle to its link indices, which must be a way of the network.
        choices
            Number of a stream to its ways, likewise, and their probabilities.
        """
        before = self.recorded.recorded
        routes = [ways.get(v, before.route(v)) for v in range(len(before))]
        after = in_order(before.depart_s, routes, before.kind)
        streams = [
            replace(each, choice=choices.get(number, each.choice))
            for number, each in enumerate(self.streams)
        ]
        recorded = replace(self.recorded, recorded=after)
        return replace(self, recorded=recorded, streams=tuple(streams))


def _together(parts: Sequence[Vehicles]) -> Vehicles:
    """Put vehicles into one order of departure; those of one second stay in the given order."""
    lengths = np.concatenate([np.diff(part.route_offset) for part in parts])
    offset = np.zeros(len(lengths) + 1, dtype=np.int32)
    np.cumsum(lengths, out=offset[1:])
    depart_s = np.concatenate([part.depart_s for part in parts])
    links = np.concatenate([part.route_links for part in parts])
    kind = np.concatenate([part.kind for part in parts if part.kind is not None])
    together = Vehicles(depart_s, offset, links, kind=kind)
    return together.take(np.argsort(depart_s, kind="stable"))
