"""Scenarios from SUMO's files."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

from dmil.demand.sumo import read_sumo_routes
from dmil.demand.sumo.remarks import remarks_on_options
from dmil.demand.sumo.routing import routed_by_sumo, sumo_is_installed, with_remark
from dmil.errors import InputError
from dmil.network.sumo import read_sumo_network
from dmil.network.sumo.reader import Phases, driven_by
from dmil.scenarios.model import FROM_FILES, QueueDynamics, Routing, Scenario, SumoFiles, horizon_of
from dmil.scenarios.sumo_configuration import SumoConfiguration, driving, read_sumo_configuration
from dmil.scenarios.timing import PLAN, SignalTiming

DECISION_INTERVAL_S = 10
"""As in the RESCO benchmark."""


def sumo_scenario(
    files: str | Path | SumoConfiguration,
    *,
    begin_s: int | None = None,
    horizon_s: int | None = None,
    phases: Phases = "program",
    routing: Routing | None = None,
    timing: SignalTiming | None = None,
    dynamics: QueueDynamics | None = None,
    name: str | None = None,
) -> Scenario:
    """Build a scenario from SUMO's network and route files (ours; decision interval: RESCO).

    Parameters
    ----------
    files
        A ``.sumocfg``, or what one would say.
    begin_s
        SUMO's second at which a run begins; if not given, the configuration's.
    horizon_s
        Length of a run in seconds; if not given, up to the configuration's end, and without one
        the last departure rounded up to the next 600 s.
    phases
        ``"program"``: those of the network's own signal programs. ``"derived"``: made from the
        movements that do not cross.
    routing
        Ways of trips, which the files give no route. ``"sumo"``: SUMO runs once, on the network's
        own signal programs, and its choices are kept on disk, see
        `dmil.demand.sumo.routing.routed_by_sumo`. ``"mesoscopic"``: the same in a tenth of the
        time, since SUMO moves queues instead of single vehicles. ``"free-flow"``: the fastest
        without traffic. If not given, ``"sumo"`` where it is installed.
    timing
        Signal timing; if not given, decisions every 10 s, clearance and greens as each plan says.
    dynamics
        Queue dynamics; if not given 0.5 vehicles per second and lane, finite storage, and the
        vehicles' mean length and gap as their space.
    name
        Name of the scenario; if not given, ``sumo:`` and the network's name.

    Raises
    ------
    InputError
        If a file is not valid, the files do not belong together, no vehicle departs in time, or
        SUMO refuses to route.
    MissingExtraError
        If sumolib is not installed, or SUMO is not and shall route.
    """
    if isinstance(files, SumoConfiguration):
        given = files
    else:
        given = driving(read_sumo_configuration(files), str(files))
    begin_s = given.begin_s if begin_s is None else begin_s
    end_s = given.end_s if horizon_s is None else begin_s + horizon_s
    if end_s is not None and end_s <= begin_s:
        raise InputError(
            f"a run would begin at {begin_s} s and end at {end_s:g} s",
            where="begin_s",
            expected="an end after the beginning",
            mend="correct the begin, or say how long a run lasts (--steps)",
        )
    roads = read_sumo_network(
        given.net_file, phases=phases, additional=given.additional_files, begin_s=begin_s
    )
    demand = read_sumo_routes(
        given.route_files,
        roads.network,
        additional=given.additional_files,
        begin_s=begin_s,
        end_s=end_s,
        scale=given.scale,
    )
    told = (*given.unused, *(f"{name}={value}" for name, value in given.for_sumo))
    devices = remarks_on_options(told, len(demand.recorded.recorded))
    demand = replace(demand, remarks=(*demand.remarks, *devices))
    last_s = demand.last_departure_s
    horizon_s = horizon_of(last_s) if end_s is None else math.ceil(end_s - begin_s)
    chosen: Routing | None = None
    if demand.unrouted:
        chosen = routing or ("sumo" if sumo_is_installed() else "free-flow")
        if chosen != "free-flow":
            demand = routed_by_sumo(
                demand,
                roads.network,
                given.net_file,
                horizon_s,
                programs_xml=roads.added_programs_xml,
                mesoscopic=chosen == "mesoscopic",
            )
        else:
            demand = with_remark(demand, demand.unrouted)
    roads = driven_by(roads, demand.class_counts)
    demand = demand.on_network(roads.network)
    return Scenario(
        name=name or f"sumo:{roads.network.name}",
        network=roads.network,
        demand=demand,
        timing=timing or SignalTiming(decision_interval_s=DECISION_INTERVAL_S, **PLAN),
        dynamics=dynamics or QueueDynamics(**FROM_FILES, vehicle_space_m=demand.vehicle_space_m),
        horizon_s=horizon_s,
        sumo=SumoFiles(
            net_file=roads.path,
            signals=roads.signals,
            kinds=demand.kinds,
            classes=demand.classes,
            beside=demand.beside,
            persons_xml=demand.persons_xml,
            begin_s=begin_s,
            routing=chosen,
            programs_xml=roads.added_programs_xml,
            options=given.for_sumo,
        ),
    )
