"""What SUMO reads for a run: the network, who drives, and its options."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal
from xml.sax.saxutils import escape

from dmil.demand import Vehicles
from dmil.demand.sumo.beside import NOTHING, Beside
from dmil.network.sumo import SumoSignals, write_sumo_network
from dmil.network.xml_file import attributes_xml
from dmil.scenarios import Scenario

Model = Literal["micro", "meso"]
PROGRAMS, DEFINED = "programs.add.xml", "defined.add.xml"
PERSONS, BESIDE = "persons.rou.xml", "beside.rou.xml"

OWN_KIND = {"departLane": "best", "departSpeed": "max"}
"""Attributes of vehicles that no SUMO file describes: they drive in at the speed of the traffic, on
the lane that their route needs, as vehicles do that come from a road outside."""

OWN_OPTIONS = {"step-length": "1", "time-to-teleport": "-1"}
"""Options that a scenario's own go over."""


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
    beside
        What SUMO runs beside the vehicles of a run, and the types that all of them name.
    additional_files
        Signal programs beside the network's, stopping places, rerouters and the like.
    further_routes
        Files of the persons who walk, and of the vehicles that SUMO drives beside those of a run.
    further_options
        More options of ``sumo``, as (name, value).
    """

    net_file: Path
    edges: tuple[str, ...]
    signals: tuple[SumoSignals, ...]
    begin_s: int = 0
    kinds: tuple[Mapping[str, str], ...] = ()
    beside: Beside = NOTHING
    additional_files: tuple[Path, ...] = ()
    further_routes: tuple[Path, ...] = ()
    further_options: tuple[tuple[str, str], ...] = ()


def run_files(scenario: Scenario, folder: Path) -> RunFiles:
    """Return the scenario's own files of SUMO, or write its network as such (ours).

    Raises
    ------
    NetworkError
        If the network cannot be written for SUMO.
    """
    links, sumo, blocker_s = (
        scenario.network.links,
        scenario.sumo,
        scenario.ignore_junction_blocker_s,
    )
    chosen = () if blocker_s is None else (("ignore-junction-blocker", str(blocker_s)),)
    if sumo is None:
        written = write_sumo_network(scenario.network, folder)
        return RunFiles(written.net_file, written.edges, written.signals, further_options=chosen)
    beside = sumo.beside
    additional = {PROGRAMS: sumo.programs_xml, DEFINED: beside.definitions_xml}
    routes = {PERSONS: sumo.persons_xml, BESIDE: beside.vehicles_xml}
    return RunFiles(
        net_file=sumo.net_file,
        edges=tuple(link.id for link in links),
        signals=sumo.signals,
        begin_s=sumo.begin_s,
        kinds=sumo.kinds,
        beside=beside,
        additional_files=_written(folder, additional, "additional"),
        further_routes=_written(folder, routes, "routes"),
        further_options=(*sumo.options, *chosen),
    )


def _written(folder: Path, texts: Mapping[str, str], root: str) -> tuple[Path, ...]:
    """Write those files that have something to say."""
    for name, text in texts.items():
        if text:
            (folder / name).write_text(f"<{root}>\n{text}</{root}>\n", "utf-8")
    return tuple(folder / name for name, text in texts.items() if text)


def options(
    files: RunFiles, routes: Path, *, model: Model, seed: int, emissions: bool
) -> list[str]:
    """Return the options of ``sumo`` for a run (RESCO's where it sets any).

    Nobody is teleported, unless the scenario's own options say after what time. Trips that have not
    ended are written too when the run does.
    """
    # The types of all are defined in the file of vehicles: it comes first. The mesoscopic model has
    # no lanes of bicycles, and who begins on one would end the run.
    further = [file for file in files.further_routes if model == "micro" or file.name != BESIDE]
    chosen = [
        *("--net-file", str(files.net_file)),
        *("--route-files", ",".join(map(str, (routes, *further)))),
        *("--begin", str(files.begin_s)),
        *("--seed", str(seed % 2**31)),
        *("--xml-validation", "never"),
        *("--xml-validation.net", "never"),
        *("--xml-validation.routes", "never"),
        "--tripinfo-output.write-unfinished",
        "--no-step-log",
        "--duration-log.disable",
    ]
    if files.additional_files:
        chosen += ["--additional-files", ",".join(map(str, files.additional_files))]
    for name, value in {**OWN_OPTIONS, **dict(files.further_options)}.items():
        chosen += [f"--{name}", value]
    if model == "meso":
        chosen += ["--mesosim", "--meso-junction-control", "true"]
    if emissions:
        chosen += ["--device.emissions.probability", "1"]
    return chosen


def together(chosen: Sequence[str], further: Sequence[str]) -> list[str]:
    """Return options of ``sumo`` and more of them; of both, additional files are loaded (ours)."""
    name = "--additional-files"
    joined = list(chosen)
    if name in joined and name in further:
        further = list(further)
        place = further.index(name)
        joined[joined.index(name) + 1] += f",{further[place + 1]}"
        del further[place : place + 2]
    return [*joined, *further]


def write_routes(file: Path, vehicles: Vehicles, files: RunFiles) -> None:
    """Write vehicles for SUMO; their ids are their numbers (ours)."""
    attributes = [attributes_xml(kind) for kind in files.kinds]
    own, inner = attributes_xml(OWN_KIND), files.beside.inner_xml or ("",) * len(files.kinds)
    depart_s = (vehicles.depart_s + files.begin_s).tolist()
    offset = vehicles.route_offset.tolist()
    names = [escape(edge, {'"': "&quot;"}) for edge in files.edges]
    route = [names[link] for link in vehicles.route_links.tolist()]
    # CityFlow's kinds of vehicles are none of SUMO's.
    told = vehicles.kind is not None and bool(files.kinds)
    kind = vehicles.kind.tolist() if told and vehicles.kind is not None else None
    with file.open("w", encoding="utf-8") as text:
        text.write(f"<routes>\n{files.beside.types_xml}\n")
        for v in range(len(vehicles)):
            shown = own if kind is None else attributes[kind[v]]
            links = " ".join(route[offset[v] : offset[v + 1]])
            text.write(
                f'<vehicle id="{v}" depart="{depart_s[v]}"{shown}>'
                f'<route edges="{links}"/>{"" if kind is None else inner[kind[v]]}</vehicle>\n'
            )
        text.write("</routes>\n")
