"""Roads, movements and phases as frozen data.

A network has two kinds of nodes: fringe nodes feed and drain vehicles, intersections hold queues.
Links join nodes; a movement joins two links at an intersection; a phase is a set of movements that
may go together. The paper's intersection is one instance of this, not a special case.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal, TypeVar

import numpy as np
import numpy.typing as npt

from dmil.network.lines import Line
from dmil.network.permissions import Classes, Permissions
from dmil.network.program import Program

Scalar = TypeVar("Scalar", bound=np.generic)
Turn = Literal["right", "straight", "left", "uturn"]
TURNS: tuple[Turn, ...] = ("right", "straight", "left", "uturn")


@dataclass(frozen=True, slots=True)
class Link:
    """A road in one direction, from node to node (paper, §III; lengths and lanes ours).

    Parameters
    ----------
    id
        Name, unique in the network.
    start, end
        Node ids: an intersection's or a fringe node's.
    length_m
        Length in metres; 0 for a link without travel time.
    speed_m_per_s
        Free-flow speed.
    lanes
        Number of lanes.
    closed
        Lanes among them in which the vehicles do not drive, numbered as in the file: for
        pedestrians, bicycles, or classes of which there is hardly anybody.
    """

    id: str
    start: str
    end: str
    length_m: float
    speed_m_per_s: float
    lanes: int
    closed: frozenset[int] = frozenset()

    @property
    def open_lanes(self) -> int:
        """Number of lanes in which the vehicles drive."""
        return self.lanes - len(self.closed)

    @property
    def free_flow_time_s(self) -> float:
        """Travel time of an undisturbed vehicle in seconds."""
        return self.length_m / self.speed_m_per_s


@dataclass(frozen=True, slots=True)
class Movement:
    """The way from one link to another across an intersection (ours; the paper's "orientation").

    Parameters
    ----------
    from_link, to_link
        Link ids.
    turn
        Direction relative to the link that it comes from.
    approach
        Index of the side that it comes from, counter-clockwise from East.
    lanes
        Lanes of the link it comes from that serve it, numbered as in the file; 0 is the rightmost
        one in SUMO's. Movements may share lanes.
    """

    from_link: str
    to_link: str
    turn: Turn
    approach: int
    lanes: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Walk:
    """A crossing of pedestrians under an intersection's signals (ours).

    Parameters
    ----------
    phases
        Those that it goes with.
    least_s
        Shortest green of its pedestrians.
    clear_s
        Time from the end of that until vehicles may cross their way.
    """

    phases: frozenset[int]
    least_s: int
    clear_s: int


@dataclass(frozen=True, slots=True)
class Intersection:
    """Movements under one signal controller, and its phases (paper, §III; generalised).

    Usually that is one junction; where a controller governs several, all of them are one
    intersection, and the links between them start and end at it.

    Parameters
    ----------
    id
        Node id.
    movements
        Ordered by approach, then right, straight, left, u-turn: for four sides with three lanes
        this is the paper's movement j = 3*side + lane, sides E, N, W, S.
    phases
        For every action the local indices of the movements that it serves.
    unsignalled
        Local indices of the movements that always may go (the paper's right turns).
    program
        Fixed-time plan of the file, if it has one.
    own_control
        SUMO's type of the file's control where that is no plan of one stage after the other and
        only SUMO can run it, such as ``NEMA``; else empty.
    phase_names
        One readable name per phase, may be empty.
    clearance_s
        Longest clearance between two phases of that plan, 0 if it has none.
    all_stop
        Whether at a change of phase everybody stops, those too who have green before and after it;
        else these keep their green.
    gives_way
        For every movement the movements that it yields to while they have green and a queue; may
        be empty. Nobody yields in a circle.
    conflicts
        Pairs (i, j), i < j, of movements whose paths cross; may be empty where not known.
    walks
        Crossings of pedestrians.
    """

    id: str
    movements: tuple[Movement, ...]
    phases: tuple[frozenset[int], ...]
    unsignalled: frozenset[int]
    program: Program | None = None
    own_control: str = ""
    phase_names: tuple[str, ...] = ()
    clearance_s: float = 0.0
    all_stop: bool = False
    gives_way: tuple[tuple[int, ...], ...] = ()
    conflicts: frozenset[tuple[int, int]] = frozenset()
    walks: tuple[Walk, ...] = ()

    @property
    def planned_green_s(self) -> dict[int, float]:
        """Phase to seconds of green per cycle; phases that are never shown are missing."""
        found: dict[int, float] = {}
        for stage in self.program.stages if self.program else ():
            if stage.green in self.phases and not stage.clearance:
                phase = self.phases.index(stage.green)
                found[phase] = found.get(phase, 0.0) + stage.duration_s
        return found


@dataclass(frozen=True, slots=True)
class Junction:
    """A node without signals: nobody controls it (ours).

    Parameters
    ----------
    id
        Node id.
    movements
        The ways across it.
    gives_way
        For every movement the movements that it yields to; empty if nobody does.
    """

    id: str
    movements: tuple[Movement, ...]
    gives_way: tuple[tuple[int, ...], ...] = ()


@dataclass(frozen=True)
class RoadNetwork:
    """Links, intersections, junctions without signals and fringe nodes (paper, §III).

    Parameters
    ----------
    name
        Readable name such as ``grid:5x5``.
    links, intersections
        In a fixed order: arrays elsewhere use their indices here.
    fringe
        Ids of the nodes where vehicles enter and leave.
    position_m
        Node id to (x, y) in metres, x to the East and y to the North; for drawings only.
    junctions
        Nodes without signals.
    permissions
        Which vehicle classes may use which lanes; None where all may use all.
    line_m
        Link id to the points along it, where the file has them: from stop line to stop line in the
        middle of its leftmost lane, or from node to node along its left edge; for drawings only.
    left_hand
        Whether traffic keeps to the left.
    lanes_from_left
        Whether lane 0 is the leftmost one, as in CityFlow's files, or else the rightmost one.
    """

    name: str
    links: tuple[Link, ...]
    intersections: tuple[Intersection, ...]
    fringe: tuple[str, ...]
    position_m: Mapping[str, tuple[float, float]] = field(repr=False)
    junctions: tuple[Junction, ...] = ()
    permissions: Permissions | None = field(default=None, repr=False)
    line_m: Mapping[str, Line] = field(default_factory=dict, repr=False, compare=False)
    left_hand: bool = False
    lanes_from_left: bool = False

    def __hash__(self) -> int:
        # The dataclass's own hash would walk all links at every look-up of a cache.
        return hash((self.name, len(self.links), len(self.intersections), self.fringe))

    @cached_property
    def link_index(self) -> dict[str, int]:
        """Link id to index in ``links``."""
        return {link.id: index for index, link in enumerate(self.links)}

    @cached_property
    def intersection_index(self) -> dict[str, int]:
        """Intersection id to index in ``intersections``."""
        return {node.id: index for index, node in enumerate(self.intersections)}

    @property
    def nodes(self) -> tuple[Intersection | Junction, ...]:
        """All nodes that are crossed."""
        return (*self.intersections, *self.junctions)

    @cached_property
    def entry_links(self) -> tuple[int, ...]:
        """Indices of the links that start at a fringe node."""
        fringe = set(self.fringe)
        return tuple(i for i, link in enumerate(self.links) if link.start in fringe)

    @cached_property
    def exit_links(self) -> tuple[int, ...]:
        """Indices of the links that end at a fringe node."""
        fringe = set(self.fringe)
        return tuple(i for i, link in enumerate(self.links) if link.end in fringe)

    @cached_property
    def movement_count(self) -> npt.NDArray[np.int32]:
        """Movements of each intersection: (intersections,) int32, read-only."""
        counts = [len(node.movements) for node in self.intersections]
        return _read_only(np.array(counts, np.int32))

    @cached_property
    def movement_index(self) -> dict[tuple[int, int], tuple[int, int]]:
        """(from link, to link) to (intersection, local movement), all as indices."""
        link = self.link_index
        return {
            (link[movement.from_link], link[movement.to_link]): (i, j)
            for i, node in enumerate(self.intersections)
            for j, movement in enumerate(node.movements)
        }

    @cached_property
    def successors(self) -> tuple[tuple[tuple[int, Turn], ...], ...]:
        """For every link the (next link, turn) pairs that its movements allow."""
        link = self.link_index
        found: list[list[tuple[int, Turn]]] = [[] for _ in self.links]
        for node in self.nodes:
            for movement in node.movements:
                found[link[movement.from_link]].append((link[movement.to_link], movement.turn))
        return tuple(tuple(pairs) for pairs in found)

    def successors_for(self, classes: Classes) -> tuple[tuple[tuple[int, Turn], ...], ...]:
        """Return `successors` as far as vehicles of some classes may go that way.

        Parameters
        ----------
        classes
            What the vehicles are.
        """
        allowed = self.permissions
        if allowed is None or not classes:
            return self.successors
        if classes not in self._successors:
            names = [link.id for link in self.links]
            self._successors[classes] = tuple(
                tuple(p for p in pairs if allowed.lanes_to(names[here], names[p[0]], classes))
                for here, pairs in enumerate(self.successors)
            )
        return self._successors[classes]

    @cached_property
    def _successors(self) -> dict[Classes, tuple[tuple[tuple[int, Turn], ...], ...]]:
        return {}

    def lanes_to(self, movement: Movement, classes: Classes | None = None) -> tuple[int, ...]:
        """Return the lanes in which vehicles queue for a movement.

        Parameters
        ----------
        movement
            One of the network's.
        classes
            What the vehicles are; None: the lanes of anybody.
        """
        if self.permissions is None:
            return movement.lanes
        pair = movement.from_link, movement.to_link
        return self.permissions.lanes_to(*pair, classes or Classes()) or movement.lanes

    @cached_property
    def free_flow_time_s(self) -> npt.NDArray[np.float64]:
        """Free-flow travel time of every link: (links,) float64, seconds, read-only."""
        return _read_only(np.array([link.free_flow_time_s for link in self.links], np.float64))

    @cached_property
    def movement_links(self) -> npt.NDArray[np.int32]:
        """Links from, to of movements: (2, intersections, most movements); for none len(links)."""
        most, index = max(len(node.movements) for node in self.intersections), self.link_index
        found = np.full((2, len(self.intersections), most), len(self.links), np.int32)
        for i, node in enumerate(self.intersections):
            for j, move in enumerate(node.movements):
                found[:, i, j] = index[move.from_link], index[move.to_link]
        return _read_only(found)

    @property
    def clearance_s(self) -> float:
        """Longest clearance phase of any intersection in seconds."""
        return max((node.clearance_s for node in self.intersections), default=0.0)


def _read_only(array: npt.NDArray[Scalar]) -> npt.NDArray[Scalar]:
    array.flags.writeable = False
    return array
