"""What disturbs a run of the study of capacity, and how long it takes to be over it."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from dmil.demand import FileDemand, ResampledDemand, Vehicles
from dmil.demand.levels import DemandLevels
from dmil.network import RoadNetwork
from dmil.seeding import stream
from dmil.simulation import ClosedLane, Sensors

INCIDENT, SURGE, NOISE = "incident", "surge", "noise"
DEAD, FAILING = "dead-detectors", "failing-detectors"
SAME_DAY, OTHER_DAY = "same-day", "other-day"
"""Values of the column ``variant``; null is the undisturbed run. The last two are after training
on the vehicles of the undisturbed run: on these again, and on another day."""
PASSING = (INCIDENT, SURGE)
"""Those that end."""
REFERENCE_OF = {OTHER_DAY: SAME_DAY, **dict.fromkeys((INCIDENT, SURGE, DEAD, FAILING, NOISE))}
"""Each disturbance to the run that it is compared with, None for the undisturbed one."""
CLOSED_S, SURGE_S = 600, 1200
SURGE_FACTOR = 1.3
DEAD_SHARE, MISSED_SHARE, FALSE_VEH = 0.1, 0.1, 0.2
DAY_SHIFT_S = 300
WINDOW_S = 300
SHARE, SPARE_VEH = 0.1, 1.0
"""A run has recovered when so much more wait at most: share of the undisturbed mean, and a rest."""


def begin_s(horizon_s: int) -> int:
    """Return when incident and surge begin, and detectors fail: after a quarter of a run."""
    return horizon_s // 4


def sensors_of(horizon_s: int) -> dict[str, Sensors]:
    """Return what sensors do wrong under each disturbance of theirs (ours)."""
    return {
        DEAD: Sensors(dead_share=DEAD_SHARE),
        FAILING: Sensors(dead_share=DEAD_SHARE, dead_from_s=begin_s(horizon_s)),
        NOISE: Sensors(missed_share=MISSED_SHARE, false_veh=FALSE_VEH),
    }


def busy_lane(network: RoadNetwork, vehicles: Vehicles, horizon_s: int, seed: int) -> ClosedLane:
    """Return the lane that an incident closes: one that a vehicle drawn at random drives in (ours).

    So busy lanes are closed more often, as they have more incidents. The vehicle departs within
    the incident where one does, and the lane is drawn from those of one of its movements, drawn
    likewise.
    """
    rng = stream(seed, "disturbances", "incident")
    since_s = begin_s(horizon_s)
    until_s = min(since_s + CLOSED_S, horizon_s)
    movements = {
        (network.link_index[each.from_link], network.link_index[each.to_link]): each
        for item in network.intersections
        for each in item.movements
    }
    within = (vehicles.depart_s >= since_s) & (vehicles.depart_s < until_s)
    for vehicle in rng.permutation(np.flatnonzero(within) if within.any() else len(vehicles)):
        route = vehicles.route(int(vehicle)).tolist()
        crossed = [movements[pair] for pair in pairwise(route) if pair in movements]
        if crossed:
            chosen = crossed[rng.integers(len(crossed))]
            lane = chosen.lanes[rng.integers(len(chosen.lanes))]
            return ClosedLane(chosen.from_link, lane, since_s, until_s)
    first = network.intersections[0].movements[0]
    return ClosedLane(first.from_link, first.lanes[0], since_s, until_s)


@dataclass(frozen=True, eq=False)
class Days:
    """The vehicles of one seed: the day itself, with a surge, and another day."""

    day: Vehicles
    surge: Vehicles
    other: Vehicles


def days_of(
    levels: DemandLevels, load: float, network: RoadNetwork, horizon_s: int, seed: int
) -> Days:
    """Return the days of one seed at a load (ours)."""
    since_s = begin_s(horizon_s)
    day = levels.at(load)
    other = ResampledDemand(FileDemand(network, day), DAY_SHIFT_S)
    return Days(
        day,
        levels.with_surge(load, SURGE_FACTOR, since_s, since_s + SURGE_S),
        other.vehicles(network, horizon_s, stream(seed, "disturbances", "other day")),
    )


def recovery_s(
    waiting_veh: npt.NDArray[np.integer], undisturbed_veh: npt.NDArray[np.integer], end_s: int
) -> int:
    """Return how long after a disturbance about as many vehicles wait as without it (ours).

    That is the first second after whose five minutes on average no more wait than in the
    undisturbed run on the same seed, but for a tenth of its mean and one vehicle.

    Parameters
    ----------
    waiting_veh, undisturbed_veh: (seconds,)
        Vehicles that wait after each second.
    end_s
        When the disturbance ended.

    Returns
    -------
    Time in s; up to the end of the run if it has not recovered by then.
    """
    excess = waiting_veh.astype(np.float64) - undisturbed_veh
    allowed = SHARE * float(undisturbed_veh.mean()) + SPARE_VEH
    window = min(WINDOW_S, len(excess) - end_s)
    total = np.concatenate([[0.0], np.cumsum(excess[end_s:])])
    means = (total[window:] - total[:-window]) / window if window > 0 else np.zeros(1)
    over = np.flatnonzero(means <= allowed)
    return int(over[0]) if over.size else len(excess) - end_s
