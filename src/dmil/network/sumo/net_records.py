"""A ``.net.xml`` as plain records: its roads, connections, signal programs and right of way."""

from __future__ import annotations

from dataclasses import dataclass

from dmil.network.lines import Line, Point
from dmil.network.permissions import Classes, Permissions


@dataclass(frozen=True, slots=True)
class Edge:
    """A road of the file that vehicles may use; lanes for others are counted too (ours).

    ``permitted`` are the classes of every lane.
    """

    id: str
    start: str
    end: str
    length_m: float
    speed_m_per_s: float
    lanes: int
    shape: Line
    permitted: tuple[Classes, ...]


@dataclass(frozen=True, slots=True)
class Connection:
    """A way of vehicles from a lane to a lane (ours).

    Parameters
    ----------
    from_edge, to_edge, lane
        From which lane to which edge.
    direction
        SUMO's letter for the turn.
    signal
        Controller, empty if there is none.
    letter
        Index into the controller's state strings.
    junction, row
        Where it is, and its row in that junction's matrix of right of way.
    permitted
        Classes that may take it: those that may use the lanes on both sides, too.
    """

    from_edge: str
    to_edge: str
    lane: int
    direction: str
    signal: str
    letter: int
    junction: str
    row: int
    permitted: Classes


@dataclass(frozen=True, slots=True)
class CrossingRecord:
    """A crossing of pedestrians under a controller (ours).

    Parameters
    ----------
    signal, letter
        Controller, and index into its state strings.
    junction, row
        Where it is, and its row in that junction's matrix of right of way.
    length_m
        How far pedestrians walk.
    """

    signal: str
    letter: int
    junction: str
    row: int
    length_m: float


@dataclass(frozen=True, slots=True)
class StageRecord:
    """One ``<phase>`` (ours).

    ``after`` names the stages that may follow, empty: the next one. ``min_s`` and ``max_s`` are its
    limits, None where the file gives none.
    """

    duration_s: float
    state: str
    after: tuple[int, ...]
    min_s: float | None = None
    max_s: float | None = None


@dataclass(frozen=True, slots=True)
class Logic:
    """The program that SUMO uses for one controller (ours).

    Parameters
    ----------
    id
        Of the controller.
    kind
        SUMO's type: ``static``, ``actuated`` ….
    offset_s
        A time at which the cycle begins.
    stages
        In the file's order.
    programs
        Ids of all programs that there are for it, the one in charge last.
    switches
        Later times at which a schedule (WAUT) switches to another program, and to which.
    """

    id: str
    kind: str
    offset_s: float
    stages: tuple[StageRecord, ...]
    programs: tuple[str, ...]
    switches: tuple[tuple[float, str], ...] = ()


@dataclass(frozen=True, slots=True)
class NetFile:
    """The parts of a network file that matter for vehicles (ours).

    Parameters
    ----------
    path
        The file.
    edges
        Edge id to edge.
    permissions
        Who may use which lanes of them.
    position_m
        Junction id to its place.
    connections
        All ways of vehicles.
    logics
        The used program of every controller, in the file's order.
    foes, response
        (junction, row) to the rows that cross it, and to those that it gives way to.
    foreign
        Signals that connections name and that have no program, to the type of the junction of that
        name: SUMO works out what they show, as at a rail crossing.
    added_programs_xml
        Programs and timetables of additional files, as XML elements without a root element.
    crossings
        Those of pedestrians that a controller stops.
    left_hand
        Whether traffic keeps to the left.
    """

    path: str
    edges: dict[str, Edge]
    permissions: Permissions
    position_m: dict[str, Point]
    connections: tuple[Connection, ...]
    logics: tuple[Logic, ...]
    foes: dict[tuple[str, int], frozenset[int]]
    response: dict[tuple[str, int], frozenset[int]]
    foreign: dict[str, str]
    added_programs_xml: str
    crossings: tuple[CrossingRecord, ...] = ()
    left_hand: bool = False
