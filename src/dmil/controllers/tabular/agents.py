"""The agents of a network: their shapes, symmetries and classes, and what they begin with."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from dmil.arrays import IntArray
from dmil.memory import ValueTable
from dmil.network import Intersection, RoadNetwork, exit_sides, shape_signature
from dmil.symmetry import Classes, Embedding, SymmetryGroup, build_classes, find_group


@dataclass(frozen=True, slots=True, eq=False)
class Agents:
    """One agent per intersection; agents of one shape may share memory (specification, §5).

    Attributes
    ----------
    shape: (agents,) int32
        Shape of each agent's intersection.
    signatures: (shapes,) of str
        What identifies a shape, also in saved policies.
    groups: (shapes,) of SymmetryGroup
    members: (shapes,) of (members,) int32 arrays
        Agents of each shape.
    """

    shape: IntArray
    signatures: tuple[str, ...]
    groups: tuple[SymmetryGroup, ...]
    members: tuple[IntArray, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Prior:
    """An exact Q-table of states, one owner per shape of intersection (paper, §VI-B).

    Equal only to itself, so that what is derived from it can be kept and shared.

    Attributes
    ----------
    table: ValueTable
    """

    table: ValueTable


@lru_cache(maxsize=64)
def agents_of(network: RoadNetwork) -> Agents:
    """Find the shapes of a network's intersections and their symmetries (ours)."""
    signatures: dict[str, int] = {}
    groups: list[SymmetryGroup] = []
    shape = []
    for item in network.intersections:
        signature = shape_signature(item)
        if signature not in signatures:
            signatures[signature] = len(signatures)
            groups.append(_symmetries(item, network))
        shape.append(signatures[signature])
    shapes = np.array(shape, np.int32)
    return Agents(
        shape=shapes,
        signatures=tuple(signatures),
        groups=tuple(groups),
        members=tuple(np.flatnonzero(shapes == s).astype(np.int32) for s in range(len(groups))),
    )


@lru_cache(maxsize=256)
def classes_of(network: RoadNetwork, embedding: Embedding) -> Classes:
    """Make an embedding concrete for the agents of a network (ours)."""
    agents = agents_of(network)
    return build_classes(embedding, agents.groups, agents.shape)


def _symmetries(intersection: Intersection, network: RoadNetwork) -> SymmetryGroup:
    """Find which relabellings of the sides fit."""
    served = np.zeros((len(intersection.phases), len(intersection.movements)), np.bool_)
    for p, phase in enumerate(intersection.phases):
        served[p, sorted(phase | intersection.unsignalled)] = True
    origin = [movement.approach for movement in intersection.movements]
    turn = [movement.turn for movement in intersection.movements]
    return find_group(origin, exit_sides(network, intersection), turn, served)
