"""A ``.net.xml`` as plain records, and what its reader gives: network, signals, remarks."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from dmil.network.lines import Line, Point
from dmil.network.model import RoadNetwork
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


RemarkKind = Literal[
    "no-vehicles",
    "two-controllers",
    "several-programs",
    "no-action",
    "single-action",
    "never-served",
    "empty-stage",
    "pedestrian-stage",
    "missing-yellow",
    "conflicting-greens",
    "stage-order",
    "no-right-of-way",
    "own-control",
    "signal-of-sumo",
    "program-switches",
]


@dataclass(frozen=True, slots=True)
class Remark:
    """Something that can be read, but that a user should know of (ours).

    Parameters
    ----------
    kind
        What it is about, one word for all of its sort:

        - ``no-vehicles``: a controller of no vehicle; it is left out.
        - ``two-controllers``: a junction under two controllers; what the lesser one controls always
        open.
        - ``several-programs``: the last one is used, as SUMO does.
        - ``no-action``: no stage of the program gives green; the phases are derived instead.
        - ``single-action``: there is nothing to choose.
        - ``never-served``: a movement that no action serves; phases are added for it.
        - ``empty-stage``: a long stage in which nothing goes.
        - ``pedestrian-stage``: a stage in which only those go who are no vehicles; no action
          shows it.
        - ``missing-yellow``: a green turns red at once.
        - ``conflicting-greens``: two lanes that cross or merge have the right of way at once.
        - ``stage-order``: stages that do not follow each other in the file's order.
        - ``own-control``: a control that only SUMO can run, such as NEMA rings.
        - ``signal-of-sumo``: a signal without a program, such as a rail crossing; SUMO runs it.
        - ``program-switches``: a timetable switches between programs during the day.
        - ``no-right-of-way``: the junction's matrix of right of way is missing; roads are taken to
          conflict with each other.
    where
        File and place in it.
    text
        What was found.
    mend
        What to do about it.
    """

    kind: RemarkKind
    where: str
    text: str
    mend: str


@dataclass(frozen=True, slots=True)
class SumoSignals:
    """How the phases of one intersection are shown in SUMO (ours).

    Parameters
    ----------
    id
        Id of the ``tlLogic``; the intersection's id too.
    states
        SUMO's state string of every phase, with the letters of the file.
    links
        For every movement its indices into these strings, of the lanes that vehicles use; none if
        no signal controls it.
    crossings
        For every crossing of pedestrians its index into these strings.
    """

    id: str
    states: tuple[str, ...]
    links: tuple[tuple[int, ...], ...]
    crossings: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class SumoNetwork:
    """A road network together with what is needed to drive it in SUMO (ours).

    Parameters
    ----------
    path
        The file.
    network
        What was read.
    signals
        One per intersection, in their order.
    remarks
        What is suspicious about the file, in the order of its signals.
    file
        What it was made from.
    derived
        Whether the phases are derived from conflicts.
    """

    path: Path
    network: RoadNetwork
    signals: tuple[SumoSignals, ...]
    remarks: tuple[Remark, ...]
    file: NetFile = field(repr=False)
    derived: bool = False

    @property
    def added_programs_xml(self) -> str:
        """Programs and timetables of additional files, as XML elements without a root element."""
        return self.file.added_programs_xml
