"""Scenarios by name."""

from __future__ import annotations

import re
from dataclasses import replace

from dmil.demand import Demand, PoissonDemand, ProfileDemand, ScalableDemand, Ties
from dmil.demand.vehicles import check_load
from dmil.errors import InputError, unknown_name
from dmil.network import grid
from dmil.network.sumo.reader import Phases
from dmil.scenarios.cityflow import cityflow_scenario, find_cityflow_files
from dmil.scenarios.demand_changes import with_ties
from dmil.scenarios.model import QueueDynamics, Routing, Scenario
from dmil.scenarios.names import PREFIX, RESCO, find_resco_configuration, kind_of, plain
from dmil.scenarios.sumo import sumo_scenario
from dmil.scenarios.timing import SignalTiming

RESCO_TIMING = SignalTiming(decision_interval_s=10, clearance_s=3)
"""The benchmark's protocol, whatever the plans in its files say."""
RESCO_TIMING_OF = {
    f"{PREFIX}arterial4x4": SignalTiming(decision_interval_s=5, clearance_s=2),
}
"""That of networks for which the benchmark's map configuration has times of its own."""
GRID_HORIZON_S = 300
GRID_DEMANDS: dict[str, Demand] = {
    "": PoissonDemand(),
    "unequal": PoissonDemand({"W": 20.0, "E": 2.0, "N": 3.0, "S": 2.0}),
    "time-varying": ProfileDemand(PoissonDemand(), (0, 1800, 3600), (0.5, 2.0, 0.5), "linear"),
}
"""What may stand behind a grid's name: the paper's demand; the same vehicles per minute in all,
nearly all of them from the west; the paper's rates times 0.5, rising to 2 in half an hour and
falling again (ours)."""

_NAMES = {
    "grid:1x1": "the paper's single intersection, Poisson demand, 300 s",
    "grid:3x3": "the paper's 9 intersections, Poisson demand, 300 s",
    "grid:5x5": "the paper's 25 intersections, Poisson demand, 300 s",
    "grid:ROWSxCOLUMNS": "any other grid, with the paper's rates at each of its fringe nodes",
    "grid:ROWSxCOLUMNS/unequal": "a grid with 20, 2, 3, 2 vehicles per minute from W, E, N, S",
    "grid:ROWSxCOLUMNS/time-varying": "a grid with the paper's rates times 0.5 to 2 to 0.5 in 1 h",
    "cityflow:FOLDER": "a folder with one roadnet*.json and one flow file, in CityFlow's format",
    "cityflow:FOLDER#FLOW_FILE": "the same, where the folder has several flow files",
    "sumo:FILE.sumocfg": "a SUMO configuration with its network, routes, begin and end",
    **RESCO,
}


def scenario_names() -> dict[str, str]:
    """Return the names that `scenario` understands, each with one line about it (ours)."""
    return dict(_NAMES)


def scenario(
    name: str,
    *,
    horizon_s: int | None = None,
    load: float = 1.0,
    timing: SignalTiming | None = None,
    dynamics: QueueDynamics | None = None,
    demand: Demand | None = None,
    begin_s: int | None = None,
    phases: Phases | None = None,
    routing: Routing | None = None,
    ties: Ties | None = None,
    link_time_s: float | None = None,
    entry_link_time_s: float | None = None,
) -> Scenario:
    """Return a scenario by its name (grids: paper, §VI; resco: RESCO; others ours).

    Parameters
    ----------
    name
        ``grid:ROWSxCOLUMNS``, ``grid:ROWSxCOLUMNS/DEMAND`` (see `GRID_DEMANDS`),
        ``cityflow:FOLDER``, ``cityflow:FOLDER#FLOW_FILE``, ``sumo:FILE.sumocfg`` or
        one of the RESCO benchmark such as ``resco/cologne1``.
    horizon_s
        Length of a run in seconds; 300 for grids, for recorded demand its own.
    load
        Factor on the demand.
    timing, dynamics, demand
        Instead of the scenario's own.
    begin_s, phases, routing
        Of scenarios from SUMO's files only, see `sumo_scenario`.
    ties
        What decides between equally short ways of random arrivals: ``"straight"`` (straight on
        first) or ``"coin"``, see `dmil.demand.PoissonDemand`; as in the demand if not given.
    link_time_s, entry_link_time_s
        Of grids only, see `dmil.network.grid`.

    Raises
    ------
    InputError
        If there is no such scenario, or its files or the options are not valid.
    MissingExtraError
        If it needs a package that is not installed.
    """
    name = plain(name)
    kind, rest = kind_of(name)
    times = {"link_time_s": link_time_s, "entry_link_time_s": entry_link_time_s}
    of_grids = {key: value for key, value in times.items() if value is not None}
    if of_grids and kind != "grid":
        raise InputError(
            f"the links of '{name}' have times of their own",
            where=f"grid: {', '.join(of_grids)}",
            expected="a grid where these are given",
            mend="leave them out",
        )
    if name.startswith(PREFIX) or (kind == "sumo" and rest):
        made = sumo_scenario(
            find_resco_configuration(name) if name.startswith(PREFIX) else rest,
            begin_s=begin_s,
            horizon_s=horizon_s,
            phases=phases or "program",
            routing=routing,
            timing=timing or _timing_of(name),
            dynamics=dynamics,
            name=name,
        )
    elif any(option is not None for option in (begin_s, phases, routing)):
        raise InputError(
            f"the scenario '{name}' has no begin, phases or routing to choose",
            where="scenario",
            expected="a scenario from SUMO's files where one of these is given",
            mend="leave them out",
        )
    elif kind == "grid":
        size, _, kind_of_demand = name.partition("/")
        rows, columns = _grid_size(size)
        if kind_of_demand not in GRID_DEMANDS or name.endswith("/"):
            known = [each for each in GRID_DEMANDS if each]
            raise unknown_name("demand of a grid", kind_of_demand, known, where=name)
        made = Scenario(
            name,
            grid(rows, columns, **of_grids),
            GRID_DEMANDS[kind_of_demand],
            timing or SignalTiming(),
            dynamics or QueueDynamics(),
            GRID_HORIZON_S if horizon_s is None else horizon_s,
        )
    elif kind == "cityflow" and rest:
        roadnet, flow = find_cityflow_files(rest)
        made = cityflow_scenario(
            roadnet, flow, horizon_s=horizon_s, timing=timing, dynamics=dynamics, name=name
        )
    else:
        raise unknown_name("scenario", name, _NAMES)
    if demand is not None:
        made = replace(made, demand=demand)
    if ties is not None:
        made = replace(made, demand=with_ties(made.demand, ties, made.network))
    return with_load(made, load)


def _timing_of(name: str) -> SignalTiming | None:
    """Return the benchmark's times for its scenarios; None leaves others to their plans."""
    return RESCO_TIMING_OF.get(name, RESCO_TIMING) if name.startswith(PREFIX) else None


def _grid_size(name: str) -> tuple[int, int]:
    match = re.fullmatch(r"grid:([0-9]{1,4})x([0-9]{1,4})", name)
    if match is None:
        raise InputError(
            f"'{name}' is not the name of a grid",
            where="scenario",
            expected="grid:ROWSxCOLUMNS",
            mend="write for example grid:5x5",
        )
    return int(match[1]), int(match[2])


def with_load(made: Scenario, load: float) -> Scenario:
    """Return a scenario with ``load`` times its demand (ours).

    Raises
    ------
    InputError
        If the load is no number of 0 or more, or the demand cannot be scaled.
    """
    check_load(load)
    if load == 1.0:
        return made
    if not isinstance(made.demand, ScalableDemand):
        raise InputError(
            f"a {type(made.demand).__name__} cannot be scaled",
            where="load",
            mend="give it a method scaled(load), or leave the load at 1",
        )
    return replace(made, demand=made.demand.scaled(load))
