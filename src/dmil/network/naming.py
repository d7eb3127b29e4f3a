"""Order and names of sides and phases ("E/W F", "E F+L"), and what makes intersections alike."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping, Sequence

from dmil.network.model import Intersection, Movement, RoadNetwork

COMPASS = ("E", "NE", "N", "NW", "W", "SW", "S", "SE")
_LETTERS = (("straight", "F"), ("left", "L"), ("right", "R"), ("uturn", "U"))


def order_counter_clockwise(angle_rad: Mapping[str, float]) -> list[str]:
    """Order the roads into an intersection by the side that they come from (ours).

    Counter-clockwise from East, where East begins at -45°: a road from slightly South of East
    still comes first, so that four sides are always E, N, W, S. The angles, by link id, are
    counter-clockwise from East, of where its traffic comes from.
    """
    turn = 2 * math.pi

    def key(link: str) -> tuple[float, str]:
        return round((angle_rad[link] + math.pi / 4) % turn, 9) % turn, link

    return sorted(angle_rad, key=key)


def approach_names(angle_rad: Sequence[float]) -> tuple[str, ...]:
    """Name approaches after the point of the compass that their traffic comes from (ours).

    Angles are counter-clockwise from East. The points are of four if they tell the approaches
    apart, else of eight, else the names are numbers.
    """
    for step in (2, 1):
        points = COMPASS[::step]
        names = tuple(
            points[round(angle / (2 * math.pi) * len(points)) % len(points)] for angle in angle_rad
        )
        if len(set(names)) == len(names):
            return names
    return tuple(str(index) for index in range(len(angle_rad)))


def phase_name(phase: frozenset[int], movements: Sequence[Movement], sides: Sequence[str]) -> str:
    """Name a phase in the paper's manner: sides, then F, L, R or U (paper, §III).

    A phase is local indices of the movements; ``sides`` has the name of every approach.
    """
    served: dict[int, set[str]] = {}
    for index in sorted(phase):
        served.setdefault(movements[index].approach, set()).add(movements[index].turn)
    groups: dict[str, list[str]] = {}
    for approach, turns in served.items():
        letters = "+".join(letter for turn, letter in _LETTERS if turn in turns)
        groups.setdefault(letters, []).append(sides[approach])
    return ", ".join(f"{'/'.join(names)} {letters}" for letters, names in groups.items())


SAME_SIDE_RAD = math.radians(30)
"""Roads into and out of an intersection that differ by less are on one side."""


def shape_signature(intersection: Intersection) -> str:
    """Return a digest of what makes two intersections interchangeable (ours).

    Approaches, turns, phases and unsignalled movements count; names, lengths and the fixed-time
    plan do not. Intersections of equal signature may share memory (paper, §IV-B).
    """
    shape = [
        [[movement.approach, movement.turn] for movement in intersection.movements],
        [sorted(phase) for phase in intersection.phases],
        sorted(intersection.unsignalled),
    ]
    return hashlib.blake2b(json.dumps(shape).encode(), digest_size=8).hexdigest()


def exit_sides(network: RoadNetwork, intersection: Intersection) -> tuple[int, ...]:
    """Return for every movement the side by which it leaves, numbered like the approaches (ours).

    A movement leaves by the side of the approach that comes from the node it goes to; where roads
    into and out of a side have other nodes, such as split carriageways, by that of the approach
    from the same direction. Sides that only lead away get the numbers after the approaches. For the
    paper's intersection a movement from side s leaves by s + 1 (right), s + 2 (straight) or s + 3
    (left), modulo 4.

    Parameters
    ----------
    network
        The roads.
    intersection
        One of its intersections.
    """
    links, index = network.links, network.link_index

    def direction(node: str) -> float:
        here, there = network.position_m[intersection.id], network.position_m[node]
        return math.atan2(there[1] - here[1], there[0] - here[0])

    side_of_node: dict[str, int] = {}
    for movement in intersection.movements:
        side_of_node.setdefault(links[index[movement.from_link]].start, movement.approach)
    goals = dict.fromkeys(links[index[m.to_link]].end for m in intersection.movements)
    taken = {side_of_node[node] for node in goals if node in side_of_node}
    following = 1 + max(movement.approach for movement in intersection.movements)
    for node in goals:
        if node in side_of_node:
            continue
        turns = {
            origin: abs(math.remainder(direction(node) - direction(origin), math.tau))
            for origin, side in side_of_node.items()
            if side not in taken
        }
        nearest = min(turns, key=turns.__getitem__, default=None)
        if nearest is not None and turns[nearest] < SAME_SIDE_RAD:
            side_of_node[node] = side_of_node[nearest]
            taken.add(side_of_node[nearest])
        else:
            side_of_node[node] = following
            following += 1
    return tuple(side_of_node[links[index[m.to_link]].end] for m in intersection.movements)
