"""What SUMO reads for a run: the network, who drives, and its options."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal
from xml.sax.saxutils import escape, quoteattr

from dmil.demand import Vehicles
from dmil.network.sumo import SumoSignals, write_sumo_network
from dmil.scenarios import Scenario

Model = Literal["micro", "meso"]
PROGRAMS, PERSONS = "programs.add.xml", "persons.rou.xml"

OWN_KIND = {"departLane": "best", "departSpeed": "max"}
"""Attributes of vehicles that no SUMO file describes: they drive in at the speed of the traffic, on
the lane that their route needs, as vehicles do that come from a road outside."""


@dataclass(frozen=True, slots=True)
class RunFiles:
    """A scenario in SUMO's terms.

    Parameters
    ----------
    net_file
        The network.
    edges
        Id of SUMO's edge for every link.
    signals
        Ids and states of the signals, one per intersection.
    begin_s
        SUMO's time at 0 s of a run.
    kinds
        Attributes of ``<vehicle>`` for every `Vehicles.kind`.
    vehicle_types_xml
        Definitions of the vehicle types that the attributes name.
    programs_file
        Signal programs beside the network's, None where there are none.
    persons_file
        Persons who walk, None where there are none.
    further_options
        More options of ``sumo``, as (name, value).
    """

    net_file: Path
    edges: tuple[str, ...]
    signals: tuple[SumoSignals, ...]
    begin_s: int = 0
    kinds: tuple[Mapping[str, str], ...] = ()
    vehicle_types_xml: str = ""
    programs_file: Path | None = None
    persons_file: Path | None = None
    further_options: tuple[tuple[str, str], ...] = ()


def run_files(scenario: Scenario, folder: Path) -> RunFiles:
    """Return the scenario's own files of SUMO, or write its network as such (ours).

    Parameters
    ----------
    scenario
        The scenario.
    folder
        Where to write.

    Raises
    ------
    NetworkError
        If the network cannot be written for SUMO.
    """
    links, sumo = scenario.network.links, scenario.sumo
    if sumo is None:
        written = write_sumo_network(scenario.network, folder)
        return RunFiles(written.net_file, written.edges, written.signals)
    programs_file = persons_file = None
    if sumo.programs_xml:
        programs_file = folder / PROGRAMS
        programs_file.write_text(f"<additional>\n{sumo.programs_xml}</additional>\n", "utf-8")
    if sumo.persons_xml:
        persons_file = folder / PERSONS
        persons_file.write_text(f"<routes>\n{sumo.persons_xml}</routes>\n", "utf-8")
    return RunFiles(
        net_file=sumo.net_file,
        edges=tuple(link.id for link in links),
        signals=sumo.signals,
        begin_s=sumo.begin_s,
        kinds=sumo.kinds,
        vehicle_types_xml=sumo.vehicle_types_xml,
        programs_file=programs_file,
        persons_file=persons_file,
        further_options=sumo.options,
    )


def options(
    files: RunFiles, routes: Path, *, model: Model, seed: int, emissions: bool
) -> list[str]:
    """Return the options of ``sumo`` for a run (RESCO's where it sets any).

    Nobody is teleported. Trips that have not ended are written too when the run does.
    """
    # The types of persons are defined in the file of vehicles: it comes first.
    demand = [routes, files.persons_file] if files.persons_file else [routes]
    chosen = [
        *("--net-file", str(files.net_file)),
        *("--route-files", ",".join(map(str, demand))),
        *("--begin", str(files.begin_s)),
        *("--seed", str(seed % 2**31)),
        *("--time-to-teleport", "-1"),
        *("--xml-validation", "never"),
        *("--xml-validation.net", "never"),
        *("--xml-validation.routes", "never"),
        "--tripinfo-output.write-unfinished",
        "--no-step-log",
        "--duration-log.disable",
    ]
    if files.programs_file:
        chosen += ["--additional-files", str(files.programs_file)]
    for name, value in {"step-length": "1", **dict(files.further_options)}.items():
        chosen += [f"--{name}", value]
    if model == "meso":
        chosen += ["--mesosim", "--meso-junction-control", "true"]
    if emissions:
        chosen += ["--device.emissions.probability", "1"]
    return chosen


def write_routes(file: Path, vehicles: Vehicles, files: RunFiles) -> None:
    """Write vehicles for SUMO; their ids are their numbers (ours)."""
    attributes = [_attributes(kind) for kind in files.kinds]
    own = _attributes(OWN_KIND)
    depart_s = (vehicles.depart_s + files.begin_s).tolist()
    offset = vehicles.route_offset.tolist()
    names = [escape(edge, {'"': "&quot;"}) for edge in files.edges]
    route = [names[link] for link in vehicles.route_links.tolist()]
    kind = None if vehicles.kind is None else vehicles.kind.tolist()
    with file.open("w", encoding="utf-8") as text:
        text.write(f"<routes>\n{files.vehicle_types_xml}\n")
        for v in range(len(vehicles)):
            shown = own if kind is None else attributes[kind[v]]
            links = " ".join(route[offset[v] : offset[v + 1]])
            text.write(
                f'<vehicle id="{v}" depart="{depart_s[v]}"{shown}>'
                f'<route edges="{links}"/></vehicle>\n'
            )
        text.write("</routes>\n")


def _attributes(kind: Mapping[str, str]) -> str:
    return "".join(f" {name}={quoteattr(value)}" for name, value in kind.items())
