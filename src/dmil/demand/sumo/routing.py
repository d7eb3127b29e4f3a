"""The ways that SUMO chooses for trips: it runs once, and what it chose is kept on disk.

SUMO looks for the fastest way of a trip when it departs, by the mean travel times of the last
minutes. So the ways depend on the traffic, and only a run tells them.
"""

from __future__ import annotations

import hashlib
import subprocess
import tempfile
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from xml.sax.saxutils import quoteattr

from dmil.compilation import user_cache_folder
from dmil.demand.recorded import first_gap
from dmil.demand.sumo.demand import SumoDemand
from dmil.demand.sumo.remarks import TEXTS, DemandRemark
from dmil.demand.sumo.ways import Ends
from dmil.errors import DemandError, MissingExtraError, OutputError
from dmil.files import write_text_atomically
from dmil.network import RoadNetwork
from dmil.network.sumo.writer import sumo_program
from dmil.network.xml_file import attributes_xml, iter_elements
from dmil.seeding import stream

SEED = 23423
"""SUMO's own default."""
LONGER_S = 1800
"""How long the run goes on after the last departure, so that those who wait to enter get a way."""
LAST_LINES = 3
"""How many lines of SUMO's complaint an error shows."""
PATIENCE_S = 900
"""Who waits longer outside of the mesoscopic model is not let in, and keeps the way he has: where a
day's vehicles are more than the roads take, SUMO would try thousands of them in every second."""
_MESOSCOPIC = ("--mesosim", "--meso-junction-control", "--max-depart-delay", str(PATIENCE_S))
_ASIDE = ("Warning:", "pj_obj", "Quitting (on error)")
_FOLDER, _TITLE = "routes", "ways of trips, digest "

Found = Mapping[str, tuple[str, ...]]
"""Id of a trip to the edges of its way: its number, and ``s/n`` for vehicle n of stream s."""


def sumo_is_installed() -> bool:
    """Tell whether there is a SUMO to ask (ours)."""
    try:
        _version()
    except MissingExtraError:
        return False
    return True


def routed_by_sumo(
    demand: SumoDemand,
    network: RoadNetwork,
    net_file: Path,
    horizon_s: int,
    *,
    programs_xml: str = "",
    mesoscopic: bool = False,
) -> SumoDemand:
    """Return the demand with the ways that SUMO chooses for its trips (SUMO docs: Demand/Routing).

    SUMO runs the vehicles once on the network's own signal programs, with seed 23423 and without
    teleporting. Its answer is kept in the user's cache folder for the same network, vehicles,
    horizon and version of SUMO. Vehicles of a flow with random departures choose among the ways
    that SUMO found for one draw of them, as often as it chose each. A trip that SUMO does not let
    in keeps its way, and so does a flow of which it lets in nobody: the demand's remarks tell.

    Parameters
    ----------
    demand
        From `dmil.demand.sumo.read_sumo_routes`.
    network
        The roads that it was read for.
    net_file
        The same as SUMO's file.
    horizon_s
        Departures before this second of a run count.
    programs_xml
        Signal programs beside the network's, as XML elements without a root element.
    mesoscopic
        Whether SUMO moves queues instead of single vehicles (SUMO docs: Simulation/Meso), which
        takes a tenth of the time; ways that are kept from another run are as good.

    Raises
    ------
    MissingExtraError
        If SUMO is not installed.
    DemandError
        If SUMO refuses to run, with its own message.
    """
    if not demand.unrouted:
        return demand
    vehicles_xml = "".join(_vehicles_xml(demand, network, horizon_s))
    begin_s = round(demand.begin_s)
    end_s = begin_s + min(horizon_s, demand.last_departure_s + 1) + LONGER_S
    options = [
        *("--begin", str(begin_s)),
        *("--end", str(end_s)),
        *("--seed", str(SEED)),
        *("--time-to-teleport", "-1"),
    ]
    net = net_file.read_bytes()

    def kept_for(options: list[str]) -> Path:
        digest = hashlib.blake2b(net, digest_size=16)
        made_from: tuple[str, ...] = (_version(), " ".join(options), vehicles_xml)
        made_from += (programs_xml,) if programs_xml else ()
        digest.update("\n".join(made_from).encode())
        return user_cache_folder() / _FOLDER / f"{digest.hexdigest()}.txt"

    kept = kept_for(options)
    found = _kept(kept)
    if found is None and mesoscopic:
        options += _MESOSCOPIC
        kept = kept_for(options)
        found = _kept(kept)
    if found is None:
        found = _asked(net_file, vehicles_xml, programs_xml, options)
        # Where no cache can be written every start asks, and nothing else is wrong.
        with suppress(OutputError):
            write_text_atomically(kept, _as_text(found))
    return _on_found(demand, network, found)


def with_remark(demand: SumoDemand, left: Sequence[Ends]) -> SumoDemand:
    """Return the demand with a remark about ways that are not those of the traffic (ours).

    ``left`` has from where to where those go, an element for each trip and each flow.
    """
    if not left:
        return demand
    name = " ".join(value for _, value in left[0])
    remark = DemandRemark("free-flow", len(left), name, TEXTS["free-flow"])
    return replace(demand, remarks=(*demand.remarks, remark))


def _on_found(demand: SumoDemand, network: RoadNetwork, found: Found) -> SumoDemand:
    """Take over the ways that exist in the network."""
    known = network.link_index
    ways: dict[int, tuple[int, ...]] = {}
    driven: defaultdict[int, Counter[tuple[int, ...]]] = defaultdict(Counter)
    gaps: dict[tuple[int, ...], int | None] = {}
    for name, edges in found.items():
        if not all(edge in known for edge in edges):
            continue
        way = tuple(known[edge] for edge in edges)
        if way not in gaps:
            gaps[way] = first_gap(network, way)
        if gaps[way] is not None:
            continue
        flow, _, vehicle = name.rpartition("/")
        if flow:
            driven[int(flow)][way] += 1
        elif int(vehicle) in demand.trips:
            ways[int(vehicle)] = way
    choices = {
        flow: tuple((way, times / counts.total()) for way, times in sorted(counts.items()))
        for flow, counts in driven.items()
    }
    left = [ends for trip, ends in demand.trips.items() if trip not in ways]
    left += [
        each.ends for flow, each in enumerate(demand.streams) if each.ends and flow not in choices
    ]
    return with_remark(demand.on_ways(ways, choices), left)


def _version() -> str:
    sumo_program("sumo")
    try:
        return version("eclipse-sumo")
    except PackageNotFoundError:  # another module of this name
        raise MissingExtraError("sumo") from None


def _vehicles_xml(demand: SumoDemand, network: RoadNetwork, horizon_s: int) -> Iterator[str]:
    """Write all vehicles for SUMO, in order of departure: trips as such, others with their route.

    Ids of trips: see `Found`. What is random is drawn once.
    """
    names = [quoteattr(link.id)[1:-1] for link in network.links]
    kinds = [attributes_xml(kind) for kind in demand.kinds]
    rng = stream(SEED, "routing")
    drawn = [each.draw(demand.begin_s, horizon_s, rng) for each in demand.streams]
    parts = [demand.recorded.recorded, *drawn]
    departures: list[Iterable[float]]
    departures = [demand.exact_depart_s, *(each.depart_s for each in drawn)]
    order = sorted(
        (float(depart_s), part, vehicle)
        for part, each in enumerate(departures)
        for vehicle, depart_s in enumerate(each)
        if depart_s < horizon_s
    )
    yield f"<routes>\n{demand.vehicle_types_xml}"
    for depart_s, part, vehicle in order:
        vehicles = parts[part]
        kind = "" if vehicles.kind is None else kinds[vehicles.kind[vehicle]]
        start = f'depart="{depart_s + demand.begin_s:.3f}"{kind}'
        of_flow = demand.streams[part - 1].ends if part else None
        ends = of_flow or (demand.trips.get(vehicle) if part == 0 else None)
        if ends is not None:
            name = f"{part - 1}/{vehicle}" if part else f"{vehicle}"
            yield f'<trip id="{name}" {start}{attributes_xml(dict(ends))}/>\n'
        else:
            edges = " ".join(names[link] for link in vehicles.route(vehicle))
            yield f'<vehicle id="{part}.{vehicle}" {start}><route edges="{edges}"/></vehicle>\n'
    yield "</routes>\n"


def _asked(net_file: Path, vehicles_xml: str, programs_xml: str, options: list[str]) -> Found:
    """Run SUMO and return the ways of the trips; a DemandError if it fails."""
    program, environment = sumo_program("sumo")
    with tempfile.TemporaryDirectory(prefix="dmil-routes-") as folder:
        routes, output = Path(folder, "vehicles.rou.xml"), Path(folder, "ways.xml")
        routes.write_text(vehicles_xml, encoding="utf-8")
        command = [str(program), "--net-file", str(net_file), "--route-files", str(routes)]
        if programs_xml:
            programs = Path(folder, "programs.add.xml")
            programs.write_text(f"<additional>\n{programs_xml}</additional>\n", encoding="utf-8")
            command += ["--additional-files", str(programs)]
        command += ["--vehroute-output", str(output), "--vehroute-output.last-route"]
        command += ["--vehroute-output.write-unfinished", "--no-step-log", "--no-warnings"]
        command += ["--xml-validation", "never", "--xml-validation.net", "never"]
        command += ["--xml-validation.routes", "never"]
        try:
            done = subprocess.run(
                [*command, *options], capture_output=True, env=environment, check=False
            )
        except OSError as error:
            raise _failed(net_file, f"{error}") from error
        if done.returncode:
            said = (done.stderr or done.stdout).decode(errors="replace").splitlines()
            lines = [line.strip() for line in said if not line.startswith(_ASIDE)]
            problem = " / ".join(line for line in lines[-LAST_LINES:] if line)
            raise _failed(net_file, problem or f"it ended with code {done.returncode}")
        return {
            element.attrib["id"]: tuple(route.attrib["edges"].split())
            for _, element in iter_elements(output, ("vehicle",), error=DemandError)
            for route in element.iter("route")
            if element.attrib["id"].replace("/", "").isdecimal()
        }


def _failed(net_file: Path, problem: str) -> DemandError:
    return DemandError(
        f"SUMO failed to route the trips: {problem.removesuffix('.')}",
        where=str(net_file),
        mend="correct the files, or use the fastest routes at free flow (--routing free-flow)",
    )


def _as_text(found: Found) -> str:
    lines = "".join(f"{vehicle} {' '.join(edges)}\n" for vehicle, edges in sorted(found.items()))
    return f"{_TITLE}{_digest(lines)}\n{lines}"


def _kept(path: Path) -> Found | None:
    """Return what was kept, None if there is nothing or it is damaged."""
    try:
        title, _, lines = path.read_text(encoding="utf-8").partition("\n")
    except (OSError, UnicodeDecodeError):
        return None
    if title != f"{_TITLE}{_digest(lines)}":
        return None
    rows = (line.split(" ") for line in lines.split("\n")[:-1])
    return {vehicle: tuple(edges) for vehicle, *edges in rows}


def _digest(text: str) -> str:
    return hashlib.blake2b(text.encode(), digest_size=16).hexdigest()
