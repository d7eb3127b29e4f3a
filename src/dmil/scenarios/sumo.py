"""Scenarios from SUMO's files."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from urllib.parse import unquote

from dmil.demand.sumo import read_sumo_routes
from dmil.demand.sumo.entry import seconds_of
from dmil.demand.sumo.routing import routed_by_sumo, sumo_is_installed, with_remark
from dmil.errors import InputError
from dmil.network.sumo import read_sumo_network
from dmil.network.sumo.reader import Phases, driven_by
from dmil.network.xml_file import XmlPlace, XmlWalk
from dmil.scenarios.model import QueueDynamics, Scenario, SignalTiming
from dmil.scenarios.sumo_files import Routing, SumoFiles

DECISION_INTERVAL_S = 10
CLEARANCE_S = 3
"""Both as in the RESCO benchmark."""
SATURATION_FLOW_VEH_PER_S = 0.5
HORIZON_ROUNDED_TO_S = 600

_OPTIONS = {
    "net-file": ("n", "net"),
    "route-files": ("r", "route", "routes"),
    "additional-files": ("a", "additional"),
    "begin": ("b",),
    "end": ("e",),
    "step-length": (),
    "scale": (),
}
"""Options that are read, and their other names."""
_NAMES = {short: name for name, shorts in _OPTIONS.items() for short in (name, *shorts)}
_WITHOUT_EFFECT = {"output", "report", "gui_only", "traci_server", "random_number"}
"""Sections whose options do not change how vehicles drive, or only by chance."""


@dataclass(frozen=True)
class SumoConfiguration:
    """Which files belong together, and when a run begins and ends (ours).

    Parameters
    ----------
    net_file
        The network.
    route_files
        Vehicles, trips and flows.
    additional_files
        Files with further vehicle types and routes; whatever else they hold is not used.
    begin_s, end_s
        SUMO's times; without an end the last departure decides.
    scale
        Factor on the demand.
    unused
        Options of the file that could change how vehicles drive and are not taken over, as
        ``name=value``; the length of a step too, since a run has steps of 1 s.
    """

    net_file: Path
    route_files: tuple[Path, ...]
    additional_files: tuple[Path, ...] = ()
    begin_s: int = 0
    end_s: float | None = None
    scale: float = 1.0
    unused: tuple[str, ...] = ()


def read_sumo_configuration(path: str | Path) -> SumoConfiguration:
    """Read a SUMO configuration (``.sumocfg``); its paths are relative to it (ours).

    Parameters
    ----------
    path
        The file.

    Raises
    ------
    InputError
        If it is missing, cut off, not XML or of another kind, names no network or no routes, or a
        time is not valid.
    """
    options = _Options(str(path))
    walk = XmlWalk(path, options.start, options.end, root=("configuration", "sumoConfiguration"))
    options.walk = walk
    walk.run()
    folder = Path(path).parent
    nets = options.paths("net-file", folder)
    routes = options.paths("route-files", folder)
    for name, found in (("net-file", nets), ("route-files", routes)):
        if not found:
            raise InputError(
                f"it names no {name}",
                where=str(path),
                expected=f'<{name} value="…"/>',
                mend="add it, or give the files themselves (--net and --routes)",
            )
    begin_s = options.seconds("begin") or 0.0
    if begin_s != int(begin_s):
        raise options.error("begin", "whole seconds, since a run has steps of 1 s")
    end_s = options.seconds("end")
    step_s = options.number("step-length", 1.0)
    return SumoConfiguration(
        net_file=nets[0],
        route_files=routes,
        additional_files=options.paths("additional-files", folder),
        begin_s=int(begin_s),
        end_s=end_s,
        scale=options.number("scale", 1.0),
        unused=(*([f"step-length={step_s:g}"] if step_s != 1 else []), *options.unused),
    )


@dataclass(slots=True)
class _Options:
    """The options of a configuration as they are met."""

    path: str
    walk: XmlWalk | None = None
    unused: list[str] = field(default_factory=list)
    _sections: list[str] = field(default_factory=list)
    _given: dict[str, tuple[str, XmlPlace | str]] = field(default_factory=dict)

    def start(self, name: str, attributes: Mapping[str, str]) -> None:
        value = attributes.get("value", attributes.get("v"))
        known = _NAMES.get(name)
        place = self.walk.place if self.walk else self.path
        if known and value is None:
            raise InputError(
                f"<{name}> has no value", where=str(place), expected=f'<{name} value="…"/>'
            )
        if value is not None:
            if known:
                self._given[known] = value, place
            elif not _WITHOUT_EFFECT.intersection(self._sections):
                self.unused.append(f"{name}={value}")
        self._sections.append(name)

    def end(self, name: str) -> None:
        self._sections.pop()

    def error(self, name: str, expected: str) -> InputError:
        value, place = self._given[name]
        return InputError(f"{name} is '{value}'", where=str(place), expected=expected)

    def paths(self, name: str, folder: Path) -> tuple[Path, ...]:
        names = self._given.get(name, ("", ""))[0].split(",")
        return tuple(folder / unquote(each.strip()) for each in names if each.strip())

    def seconds(self, name: str) -> float | None:
        """Return a time, None if it is missing or negative, which SUMO takes for missing."""
        if name not in self._given:
            return None
        value = seconds_of(self._given[name][0])
        if value is None:
            raise self.error(name, "seconds, or hours:minutes:seconds")
        return value if value >= 0 else None

    def number(self, name: str, default: float) -> float:
        if name not in self._given:
            return default
        try:
            value = float(self._given[name][0])
        except ValueError:
            value = math.nan
        if not (math.isfinite(value) and value > 0):
            raise self.error(name, "a number above 0")
        return value


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
    """Build a scenario from SUMO's network and route files (ours; timing: RESCO).

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
        `dmil.demand.sumo.routing.routed_by_sumo`. ``"free-flow"``: the fastest without traffic. If
        not given, ``"sumo"`` where it is installed.
    timing
        Signal timing; if not given, decisions every 10 s and 3 s of clearance.
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
    given = files if isinstance(files, SumoConfiguration) else read_sumo_configuration(files)
    begin_s = given.begin_s if begin_s is None else begin_s
    end_s = given.end_s if horizon_s is None else begin_s + horizon_s
    if end_s is not None and end_s <= begin_s:
        raise InputError(
            f"a run would begin at {begin_s} s and end at {end_s:g} s",
            where="begin_s",
            expected="an end after the beginning",
            mend="correct the begin, or say how long a run lasts (--steps)",
        )
    roads = read_sumo_network(given.net_file, phases=phases)
    demand = read_sumo_routes(
        given.route_files,
        roads.network,
        additional=given.additional_files,
        begin_s=begin_s,
        end_s=end_s,
    )
    if end_s is None:
        horizon_s = _rounded(demand.last_departure_s + 1)
    else:
        horizon_s = math.ceil(end_s - begin_s)
    chosen: Routing | None = None
    if demand.trips:
        chosen = routing or ("sumo" if sumo_is_installed() else "free-flow")
        if chosen == "sumo":
            demand = routed_by_sumo(demand, roads.network, given.net_file, horizon_s)
        else:
            demand = with_remark(demand, len(demand.trips))
    roads = driven_by(roads, demand.class_counts)
    demand = demand.on_network(roads.network)
    return Scenario(
        name=name or f"sumo:{roads.network.name}",
        network=roads.network,
        demand=demand.scaled(given.scale) if given.scale != 1 else demand,
        timing=timing
        or SignalTiming(decision_interval_s=DECISION_INTERVAL_S, clearance_s=CLEARANCE_S),
        dynamics=dynamics
        or QueueDynamics(
            saturation_flow_veh_per_s=SATURATION_FLOW_VEH_PER_S,
            storage=True,
            vehicle_space_m=demand.vehicle_space_m,
        ),
        horizon_s=horizon_s,
        sumo=SumoFiles(
            net_file=roads.path,
            signals=roads.signals,
            kinds=demand.kinds,
            classes=demand.classes,
            vehicle_types_xml=demand.vehicle_types_xml,
            begin_s=begin_s,
            routing=chosen,
        ),
    )


def _rounded(departures_s: int) -> int:
    return HORIZON_ROUNDED_TO_S * max(1, math.ceil(departures_s / HORIZON_ROUNDED_TO_S))
