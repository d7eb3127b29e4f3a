"""Greens that conflict: who has the right of way at once, though their ways cross or merge."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

from dmil.network.sumo.net_file import read_net_file
from dmil.network.sumo.net_records import Connection, NetFile

Pair = tuple[Connection, Connection]


def foes_of(signal: str, file: NetFile, connections: Iterable[Connection]) -> list[Pair]:
    """Return the pairs of ways under one controller that cross or merge (ours).

    Parameters
    ----------
    signal
        The controller.
    file
        With the junctions' matrices of right of way.
    connections
        Ways of vehicles, those of other controllers too.
    """
    rows = {(way.junction, way.row): way for way in connections if way.signal == signal}
    return [
        (one, other)
        for (key, one), (key_, other) in combinations(rows.items(), 2)
        if key[0] == key_[0] and key_[1] in file.foes.get(key, ())
    ]


def clashing(state: str, foes: Iterable[Pair]) -> list[Pair]:
    """Return the pairs of ways that both have the right of way, ``G``, in a state (ours).

    Parameters
    ----------
    state
        A state string.
    foes
        Pairs that cross or merge.
    """
    return [pair for pair in foes if all(state[way.letter] == "G" for way in pair)]


@dataclass(frozen=True, slots=True)
class Clash:
    """Two movements that have the right of way at once, though they conflict (ours).

    Parameters
    ----------
    signal, state
        Where, and in which state.
    one, other
        The ways.
    """

    signal: str
    state: str
    one: Connection
    other: Connection

    def __str__(self) -> str:
        ways = " and ".join(
            f"{way.from_edge} to {way.to_edge} (letter {way.letter})"
            for way in (self.one, self.other)
        )
        return f"in {self.state} the movements {ways} cross or merge, and both have priority"


def first_clash(net_file: str | Path, shown: dict[str, list[str]]) -> Clash | None:
    """Check signal states against a network's matrices of right of way (ours).

    Lanes of one movement that merge are no clash: their drivers come from one road.

    Parameters
    ----------
    net_file
        The network, as SUMO reads it.
    shown
        Controller to all states that it is to show.

    Raises
    ------
    NetworkError
        If the network cannot be read.
    """
    file = read_net_file(net_file)
    for signal, states in shown.items():
        foes = [
            (one, other)
            for one, other in foes_of(signal, file, file.connections)
            if (one.from_edge, one.to_edge) != (other.from_edge, other.to_edge)
        ]
        for state in dict.fromkeys(states):
            for one, other in clashing(state, foes):
                return Clash(signal, state, one, other)
    return None
