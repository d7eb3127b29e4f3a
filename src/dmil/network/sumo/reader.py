"""From a network file to links, intersections, junctions and fringe nodes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path
from statistics import fmean
from typing import Literal

from dmil.errors import InputError, NetworkError
from dmil.network.checks import check_network
from dmil.network.lines import Point
from dmil.network.model import Intersection, Junction, Link, RoadNetwork
from dmil.network.naming import phase_name
from dmil.network.permissions import ClassCounts, driven, makes_no_difference
from dmil.network.plan_times import stops_all
from dmil.network.sumo.net_file import read_net_file
from dmil.network.sumo.plan import crossings_of, plan_of, walk_of
from dmil.network.sumo.records import Connection, Logic, NetFile, Remark, SumoNetwork, SumoSignals
from dmil.network.sumo.suspicions import remarks_on
from dmil.network.sumo.ways import crossing, gives_way, letters_of, ways_at

Phases = Literal["program", "derived"]


def read_sumo_network(
    path: str | Path,
    *,
    phases: Phases = "program",
    additional: Sequence[str | Path] = (),
    begin_s: float = 0.0,
) -> SumoNetwork:
    """Read a SUMO network (ours).

    Edges that no motor vehicle may use are left out. All junctions under one controller are one
    intersection, junctions without signals become junctions, and nodes where vehicles only begin
    or end become fringe nodes.

    Parameters
    ----------
    path
        The file, usually named ``*.net.xml``, gzipped or not.
    phases
        ``"program"``: an intersection's phases are the stages of its own program in which vehicles
        have green and none has yellow. ``"derived"``: they are chosen from the sets of movements
        that do not cross, at most 16.
    additional
        Files with further signal programs: as in SUMO the one that is loaded last is the
        intersection's own, or the one that a schedule (WAUT) names for the beginning.
    begin_s
        SUMO's time at which a run begins.

    Raises
    ------
    NetworkError
        If the file is missing, cut off, unsafe, no SUMO network, inconsistent, or has no signals.
    MissingExtraError
        If sumolib is not installed.

    Notes
    -----
    A signal without a program is SUMO's, such as a rail crossing: its nodes become junctions.
    A link has SUMO's number of lanes and their indices; those that no motor vehicle may use, such
    as footways and cycle lanes, are closed. Who may use the others is in the network's
    ``permissions``; once it is known who drives, `driven_by` closes more. Where a program leaves a
    movement without green, phases are added for it, so that a controller can serve it. What is
    suspicious is in ``remarks``.
    """
    if phases not in ("program", "derived"):
        raise InputError(
            f"phases is {phases!r}", expected='"program" or "derived"', where=str(path)
        )
    file = read_net_file(path, additional=additional, begin_s=begin_s)
    return _read(file, None, derive=phases == "derived")


def driven_by(roads: SumoNetwork, vehicles: ClassCounts) -> SumoNetwork:
    """Return a network with only those lanes open that its vehicles drive in (ours).

    A lane counts where at least a third may use it of the vehicles that may go there at all, see
    `dmil.network.permissions.driven`: so a bus lane is no second lane for cars, and green for its
    own signal is no green for them. Links, movements and their order stay as they are.
    """
    file = roads.file
    lanes = (each for edge in file.edges.values() for each in edge.permitted)
    if makes_no_difference((*lanes, *(way.permitted for way in file.connections)), vehicles):
        return roads
    return _read(file, vehicles, derive=roads.derived)


def _read(file: NetFile, vehicles: ClassCounts | None, *, derive: bool) -> SumoNetwork:
    path = file.path
    nodes = _Nodes(file)
    remarks = list(nodes.remarks)
    intersections: list[Intersection] = []
    signals: list[SumoSignals] = []
    for logic in nodes.logics:
        intersection, shown, found = _intersection(
            logic, nodes.connections[logic.id], file, vehicles, derive=derive
        )
        intersections.append(intersection)
        signals.append(shown)
        remarks += found
    if not intersections:
        raise NetworkError(
            "no traffic light controls vehicles",
            where=path,
            expected="at least one signal",
            mend="let SUMO guess them (netconvert -s FILE --tls.guess -o NEW_FILE), or name "
            "another file",
        )
    controlled = {logic.id for logic in nodes.logics}
    network = RoadNetwork(
        name=Path(path).name.removesuffix(".gz").removesuffix(".xml").removesuffix(".net"),
        links=tuple(
            Link(
                edge.id,
                nodes.of[edge.start],
                nodes.of[edge.end],
                edge.length_m,
                edge.speed_m_per_s,
                edge.lanes,
                frozenset(range(edge.lanes)) - frozenset(driven(edge.permitted, vehicles)),
            )
            for edge in file.edges.values()
        ),
        intersections=tuple(intersections),
        fringe=tuple(node for node in nodes.position_m if node not in nodes.connections),
        position_m=nodes.position_m,
        junctions=tuple(
            _junction(node, connections, file, vehicles)
            for node, connections in nodes.connections.items()
            if node not in controlled
        ),
        permissions=file.permissions,
        line_m={edge.id: edge.shape for edge in file.edges.values() if edge.shape},
        left_hand=file.left_hand,
    )
    check_network(network, where=path)
    return SumoNetwork(Path(path), network, tuple(signals), tuple(remarks), file, derive)


def _junction(
    node: str, connections: list[Connection], file: NetFile, vehicles: ClassCounts | None
) -> Junction:
    ways = ways_at(connections, file.edges, vehicles)
    foes = gives_way(ways, file, "", ("",))
    return Junction(node, ways.movements, foes if any(foes) else ())


def _intersection(
    logic: Logic,
    connections: list[Connection],
    file: NetFile,
    vehicles: ClassCounts | None,
    *,
    derive: bool,
) -> tuple[Intersection, SumoSignals, list[Remark]]:
    ways = ways_at(connections, file.edges, vehicles)
    links = letters_of(ways.driven, logic.id)
    crossings = crossings_of(logic.id, file)
    conflicts, complete = crossing(ways, file)
    plan = plan_of(logic, ways, links, conflicts, derive=derive)
    remarks = list(remarks_on(logic, ways, links, plan, file))
    if not complete:
        remarks.append(
            Remark(
                "no-right-of-way",
                f"{file.path}: tlLogic {logic.id}",
                "its junctions have no right-of-way matrix (<request>); all roads into it are "
                "taken to conflict",
                "rebuild the network with netconvert",
            )
        )
    intersection = Intersection(
        id=logic.id,
        movements=ways.movements,
        phases=plan.phases,
        unsignalled=plan.unsignalled,
        program=plan.program,
        own_control=plan.own_control,
        phase_names=tuple(phase_name(phase, ways.movements, ways.sides) for phase in plan.phases),
        clearance_s=plan.clearance_s,
        all_stop=stops_all(plan.program.stages if plan.program else (), untold=False),
        gives_way=gives_way(
            ways, file, logic.id, (*plan.states, *(stage.state for stage in logic.stages))
        ),
        conflicts=conflicts,
        walks=tuple(walk_of(each, logic, plan, links, file) for each in crossings),
    )
    letters = tuple(each.letter for each in crossings)
    return intersection, SumoSignals(logic.id, plan.states, links, letters), remarks


class _Nodes:
    """Which junctions make up which node.

    Attributes
    ----------
    logics
        Controllers of vehicles.
    of
        Junction id to node id.
    connections
        Node id to the connections there; nodes without any are missing.
    position_m
        Node id to its place: the middle of its junctions.
    remarks
        What was left aside.
    """

    def __init__(self, file: NetFile) -> None:
        self.remarks = [
            Remark(
                "signal-of-sumo",
                f"{file.path}: tlLogic {name}",
                f"it has no program ({kind or 'no junction of its name'}); SUMO works out what it "
                "shows, and here its nodes are junctions without signals",
                "nothing, if it is for trains; otherwise give it a program with netconvert",
            )
            for name, kind in file.foreign.items()
        ]
        owner = self._owners(file)
        self.logics = tuple(logic for logic in file.logics if logic.id in owner.values())
        names = {logic.id for logic in self.logics}
        self.of: dict[str, str] = {}
        self.connections: dict[str, list[Connection]] = {}
        places: dict[str, list[Point]] = {}
        used = {edge.start: None for edge in file.edges.values()}
        used |= {edge.end: None for edge in file.edges.values()}
        for junction in used:
            # A controller may be named like a junction that it does not control.
            free = f"{junction} (junction)" if junction in names else junction
            self.of[junction] = owner.get(junction, free)
            places.setdefault(self.of[junction], []).append(file.position_m[junction])
        self.position_m = {
            node: (fmean(x for x, _ in points), fmean(y for _, y in points))
            for node, points in places.items()
        }
        for way in file.connections:
            self.connections.setdefault(self.of[way.junction], []).append(way)

    def _owners(self, file: NetFile) -> dict[str, str]:
        """Return the controller of every junction that has one, and remark what is odd."""
        count: dict[str, Counter[str]] = {}
        for way in file.connections:
            if way.signal:
                count.setdefault(way.junction, Counter())[way.signal] += 1
        owner = {}
        for junction, signals in count.items():
            owner[junction] = signals.most_common(1)[0][0]
            if len(signals) > 1:
                self.remarks.append(
                    Remark(
                        "two-controllers",
                        f"{file.path}: junction {junction}",
                        f"the controllers {', '.join(signals)} share it; it is taken to be "
                        f"{owner[junction]}'s, and what others control there may always go",
                        "give it one controller (netconvert --tls.join, or netedit)",
                    )
                )
        for logic in file.logics:
            mine = [way for way in file.connections if owner.get(way.junction) == logic.id]
            if not _controlled(mine, logic.id):
                owner = {junction: name for junction, name in owner.items() if name != logic.id}
                self.remarks.append(
                    Remark(
                        "no-vehicles",
                        f"{file.path}: tlLogic {logic.id}",
                        "it controls no movement of vehicles; it is left out",
                        "nothing, if it is for pedestrians or trains",
                    )
                )
        return owner


def _controlled(connections: Iterable[Connection], signal: str) -> bool:
    """Whether there is a movement all of whose lanes a controller controls."""
    signals: dict[tuple[str, str], set[str]] = {}
    for way in connections:
        signals.setdefault((way.from_edge, way.to_edge), set()).add(way.signal)
    return {signal} in signals.values()
