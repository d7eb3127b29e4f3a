"""What the doctor looks at: a network, and where there is one its demand, from files or a name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

from dmil.demand import Demand
from dmil.demand.sumo.acting import kind_of_option
from dmil.demand.sumo.flows import EndlessError
from dmil.demand.sumo.reader import has_vehicles
from dmil.demand.sumo.routing import sumo_is_installed
from dmil.doctor.arguments import SumoFilesGiven, sort_arguments
from dmil.doctor.findings import Finding
from dmil.doctor.kinds import finding
from dmil.errors import DemandError, InputError
from dmil.network import (
    Remark,
    RoadNetwork,
    SumoNetwork,
    SumoSignals,
    read_cityflow_roadnet,
    read_sumo_network,
)
from dmil.network.sumo.net_file import read_net_file
from dmil.network.sumo.reader import Phases
from dmil.network.sumo.records import NetFile
from dmil.scenarios import (
    PLAN,
    QueueDynamics,
    Scenario,
    SignalTiming,
    SumoConfiguration,
    cityflow_scenario,
    read_sumo_configuration,
    scenario,
    sumo_scenario,
)
from dmil.scenarios.cityflow import DECISION_INTERVAL_S as CITYFLOW_INTERVAL_S
from dmil.scenarios.model import FROM_FILES, Routing
from dmil.scenarios.sumo import DECISION_INTERVAL_S

NO_DEMAND_HORIZON_S = 3600

Window = tuple[int | None, int | None]
"""Begin and length of a run, where they are given."""


@dataclass(frozen=True, slots=True)
class SumoFacts:
    """What SUMO's network file says beyond the network (ours).

    Parameters
    ----------
    remarks
        The reader's.
    signals
        How SUMO shows the phases, one per intersection.
    program_kinds
        SUMO's type of program by controller, such as ``static`` or ``actuated``.
    junctions
        Controller to the number of junctions that it governs.
    all_red_s
        Controller to its longest stage in which everything is red; without one it is missing.
    """

    remarks: tuple[Remark, ...]
    signals: tuple[SumoSignals, ...]
    program_kinds: Mapping[str, str]
    junctions: Mapping[str, int]
    all_red_s: Mapping[str, float]


@dataclass(frozen=True, slots=True)
class Case:
    """What is to be examined (ours).

    Parameters
    ----------
    name
        Readable name.
    files
        The files that were read.
    network
        The roads.
    demand
        Who drives; None if only a network was given.
    timing, dynamics
        Those that a scenario of it has.
    begin_s
        Time of day, in SUMO's seconds, that is second 0 of a run.
    horizon_s
        Length of a run.
    sumo
        What only SUMO's files say.
    found
        What was found while reading.
    """

    name: str
    files: tuple[Path, ...]
    network: RoadNetwork
    demand: Demand | None
    timing: SignalTiming
    dynamics: QueueDynamics
    begin_s: int
    horizon_s: int
    sumo: SumoFacts | None = None
    found: tuple[Finding, ...] = ()


def read_case(
    arguments: Sequence[str],
    *,
    begin_s: int | None = None,
    horizon_s: int | None = None,
    phases: Phases | None = None,
    routing: Routing | None = None,
) -> Case:
    """Read what is to be examined (ours).

    Parameters
    ----------
    arguments
        The name of a scenario; or a ``.sumocfg``; or a ``.net.xml`` with any number of route files
        and additional ones; or a folder of CityFlow's files; or a road network of CityFlow with or
        without its flow.
    begin_s, horizon_s
        Instead of those of the files, see `dmil.scenarios.sumo_scenario`.
    phases
        Which phases to take from a SUMO network: ``"program"`` or ``"derived"``.
    routing
        Which ways SUMO's trips drive, see `dmil.scenarios.sumo_scenario`; if not given, those of
        SUMO's mesoscopic model, where it is installed.

    Raises
    ------
    InputError
        If a file cannot be read, is not what it should be, or they do not belong together.
    MissingExtraError
        If SUMO's files are read and sumolib is not installed.
    """
    given = sort_arguments(arguments)
    if isinstance(given, SumoFilesGiven):
        window = begin_s, horizon_s
        return _sumo_case(given, window, phases or "program", routing)
    if given.network and not given.flow:
        return _roadnet_case(given.network)
    if given.network and given.flow:
        if begin_s is not None or phases is not None or routing is not None:
            raise InputError(
                "CityFlow files have no begin, phases or routing to choose",
                where=str(given.network),
                mend="leave --begin, --phases and --routing out",
            )
        made = cityflow_scenario(given.network, given.flow, horizon_s=horizon_s)
    else:
        made = scenario(
            given.name, horizon_s=horizon_s, begin_s=begin_s, phases=phases, routing=routing
        )
    return Case(
        name=made.name,
        files=tuple(path for path in (given.network, given.flow) if path),
        network=made.network,
        demand=made.demand,
        timing=made.timing,
        dynamics=made.dynamics,
        begin_s=0,
        horizon_s=made.horizon_s,
    )


def _roadnet_case(path: Path) -> Case:
    network = read_cityflow_roadnet(path)
    return Case(
        name=network.name,
        files=(path,),
        network=network,
        demand=None,
        timing=SignalTiming(decision_interval_s=CITYFLOW_INTERVAL_S, **PLAN),
        dynamics=QueueDynamics(**FROM_FILES),
        begin_s=0,
        horizon_s=NO_DEMAND_HORIZON_S,
    )


def _sumo_case(
    given: SumoFilesGiven, window: Window, phases: Phases, routing: Routing | None
) -> Case:
    begin_s, horizon_s = window
    configuration = _configuration(given)
    start_s = configuration.begin_s if begin_s is None else begin_s
    additional = configuration.additional_files
    roads = read_sumo_network(
        configuration.net_file, phases=phases, additional=additional, begin_s=start_s
    )
    file = read_net_file(configuration.net_file, additional=additional, begin_s=start_s)
    case = Case(
        name=given.name or roads.network.name,
        files=(*given.files, *_unnamed(given, configuration)),
        network=roads.network,
        demand=None,
        timing=SignalTiming(decision_interval_s=DECISION_INTERVAL_S, **PLAN),
        dynamics=QueueDynamics(**FROM_FILES),
        begin_s=start_s,
        horizon_s=horizon_s or NO_DEMAND_HORIZON_S,
        sumo=_facts(roads, file),
        found=tuple(_on_options(configuration)),
    )
    if not configuration.route_files and not any(map(has_vehicles, additional)):
        return case
    try:
        made, found = _with_vehicles(configuration, window, phases, routing)
    except EndlessError as cause:
        hour = begin_s, NO_DEMAND_HORIZON_S
        made, found = _with_vehicles(configuration, hour, phases, routing)
        found = [*found, finding("endless", "demand", f"{cause.where}: {cause.problem}")]
    return replace(
        case,
        network=made.network,
        demand=made.demand,
        timing=made.timing,
        dynamics=made.dynamics,
        begin_s=made.sumo.begin_s if made.sumo else 0,
        horizon_s=made.horizon_s,
        sumo=replace(case.sumo, signals=made.sumo.signals) if case.sumo and made.sumo else None,
        found=(*case.found, *found),
    )


def _facts(roads: SumoNetwork, file: NetFile) -> SumoFacts:
    junctions: dict[str, set[str]] = {}
    for way in file.connections:
        junctions.setdefault(way.signal, set()).add(way.junction)
    all_red_s: dict[str, float] = {}
    for logic in file.logics:
        for stage in logic.stages:
            if set(stage.state) == {"r"}:
                all_red_s[logic.id] = max(stage.duration_s, all_red_s.get(logic.id, 0.0))
    return SumoFacts(
        remarks=roads.remarks,
        signals=roads.signals,
        program_kinds={logic.id: logic.kind for logic in file.logics},
        junctions={signal: len(places) for signal, places in junctions.items()},
        all_red_s=all_red_s,
    )


def _configuration(given: SumoFilesGiven) -> SumoConfiguration:
    if given.configuration is not None:
        return read_sumo_configuration(given.configuration)
    assert given.network is not None, "a network or a configuration was given"
    return SumoConfiguration(given.network, given.routes, given.additional)


def _unnamed(given: SumoFilesGiven, configuration: SumoConfiguration) -> tuple[Path, ...]:
    named = (configuration.net_file, *configuration.route_files, *configuration.additional_files)
    return tuple(path for path in named if path not in given.files)


def _on_options(configuration: SumoConfiguration) -> list[Finding]:
    # Of devices the demand's remarks tell.
    others = [
        each for each in configuration.unused if not kind_of_option(*each.partition("=")[::2])
    ]
    return [finding("option-not-used", "configuration", ", ".join(others))] if others else []


def _with_vehicles(
    configuration: SumoConfiguration, window: Window, phases: Phases, routing: Routing | None
) -> tuple[Scenario, list[Finding]]:
    """Build the scenario; where SUMO refuses to route or nobody departs in time, another one."""
    begin_s, horizon_s = window

    def made(ways: Routing | None) -> Scenario:
        return sumo_scenario(
            configuration, begin_s=begin_s, horizon_s=horizon_s, phases=phases, routing=ways
        )

    try:
        # Loads need ways through the traffic, but not every vehicle's very own.
        return made(routing or ("mesoscopic" if sumo_is_installed() else "free-flow")), []
    except DemandError as cause:
        with suppress(DemandError):
            without = made("free-flow")
            return without, [finding("sumo-refuses", "SUMO", cause.problem)]
        # Endless flows need the end, others may depart after it.
        for end_s in (None, configuration.end_s):
            everyone = replace(configuration, begin_s=0, end_s=end_s)
            with suppress(InputError):
                whole = sumo_scenario(everyone, phases=phases, routing="free-flow")
                mend = f"{cause.mend[0].upper()}{cause.mend[1:]}." if cause.mend else ""
                what = f"{cause.problem}; {cause.expected}"
                return whole, [finding("no-vehicle-in-time", "demand", what, mend=mend)]
        raise
