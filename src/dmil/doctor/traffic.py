"""What the vehicles of a demand do: when they depart, where they go, what they ask of signals."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from dmil.demand import Demand, SumoDemand, Vehicles
from dmil.doctor.case import Case
from dmil.doctor.load import Load, VehicleStream, load_of
from dmil.network.permissions import Classes
from dmil.scenarios import lost_s
from dmil.seeding import stream as random_stream
from dmil.simulation.queue.gaps import junctions_that_hold

IntArray = npt.NDArray[np.integer]
FloatArray = npt.NDArray[np.float64]

PEAK_S = 900
"""The busiest quarter of an hour decides, as usual for signals."""
SHORT_RUN_S = 900
MOST_BARS = 40
_BARS_S = (300, 900, 1800, 3600, 7200, 14400)


@dataclass(frozen=True, slots=True)
class Traffic:
    """The vehicles that were examined (ours).

    Parameters
    ----------
    vehicles
        Number of vehicles.
    random
        Whether another seed gives other vehicles.
    first_s, last_s
        First and last departure, in SUMO's seconds.
    bar_s
        Width of a bar of ``departures``.
    departures
        Departures per bar, from second 0 of the run on.
    signals_passed
        Mean number of intersections that a vehicle passes.
    signalled_share
        Part of the vehicles that pass one at least.
    giving_way_share
        Part of the vehicles that pass a junction without signals where they may have to wait.
    length_m, links, free_flow_s
        Mean length of a route, in metres, in links, and in seconds without any delay.
    crossing
        For every intersection the vehicles of each movement, in all of the run.
    load
        Of every intersection, in its busiest 15 minutes.
    entries_veh_per_s
        (links,) vehicles that begin on a link, in its busiest 15 minutes.
    ends
        Nodes at which a route begins or ends.
    """

    vehicles: int
    random: bool
    first_s: int
    last_s: int
    bar_s: int
    departures: tuple[int, ...]
    signals_passed: float
    signalled_share: float
    giving_way_share: float
    length_m: float
    links: float
    free_flow_s: float
    crossing: tuple[tuple[int, ...], ...]
    load: tuple[Load, ...]
    entries_veh_per_s: tuple[float, ...]
    ends: frozenset[str]


def traffic_of(case: Case) -> Traffic | None:
    """Look at the vehicles of seed 0; None if there are none (ours)."""
    vehicles = None if case.demand is None else _vehicles(case, case.demand, 0)
    if case.demand is None or vehicles is None or not len(vehicles):
        return None
    network, count, route = case.network, len(vehicles), vehicles.route_links
    owner = np.repeat(np.arange(count), np.diff(vehicles.route_offset))
    ride_s = network.free_flow_time_s[route]
    # When vehicles would come to the end of each link of their route if nobody were in the way.
    end_s = np.cumsum(ride_s)
    first = vehicles.route_offset[:-1]
    end_s += (vehicles.depart_s - end_s[first] + ride_s[first])[owner]
    intersection, movement = _crossings(case, route, owner)
    crossed = np.flatnonzero(movement >= 0)
    passed = np.bincount(owner[crossed], minlength=count)
    bar_s = _bar_s(case.horizon_s)
    other = _vehicles(case, case.demand, 1)
    return Traffic(
        vehicles=count,
        random=not (
            np.array_equal(vehicles.depart_s, other.depart_s)
            and np.array_equal(route, other.route_links)
        ),
        first_s=int(vehicles.depart_s[0]) + case.begin_s,
        last_s=int(vehicles.depart_s[-1]) + case.begin_s,
        bar_s=bar_s,
        departures=tuple(
            np.bincount(vehicles.depart_s // bar_s, minlength=-(-case.horizon_s // bar_s)).tolist()
        ),
        signals_passed=float(passed.mean()),
        signalled_share=float((passed > 0).mean()),
        giving_way_share=_giving_way_share(case, route, owner, count),
        length_m=float(sum(network.links[link].length_m for link in route) / count),
        links=len(route) / count,
        free_flow_s=float(ride_s.sum() / count),
        crossing=_counts(case, intersection[crossed], movement[crossed]),
        load=_loads(
            case,
            end_s[crossed],
            intersection[crossed],
            movement[crossed],
            _class_of(case, vehicles)[owner[crossed]],
        ),
        entries_veh_per_s=_entries(case, vehicles),
        ends=frozenset(
            (
                *(network.links[link].start for link in np.unique(route[first])),
                *(
                    network.links[link].end
                    for link in np.unique(route[vehicles.route_offset[1:] - 1])
                ),
            )
        ),
    )


def _vehicles(case: Case, demand: Demand, seed: int) -> Vehicles:
    return demand.vehicles(case.network, case.horizon_s, random_stream(seed, "demand"))


def _giving_way_share(case: Case, route: IntArray, owner: IntArray, count: int) -> float:
    held = junctions_that_hold(case.network, storage=False)
    ids = {junction.id for junction in held}
    ends = np.array([link.end in ids for link in case.network.links])
    onward = np.append(owner[:-1] == owner[1:], False)
    return float(np.unique(owner[ends[route] & onward]).size / count)


def _bar_s(horizon_s: int) -> int:
    if horizon_s <= SHORT_RUN_S:
        return 60
    return next((each for each in _BARS_S if horizon_s <= each * MOST_BARS), 86400)


def _crossings(case: Case, route: IntArray, owner: IntArray) -> tuple[IntArray, IntArray]:
    """Return for every place of all routes the intersection and movement that follow, or -1."""
    number = len(case.network.links)
    key = np.append(route[:-1].astype(np.int64) * number + route[1:], -1)
    key[np.append(owner[:-1] != owner[1:], True)] = -1
    kinds, place = np.unique(key, return_inverse=True)
    known = case.network.movement_index
    pairs = np.array([known.get(divmod(int(each), number), (-1, -1)) for each in kinds])
    return pairs[place, 0], pairs[place, 1]


def _counts(case: Case, intersection: IntArray, movement: IntArray) -> tuple[tuple[int, ...], ...]:
    return tuple(
        tuple(np.bincount(movement[intersection == i], minlength=len(item.movements)).tolist())
        for i, item in enumerate(case.network.intersections)
    )


def _classes(case: Case) -> list[Classes]:
    """Return what vehicles are of, as far as that is known."""
    return list(dict.fromkeys(case.demand.classes if isinstance(case.demand, SumoDemand) else ()))


def _class_of(case: Case, vehicles: Vehicles) -> IntArray:
    """Return every vehicle's place in the list of classes: (vehicles,)."""
    if vehicles.kind is None or not isinstance(case.demand, SumoDemand):
        return np.zeros(len(vehicles), np.int64)
    known = _classes(case)
    return np.array([known.index(each) for each in case.demand.classes])[vehicles.kind]


def _loads(
    case: Case,
    time_s: FloatArray,
    intersection: IntArray,
    movement: IntArray,
    class_of: IntArray,
) -> tuple[Load, ...]:
    windows, lasting_s = _windows(case.horizon_s)
    classes = _classes(case) or [Classes()]
    window = (time_s // PEAK_S).astype(np.int64)
    clearance_s = (lost_s(case.timing, case.network) - case.timing.startup_lost_s).tolist()
    loads = []
    for i, item in enumerate(case.network.intersections):
        mine = (intersection == i) & (window < windows)
        streams = [
            VehicleStream(j, case.network.lanes_to(each, kind))
            for kind in classes
            for j, each in enumerate(item.movements)
        ]
        flow = np.zeros((windows, len(streams)))
        stream = class_of[mine] * len(item.movements) + movement[mine]
        np.add.at(flow, (window[mine], stream), 1.0)
        flow /= lasting_s[:, None]
        busiest = flow[int(flow.sum(axis=1).argmax())]
        saturation_veh_per_s = case.dynamics.saturation_flow_veh_per_s
        loads.append(load_of(item, busiest, saturation_veh_per_s, clearance_s[i], streams))
    return tuple(loads)


def _windows(horizon_s: int) -> tuple[int, FloatArray]:
    """Return the number of windows and how long each lasts; a short rest at the end is left out."""
    whole, rest = divmod(horizon_s, PEAK_S)
    lasting = [float(PEAK_S)] * whole
    if rest >= PEAK_S / 2 or not whole:
        lasting.append(float(rest))
    return len(lasting), np.array(lasting)


def _entries(case: Case, vehicles: Vehicles) -> tuple[float, ...]:
    windows, lasting_s = _windows(case.horizon_s)
    window = vehicles.depart_s // PEAK_S
    inside = window < windows
    count = np.zeros((windows, len(case.network.links)))
    first = vehicles.route_links[vehicles.route_offset[:-1]]
    np.add.at(count, (window[inside], first[inside]), 1.0)
    return tuple((count / lasting_s[:, None]).max(axis=0).tolist())
