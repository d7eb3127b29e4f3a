"""Order and names of sides and phases."""

import math

import pytest

from dmil.network import grid
from dmil.network.naming import approach_names, order_counter_clockwise, phase_name


def degrees(**angles):
    return {name: math.radians(angle) for name, angle in angles.items()}


@pytest.mark.parametrize(
    ("angles", "order"),
    [
        (degrees(s=-90, w=180, n=90, e=0), "enws"),
        (degrees(s=262, w=-172, n=97, e=-8), "enws"),
        (degrees(s=-83, w=187, n=83, e=8), "enws"),
        (degrees(w=180, n=90, s=270), "nws"),
        (degrees(a=0, b=0, c=-1e-12), "abc"),
        (degrees(se=-45, ne=45), ["se", "ne"]),
    ],
)
def test_sides_are_counter_clockwise_from_east(angles, order):
    assert order_counter_clockwise(angles) == list(order)


@pytest.mark.parametrize(
    ("angles", "names"),
    [
        ([0, 90, 180, 270], ("E", "N", "W", "S")),
        ([-10, 80, 190], ("E", "N", "W")),
        ([0, 50, 90], ("E", "NE", "N")),
        ([0, 1, 2], ("0", "1", "2")),
        ([359.9], ("E",)),
    ],
)
def test_approaches_are_named_after_the_compass(angles, names):
    assert approach_names([math.radians(angle) for angle in angles]) == names


def test_generated_phase_names_are_the_papers():
    node = grid(1, 1).intersections[0]
    for phase, name in zip(node.phases, node.phase_names, strict=True):
        assert phase_name(phase, node.movements, "ENWS") == name


def test_mixed_phases_are_named_group_by_group():
    movements = grid(1, 1).intersections[0].movements
    assert phase_name(frozenset({1, 4, 5, 10, 11, 6}), movements, "ENWS") == "E F, N/S F+L, W R"
