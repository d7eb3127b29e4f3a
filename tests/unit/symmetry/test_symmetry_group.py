"""Symmetries of intersections: found ones against brute force, and the laws of groups."""

from itertools import permutations

import numpy as np
import pytest

from dmil.controllers.tabular.agents import agents_of
from dmil.network import Intersection, Link, Movement, RoadNetwork, grid
from dmil.symmetry import find_group
from dmil.symmetry.group import MOST_SIDES


def junction(sides, turns, phases):
    """Return origin, goal, turn and served of a junction.

    ``turns`` maps a step counter-clockwise to the name of the turn; phases are sets of
    (from, to) pairs.
    """
    movements = [(s, (s + k) % sides, name) for s in range(sides) for k, name in turns.items()]
    return of_movements(movements, phases)


def of_movements(movements, phases):
    origin, goal, turn = zip(*movements, strict=True)
    served = [[(o, g) in phase for o, g, _ in movements] for phase in phases]
    return list(origin), list(goal), list(turn), np.array(served)


ALL = {1: "right", 2: "straight", 3: "left"}
RIGHT = {(s, (s + 1) % 4) for s in range(4)}


def straight(*sides):
    return {(s, (s + 2) % 4) for s in sides}


def left(*sides):
    return {(s, (s + 3) % 4) for s in sides}


PAPER = junction(
    4,
    ALL,
    [
        RIGHT | phase
        for phase in (
            straight(0, 2),
            left(0, 2),
            straight(1, 3),
            left(1, 3),
            *(straight(s) | left(s) for s in range(4)),
        )
    ],
)

JUNCTIONS = {
    "the paper's": (PAPER, 4),
    # E, W and S of a four-way, the way straight on between E and W.
    "a T": (
        of_movements(
            [
                (0, 1, "straight"),
                (0, 2, "left"),
                (1, 2, "right"),
                (1, 0, "straight"),
                (2, 0, "right"),
                (2, 1, "left"),
            ],
            [{(0, 1), (1, 0), (1, 2)}, {(0, 2), (2, 0)}, {(2, 0), (2, 1)}],
        ),
        1,
    ),
    "a Y": (junction(3, {1: "right", 2: "left"}, [{(s, 0), (s, 1), (s, 2)} for s in range(3)]), 3),
    "a Y with one side preferred": (
        junction(3, {1: "right", 2: "left"}, [{(0, 1), (0, 2)}, {(1, 2), (1, 0), (2, 0), (2, 1)}]),
        1,
    ),
    "two phases": (
        junction(
            4,
            ALL,
            [{(s, g) for s in pair for g in range(4)} for pair in ((0, 2), (1, 3))],
        ),
        4,
    ),
    "two phases of unlike length": (
        junction(4, ALL, [straight(0, 2), straight(1, 3) | left(1, 3)]),
        2,
    ),
    # Without turning there is no left and right: mirrors are symmetries too.
    "straight ways only": (junction(4, {2: "straight"}, [straight(0, 2), straight(1, 3)]), 8),
    "five sides": (
        junction(
            5,
            {1: "right", 2: "straight", 3: "straight", 4: "left"},
            [{(s, g) for g in range(5)} for s in range(5)],
        ),
        5,
    ),
    "with U-turns": (
        junction(4, {**ALL, 0: "uturn"}, [{(s, g) for g in range(4)} for s in range(4)]),
        4,
    ),
    "one side": (of_movements([(0, 1, "straight")], [{(0, 1)}]), 1),
}
EACH = pytest.mark.parametrize("name", JUNCTIONS)


def brute_force(origin, goal, turn, served):
    """Return every relabelling of the sides that keeps the sets of movements and of phases."""
    movements = list(zip(origin, goal, turn, strict=True))
    phases = {frozenset(m for m, s in zip(movements, row, strict=True) if s) for row in served}
    found = set()
    for image in permutations(range(max(*origin, *goal) + 1)):
        moved = {m: (image[m[0]], image[m[1]], m[2]) for m in movements}
        if set(moved.values()) != set(movements):
            continue
        if {frozenset(moved[m] for m in phase) for phase in phases} == phases:
            found.add(tuple(movements.index(moved[m]) for m in movements))
    return found


@EACH
def test_the_group_is_what_brute_force_finds(name):
    arguments, size = JUNCTIONS[name]
    group = find_group(*arguments)
    found = {tuple(image) for image in group.movement_image.tolist()}
    assert found == brute_force(*arguments)
    assert len(found) == group.size == size


def test_a_junction_small_enough_by_brute_force_over_its_movements():
    """Any exchange of movements that respects common sides comes from one of sides."""
    (origin, goal, turn, served), _ = JUNCTIONS["a Y"]
    phases = {tuple(row) for row in served.tolist()}
    found = set()
    for image in permutations(range(6)):
        sides = {
            (old[j], new[image[j]])
            for j in range(6)
            for old, new in ((origin, origin), (goal, goal))
        }
        is_relabelling = len(sides) == 3 and len({new for _, new in sides}) == 3
        keeps_turns = all(turn[j] == turn[image[j]] for j in range(6))
        moved = {tuple(row[image.index(j)] for j in range(6)) for row in served.tolist()}
        if is_relabelling and keeps_turns and moved == phases:
            found.add(image)
    group = find_group(origin, goal, turn, served)
    assert {tuple(image) for image in group.movement_image.tolist()} == found


@EACH
def test_the_laws_of_groups(name):
    group = find_group(*JUNCTIONS[name][0])
    elements = [
        (tuple(places), tuple(phases))
        for places, phases in zip(
            group.movement_image.tolist(), group.phase_image.tolist(), strict=True
        )
    ]
    identity = elements[0]
    assert all(image == tuple(range(len(image))) for image in identity)
    for element in elements:
        assert all(sorted(image) == list(range(len(image))) for image in element)
        assert [after(element, other) for other in elements].count(identity) == 1
        # Closure also of the pair: phases follow the movements.
        assert all(after(element, other) in elements for other in elements)


def after(second, first):
    return tuple(
        tuple(late[early[j]] for j in range(len(early)))
        for late, early in zip(second, first, strict=True)
    )


@EACH
def test_the_image_of_a_phase_serves_the_images_of_its_movements(name):
    (*_, served), _ = JUNCTIONS[name]
    group = find_group(*JUNCTIONS[name][0])
    for places, phases in zip(group.movement_image, group.phase_image, strict=True):
        for phase, row in enumerate(served):
            image = {int(places[j]) for j in np.flatnonzero(row)}
            assert image == set(np.flatnonzero(served[phases[phase]]).tolist())


def test_the_papers_intersection_has_its_four_rotations():
    group = agents_of(grid(1, 1)).groups[0]
    assert group.size == 4
    rotations = {tuple((j + 3 * k) % 12 for j in range(12)) for k in range(4)}
    assert {tuple(image) for image in group.movement_image.tolist()} == rotations
    quarter = group.movement_image.tolist().index([(j + 3) % 12 for j in range(12)])
    # E→N, N→W, W→S, S→E: (E/W F) becomes (N/S F), (E F+L) becomes (N F+L), and so on.
    assert group.phase_image[quarter].tolist() == [2, 3, 0, 1, 5, 6, 7, 4]


def test_a_mirror_is_no_symmetry():
    origin, goal, turn, served = PAPER
    mirror = [2, 1, 0, 3]
    mirrored = [
        next(k for k in range(12) if (origin[k], goal[k]) == (mirror[origin[j]], mirror[goal[j]]))
        for j in range(12)
    ]
    # It is a relabelling of the sides, but makes left turns of right turns.
    assert sorted(mirrored) == list(range(12))
    assert any(turn[j] != turn[mirrored[j]] for j in range(12))
    assert mirrored not in find_group(*PAPER).movement_image.tolist()
    # Nor does it fit the phases if the turns had no names: right turns always go, left ones do not.
    nameless = find_group(origin, goal, ["any"] * 12, served)
    assert mirrored not in nameless.movement_image.tolist()


def test_what_cannot_be_told_apart_gets_the_identity_only():
    origin, goal, turn, served = junction(3, {1: "right"}, [{(s, (s + 1) % 3)} for s in range(3)])
    twice = find_group(origin + origin, goal + goal, turn + turn, np.hstack([served, served]))
    assert twice.movement_image.tolist() == [list(range(6))]
    same_phases = find_group(origin, goal, turn, np.vstack([served, served]))
    assert same_phases.phase_image.tolist() == [list(range(6))]


def test_above_the_most_sides_only_the_identity_is_offered():
    sides = MOST_SIDES + 1
    group = find_group(
        *junction(sides, {1: "right"}, [{(s, (s + 1) % sides)} for s in range(sides)])
    )
    assert group.size == 1
    group = find_group(*junction(7, {1: "right"}, [{(s, (s + 1) % 7)} for s in range(7)]))
    assert group.size == 7


def test_sides_are_nodes_not_links():
    """Two links from one node, one for each turn, are one side."""
    links, movements = [], []
    for s in range(4):
        links.append(Link(f"out{s}", "X", f"N{s}", 0.0, 10.0, 1))
        for k, turn in ALL.items():
            links.append(Link(f"in{s}{turn}", f"N{s}", "X", 0.0, 10.0, 1))
            movements.append(Movement(f"in{s}{turn}", f"out{(s + k) % 4}", turn, s, (0,)))
    phases = grid(1, 1).intersections[0].phases
    node = Intersection("X", tuple(movements), phases, frozenset({0, 3, 6, 9}))
    network = RoadNetwork("split", tuple(links), (node,), ("N0", "N1", "N2", "N3"), {})
    assert agents_of(network).groups[0].size == 4
