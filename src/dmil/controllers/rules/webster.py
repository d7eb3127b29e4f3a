"""Webster's fixed-time plan: cycle and splits from the mean flows.

With the flow ratio y_j = q_j / (lanes_j · s) of every movement (flow q in veh/s, saturation flow s
per lane), y_p the critical one of phase p, Y = Σ y_p over the n phases of the cycle, and the lost
time per cycle L = n · (clearance + start-up lost time):

    C0 = (1.5·L + 5) / (1 − Y)      seconds, between min_cycle_s and max_cycle_s,

``max_cycle_s`` where Y ≥ 1. A cycle consists of K whole decision intervals of T seconds; clearance
lies within a phase's first one. Splits make the degrees of saturation equal, as Webster's do, as
far as whole intervals can: each phase gets its least number of intervals k_p, and each one left
goes to the phase with the highest

    x_p = y_p·K·T / (k_p·T − lost time).

K is C0 / T rounded to the nearest number that gives every phase its least green; but where whole
intervals are so coarse that some x_p is above 0.9, the next larger K up to ``max_cycle_s`` without
such a phase, or if there is none the K with the lowest highest x_p.

Source: Webster (1958), "Traffic signal settings", Road Research Technical Paper 39. Ours: the
choice of phases, whole intervals, and lanes that movements share (see below). The flows are those
of the run's own journeys: a plan as good as counts can make it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import combinations

import numpy as np
from pydantic import Field

from dmil.arrays import FloatArray, IntArray
from dmil.controllers.parameters import Settings
from dmil.controllers.protocol import RunContext
from dmil.controllers.rules.baselines import Cycles
from dmil.demand import Vehicles
from dmil.errors import InputError
from dmil.network import Intersection, RoadNetwork
from dmil.scenarios import UniformTiming, uniform_timing
from dmil.simulation import Observation
from dmil.simulation.stand_ins import covering_phases

PRACTICAL_SATURATION = 0.9
"""Degree of saturation above which queues of random arrivals grow long (Webster 1958)."""
MOST_SETS = 20_000
"""Sets of phases that are compared; with more the first phases that cover all movements do."""


class WebsterSettings(Settings):
    """Webster's plan."""

    saturation_flow_veh_per_s: float | None = Field(
        default=None,
        gt=0,
        allow_inf_nan=False,
        description="Saturation flow in vehicles per second and lane; by default the scenario's "
        "(1 on the paper's grids, 0.5 or calibrated on real networks).",
    )
    min_cycle_s: float = Field(
        default=0.0, ge=0, allow_inf_nan=False, description="Shortest cycle in s."
    )
    max_cycle_s: float = Field(
        default=120.0,
        gt=0,
        allow_inf_nan=False,
        description="Longest cycle in s, also used beyond capacity; more only where minimum "
        "greens need it.",
    )


class WebsterController:
    """Shows Webster's plan for the mean flows of the run."""

    def __init__(self, settings: WebsterSettings | None = None) -> None:
        self.settings = settings or WebsterSettings()

    def reset(self, context: RunContext) -> None:
        """Make the plan of every intersection.

        Raises
        ------
        InputError
            If the journeys are not known.
        """
        if context.vehicles is None:
            raise InputError(
                "it does not get the journeys of the run, which give the flows",
                where="controller 'webster'",
                mend="give RunContext the vehicles, or choose the controller fixed-cycle",
            )
        flow_veh_per_s = mean_flows(context.network, context.vehicles)
        saturation = (
            self.settings.saturation_flow_veh_per_s or context.dynamics.saturation_flow_veh_per_s
        )
        network, timing = context.network, context.timing
        self.plans = [
            self._plan(
                item, flow_ratios(item, flow, saturation), uniform_timing(timing, network, i)
            )
            for i, (item, flow) in enumerate(
                zip(network.intersections, flow_veh_per_s, strict=True)
            )
        ]
        cycles = [
            [phase for phase, intervals in plan.items() for _ in range(intervals)]
            for plan in self.plans
        ]
        self._cycles = Cycles(cycles, context.decision_interval_s)

    def decide(self, observation: Observation, reward: FloatArray | None) -> IntArray:
        """Look up the phase for this time."""
        return self._cycles.at(observation.time_s)

    def _plan(
        self, item: Intersection, ratio: Sequence[float], timing: UniformTiming
    ) -> dict[int, int]:
        """Return how many decision intervals each phase of the cycle is shown.

        Of the sets of phases that serve everybody the one with the shortest cycle is taken, of
        those with equal cycles the one with the lowest degree of saturation.
        """
        lost_s = timing.clearance_s + timing.startup_lost_s
        shortest_s, longest_s = self.settings.min_cycle_s, self.settings.max_cycle_s
        candidates = []
        for phases in covers(item):
            critical = critical_ratios(item, phases, ratio)
            cycle_s = webster_cycle_s(len(phases) * lost_s, sum(critical))
            cycle_s = min(max(cycle_s, shortest_s), longest_s)
            shares, worst = whole_intervals(critical, cycle_s, longest_s, timing)
            candidates.append((sum(shares), worst, phases, shares))
        _, _, phases, shares = min(candidates)
        return dict(zip(phases, shares, strict=True))


def mean_flows(network: RoadNetwork, vehicles: Vehicles) -> FloatArray:
    """Return the mean flow of every movement up to the last departure (ours).

    Returns
    -------
    flow_veh_per_s: (intersections, movements) float64
    """
    width = max(len(item.movements) for item in network.intersections)
    flow = np.zeros((len(network.intersections), width))
    if not len(vehicles):
        return flow
    route, links = vehicles.route_links.astype(np.int64), len(network.links)
    goes_on = np.ones(route.size, np.bool_)
    goes_on[vehicles.route_offset[1:] - 1] = False
    before = np.flatnonzero(goes_on)
    pairs, counts = np.unique(route[before] * links + route[before + 1], return_counts=True)
    for pair, count in zip(pairs.tolist(), counts.tolist(), strict=True):
        place = network.movement_index.get((pair // links, pair % links))
        if place is not None:
            flow[place] = count
    return flow / (int(vehicles.depart_s[-1]) + 1)


def flow_ratios(
    item: Intersection, flow_veh_per_s: FloatArray, saturation_veh_per_s: float
) -> list[float]:
    """Return the flow ratio of every movement: that of its fullest lane (ours).

    A movement's flow is spread evenly over its lanes; in a lane that several movements share all of
    them count.
    """
    lane_flow: dict[tuple[str, int], float] = {}
    for movement, flow in zip(item.movements, flow_veh_per_s.tolist(), strict=False):
        for lane in movement.lanes:
            key = movement.from_link, lane
            lane_flow[key] = lane_flow.get(key, 0.0) + flow / len(movement.lanes)
    return [
        max(lane_flow[movement.from_link, lane] for lane in movement.lanes) / saturation_veh_per_s
        for movement in item.movements
    ]


def covers(item: Intersection) -> list[tuple[int, ...]]:
    """Return the sets of phases that serve all signalled movements and none of which can go (ours).

    Every set is in the order of the network. Where there would be too many to look at, only the
    phases that serve something new in that order are returned.
    """
    needed = frozenset().union(*item.phases) - item.unsignalled
    first = tuple(covering_phases(item))
    found: list[tuple[int, ...]] = []
    looked_at = 0
    for size in range(1, len(item.phases) + 1):
        looked_at += math.comb(len(item.phases), size)
        if looked_at > MOST_SETS:
            return found or [first]
        for chosen in combinations(range(len(item.phases)), size):
            if needed <= frozenset().union(*(item.phases[phase] for phase in chosen)) and not any(
                set(smaller) <= set(chosen) for smaller in found
            ):
                found.append(chosen)
    return found


def critical_ratios(
    item: Intersection, phases: Sequence[int], ratio: Sequence[float]
) -> list[float]:
    """Return the critical flow ratio of every phase of a cycle (Webster 1958; overlaps ours).

    It is the highest among the movements that only this phase serves. A movement that several
    phases serve and that needs more than all of them adds the rest to them in equal parts.
    """
    critical = dict.fromkeys(phases, 0.0)
    serving = [[p for p in phases if j in item.phases[p]] for j in range(len(item.movements))]
    for j in sorted(range(len(serving)), key=lambda j: len(serving[j])):
        if serving[j] and j not in item.unsignalled:
            missing = ratio[j] - sum(critical[p] for p in serving[j])
            for p in serving[j]:
                critical[p] += max(missing, 0.0) / len(serving[j])
    return list(critical.values())


def webster_cycle_s(lost_s: float, flow_ratio: float) -> float:
    """Return the cycle of least delay, (1.5·L + 5) / (1 − Y) (Webster 1958).

    Parameters
    ----------
    lost_s
        L: lost time per cycle.
    flow_ratio
        Y: sum of the critical flow ratios; from 1 on the cycle is infinite.
    """
    return (1.5 * lost_s + 5.0) / (1.0 - flow_ratio) if flow_ratio < 1.0 else math.inf


def intervals_allowed(timing: UniformTiming) -> tuple[int, float]:
    """Return the least and the most decision intervals that the signals let a phase last (ours)."""
    least_s = timing.clearance_s + max(timing.min_green_s, 1)
    least = math.ceil(least_s / timing.decision_interval_s)
    if not timing.max_green_s:
        return least, math.inf
    most_s = timing.clearance_s + timing.max_green_s
    return least, max(least, math.ceil(most_s / timing.decision_interval_s))


def whole_intervals(
    critical: Sequence[float], cycle_s: float, longest_s: float, timing: UniformTiming
) -> tuple[list[int], float]:
    """Turn a cycle and critical flow ratios into whole intervals; see the top of this file (ours).

    Parameters
    ----------
    critical
        Critical flow ratio of every phase.
    cycle_s, longest_s
        Cycle that is wanted, and the longest one.

    Returns
    -------
    tuple
        Decision intervals of every phase, and the highest degree of saturation.
    """
    interval_s = timing.decision_interval_s
    lost_s = timing.clearance_s + timing.startup_lost_s
    least, most = intervals_allowed(timing)
    first = max(math.floor(cycle_s / interval_s + 0.5), least * len(critical))
    best: tuple[float, list[int]] = math.inf, []
    for count in range(first, max(first, math.floor(longest_s / interval_s)) + 1):
        shares = split(critical, count, least, most, interval_s, lost_s)
        worst = max(
            ratio * sum(shares) * interval_s / max(share * interval_s - lost_s, 1)
            for ratio, share in zip(critical, shares, strict=True)
        )
        if worst < best[0]:
            best = worst, shares
        if worst <= PRACTICAL_SATURATION:
            break
    return best[1], best[0]


def split(
    critical: Sequence[float], count: int, least: int, most: float, interval_s: int, lost_s: int
) -> list[int]:
    """Share K intervals among the phases of a cycle; see the top of this file (ours).

    Parameters
    ----------
    critical
        Critical flow ratio of every phase.
    count
        K: intervals of the cycle.
    least, most
        Fewest and most intervals of a phase.
    interval_s, lost_s
        T, and the lost time of a phase.
    """
    share = [least] * len(critical)
    for _ in range(count - sum(share)):
        saturation = [
            ratio / max(intervals * interval_s - lost_s, 1) if intervals < most else -1.0
            for ratio, intervals in zip(critical, share, strict=True)
        ]
        fullest = max(range(len(share)), key=saturation.__getitem__)
        if saturation[fullest] < 0:
            break
        share[fullest] += 1
    return share
