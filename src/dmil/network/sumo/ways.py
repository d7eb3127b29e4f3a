"""Movements at one node: connections of lanes put together, ordered, with their right of way."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from dmil.network.lines import heading
from dmil.network.model import TURNS, Movement, Turn
from dmil.network.naming import approach_names, order_counter_clockwise
from dmil.network.permissions import ClassCounts, driven
from dmil.network.sumo.records import Connection, Edge, NetFile

_TURN: dict[str, Turn] = {
    "r": "right",
    "R": "right",
    "s": "straight",
    "l": "left",
    "L": "left",
    "t": "uturn",
    "T": "uturn",
}

Pairs = frozenset[tuple[int, int]]
Groups = tuple[tuple[Connection, ...], ...]


@dataclass(frozen=True, slots=True)
class SumoMovements:
    """The movements at a node (ours).

    Parameters
    ----------
    movements
        In an intersection's order.
    connections
        For every movement the connections of lanes that it consists of.
    driven
        Those of them that the vehicles use.
    sides
        Name of every approach.
    """

    movements: tuple[Movement, ...]
    connections: Groups
    driven: Groups
    sides: tuple[str, ...]


def ways_at(
    connections: Iterable[Connection],
    edges: dict[str, Edge],
    vehicles: ClassCounts | None = None,
) -> SumoMovements:
    """Put the connections at a node together to movements and order them (ours).

    Who drives decides in which lanes; None where that is not known.
    """
    joined: dict[tuple[str, str], list[Connection]] = {}
    for way in connections:
        joined.setdefault((way.from_edge, way.to_edge), []).append(way)
    origin = {name: heading(edges[name].shape[::-1]) for name, _ in joined}
    approaches = order_counter_clockwise(origin)
    number = {name: index for index, name in enumerate(approaches)}
    turn = {pair: _turn(ways) for pair, ways in joined.items()}

    def place(pair: tuple[str, str]) -> tuple[int, int, float, str]:
        # Of several exits of one turn, the one furthest to the right comes first.
        towards = (heading(edges[pair[1]].shape) - origin[pair[0]]) % (2 * math.pi)
        return number[pair[0]], TURNS.index(turn[pair]), round(towards, 9), pair[1]

    order = sorted(joined, key=place)
    used = {
        pair: tuple(ways[k] for k in driven([way.permitted for way in ways], vehicles))
        for pair, ways in joined.items()
    }
    return SumoMovements(
        tuple(
            Movement(
                *pair,
                turn[pair],
                number[pair[0]],
                tuple(sorted({way.lane for way in used[pair]})),
            )
            for pair in order
        ),
        tuple(tuple(joined[pair]) for pair in order),
        tuple(used[pair] for pair in order),
        approach_names([origin[name] for name in approaches]),
    )


def letters_of(groups: Groups, signal: str) -> tuple[tuple[int, ...], ...]:
    """Return for every movement its indices into the state strings of a controller (ours)."""
    return tuple(
        tuple(sorted({way.letter for way in group if way.signal == signal})) for group in groups
    )


def crossing(ways: SumoMovements, file: NetFile) -> tuple[Pairs, bool]:
    """Find the movements whose paths cross, from the junctions' ``foes`` (ours).

    Returns pairs (i, j), i < j, and whether all matrices are there. Where one is missing, roads
    conflict with each other.
    """
    complete = all(
        (way.junction, way.row) in file.foes for group in ways.connections for way in group
    )
    found = {(min(pair), max(pair)) for pair in _related(ways.connections, file.foes)}
    if not complete:
        found |= {
            (i, j)
            for j, movement in enumerate(ways.movements)
            for i in range(j)
            if ways.movements[i].approach != movement.approach
        }
    return frozenset(found), complete


def gives_way(
    ways: SumoMovements, file: NetFile, signal: str, states: Iterable[str]
) -> tuple[tuple[int, ...], ...]:
    """Find the movements that each movement yields to, from the junctions' ``response`` (ours).

    As in SUMO, who has ``G`` yields to nobody; who has ``g``, a letter for a turn on red, or no
    signal yields to those that the matrix names, if they may go at the same time. Lanes that the
    vehicles do not use count for nothing. ``states`` are all that the controller can show; at a
    junction without one its name is empty.

    Nobody yields in a circle: where the matrix has one, only those who yield to more others yield
    to those who yield to fewer; without a controller two may yield to each other, which take turns.
    """
    shown = {
        (way.junction, way.row): way.letter if way.signal and way.signal == signal else None
        for group in ways.driven
        for way in group
    }
    response: dict[tuple[str, int], frozenset[int]] = {}
    for state in dict.fromkeys(states):
        letters = {row: "-" if k is None else state[k] for row, k in shown.items()}
        for row, letter in letters.items():
            if letter in "gso-":
                others = (k for k in file.response.get(row, ()) if (row[0], k) in letters)
                now = {k for k in others if letters[row[0], k] in "GgsoO-"}
                response[row] = response.get(row, frozenset()) | now
    yields: list[set[int]] = [set() for _ in ways.movements]
    for i, j in _related(ways.driven, response):
        yields[i].add(j)
    reaches = [reached([i], yields) for i in range(len(yields))]
    return tuple(
        tuple(
            sorted(
                k
                for k in foes
                if (not signal and i in yields[k])
                or i not in reaches[k]
                or len(foes) > len(yields[k])
            )
        )
        for i, foes in enumerate(yields)
    )


def reached(begin: Iterable[int], following: Sequence[Iterable[int]]) -> set[int]:
    """Return what comes after some places, at once or later: of them those that are come back to.

    ``following`` has for every place those that come next.
    """
    found: set[int] = set()
    left = list(begin)
    while left:
        new = set(following[left.pop()]) - found
        found |= new
        left += new
    return found


def _related(groups: Groups, matrix: dict[tuple[str, int], frozenset[int]]) -> set[tuple[int, int]]:
    movement_of = {
        (way.junction, way.row): index for index, group in enumerate(groups) for way in group
    }
    found = {
        (index, movement_of.get((junction, other), index))
        for (junction, row), index in movement_of.items()
        for other in matrix.get((junction, row), ())
    }
    return {(i, j) for i, j in found if i != j}


def _turn(ways: list[Connection]) -> Turn:
    """Return the turn of most lanes; directions that SUMO does not know count as straight."""
    turns = Counter(_TURN.get(way.direction, "straight") for way in ways)
    return max(TURNS, key=lambda turn: turns[turn])
