"""The whole examination: what was understood, and what was found."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

from dmil.doctor.case import Case
from dmil.doctor.demand_findings import on_demand
from dmil.doctor.findings import SEVERITIES, Finding
from dmil.doctor.intersections import IntersectionFacts, intersections_of
from dmil.doctor.kinds import KINDS
from dmil.doctor.road_findings import on_roads
from dmil.doctor.traffic import Traffic, traffic_of
from dmil.network.geometry import road_ends


@dataclass(frozen=True, slots=True)
class NetworkFacts:
    """The network as it was understood (ours).

    Parameters
    ----------
    links, road_km, lane_km
        Number and length of the links, and of their lanes.
    slowest_km_per_h, fastest_km_per_h
        Limits of speed.
    intersections, shapes, junctions, fringe
        Nodes with signals, their shapes, nodes without signals that are crossed, and nodes where
        vehicles come and go.
    """

    links: int
    road_km: float
    lane_km: float
    slowest_km_per_h: float
    fastest_km_per_h: float
    intersections: int
    shapes: int
    junctions: int
    fringe: int


@dataclass(frozen=True, slots=True)
class Diagnosis:
    """What was understood and what was found (ours).

    Parameters
    ----------
    case
        What was examined.
    network, intersections, traffic
        What was understood; no traffic without vehicles.
    findings
        Errors first, then warnings, then notes; those of one kind together.
    """

    case: Case
    network: NetworkFacts
    intersections: tuple[IntersectionFacts, ...]
    traffic: Traffic | None
    findings: tuple[Finding, ...]

    @property
    def ends(self) -> frozenset[str]:
        """Nodes where vehicles come and go: those of the demand, without one where roads end."""
        return self.traffic.ends if self.traffic else road_ends(self.case.network)

    @property
    def counts(self) -> dict[str, int]:
        """How many findings of every severity there are."""
        found = Counter(each.severity for each in self.findings)
        return {severity: found[severity] for severity in SEVERITIES}


def examine(case: Case) -> Diagnosis:
    """Say what was understood of files, and what is wrong or suspicious about them (ours).

    Parameters
    ----------
    case
        What to examine, see `dmil.doctor.read_case`.
    """
    traffic = traffic_of(case)
    intersections = intersections_of(case, traffic)
    found = [*on_roads(case), *on_demand(case, traffic, intersections)]
    kinds = list(KINDS)
    found.sort(key=lambda each: (SEVERITIES.index(each.severity), kinds.index(each.kind)))
    return Diagnosis(
        case, _network(case, intersections, traffic), intersections, traffic, tuple(found)
    )


def _network(
    case: Case, intersections: tuple[IntersectionFacts, ...], traffic: Traffic | None
) -> NetworkFacts:
    network, closed = case.network, road_ends(case.network)
    speeds = [3.6 * link.speed_m_per_s for link in network.links]
    return NetworkFacts(
        links=len(network.links),
        road_km=sum(link.length_m for link in network.links) / 1000,
        lane_km=sum(link.length_m * link.lanes for link in network.links) / 1000,
        slowest_km_per_h=min(speeds),
        fastest_km_per_h=max(speeds),
        intersections=len(network.intersections),
        shapes=len({each.shape for each in intersections}),
        junctions=sum(junction.id not in closed for junction in network.junctions),
        fringe=len(traffic.ends if traffic else closed),
    )
