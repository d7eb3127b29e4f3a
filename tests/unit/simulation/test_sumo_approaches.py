"""Which stop line a vehicle comes to, and how far away it counts."""

import numpy as np
import pytest

from dmil.demand import Vehicles
from dmil.network import Intersection, Junction, Link, Movement, RoadNetwork
from dmil.simulation.sumo.approaches import (
    build_ways,
    count_vehicles,
    passed_in_all,
    reached_stop_lines,
    rerouted,
)

SHAPE = (2, 2)


@pytest.fixture(scope="module")
def road():
    """A street: in, long, then a junction without signals, stub, signals 1, back, signals 0."""
    links = [("in", "W", "2", 300), ("stub", "2", "1", 50), ("far", "1", "0", 400)]
    links += [("out", "0", "E", 100), ("side", "1", "S", 100)]
    speed = 10.0

    def ahead(a, b, turn="straight"):
        return Movement(a, b, turn, 0, (0,))

    return RoadNetwork(
        "street",
        tuple(Link(name, a, b, float(m), speed, 1) for name, a, b, m in links),
        (
            Intersection("0", (ahead("far", "out"),), (frozenset({0}),), frozenset()),
            Intersection(
                "1",
                (ahead("stub", "side", "right"), ahead("stub", "far")),
                (frozenset({0}), frozenset({1})),
                frozenset(),
            ),
        ),
        ("W", "E", "S"),
        {node: (0.0, 0.0) for node in "W01E2S"},
        (Junction("2", (ahead("in", "stub"),)),),
    )


@pytest.fixture(scope="module")
def ways(road):
    """Vehicle 0 drives straight through, 1 turns at signals 1, 2 stays on its first link."""
    routes = [["in", "stub", "far", "out"], ["in", "stub", "side"], ["in"]]
    links = [road.link_index[link] for route in routes for link in route]
    offset = np.array([0, 4, 7, 8], np.int32)
    return build_ways(road, Vehicles(np.zeros(3, np.int32), offset, np.array(links, np.int32)))


def as_seen(*rows):
    """Return rows of vehicles as the simulator gets them from SUMO's process."""
    return np.frombuffer(np.array(rows, np.float64).T.tobytes()).reshape(5, -1)


def counted(road, ways, *rows, detection_m=200.0, within_s=10):
    seen = as_seen(*rows)
    *counts, _ = count_vehicles(ways, seen, SHAPE, within_s=within_s, detection_m=detection_m)
    return [array.tolist() for array in counts]


NOBODY = [[0, 0], [0, 0]]


def test_the_next_stop_line_of_every_place(ways):
    assert ways.movement.tolist() == [3, 3, 0, -1, 2, 2, -1, -1]
    assert ways.own.tolist() == [False, True, True, False, False, True, False, False]
    assert ways.ahead_m[:3].tolist() == [350.0, 50.0, 400.0]
    assert ways.ahead_s[:3].tolist() == [35.0, 5.0, 40.0]
    assert ways.passed.tolist() == [0, 0, 1, 2, 0, 0, 1, 0]


def test_a_vehicle_that_halts_is_queued(road, ways):
    assert counted(road, ways, (0, 1, 45, 0.05, 0)) == [[[0, 0], [0, 1]], NOBODY]
    assert counted(road, ways, (1, 1, 45, 0.0, 0)) == [[[0, 0], [1, 0]], NOBODY]


def test_the_queue_of_a_long_link_counts_to_its_beginning(road, ways):
    assert counted(road, ways, (0, 2, 1, 0.0, 0)) == [[[1, 0], [0, 0]], NOBODY]


def test_detectors_see_over_junctions_without_signals(road, ways):
    assert counted(road, ways, (0, 0, 160, 0.0, 0)) == [[[0, 0], [0, 1]], NOBODY]
    assert counted(road, ways, (0, 0, 140, 0.0, 0)) == [NOBODY, NOBODY]
    assert counted(road, ways, (0, 0, 290, 0.0, 0), detection_m=55.0) == [NOBODY, NOBODY]


def test_a_moving_vehicle_approaches_if_it_is_near(road, ways):
    assert counted(road, ways, (0, 2, 301, 5.0, 0)) == [NOBODY, [[1, 0], [0, 0]]]
    assert counted(road, ways, (0, 2, 299, 5.0, 0)) == [NOBODY, NOBODY]
    assert counted(road, ways, (0, 2, 299, 5.0, 0), within_s=11) == [NOBODY, [[1, 0], [0, 0]]]


def test_a_vehicle_on_a_junction_comes_to_what_follows(road, ways):
    # Its position is that on the junction's lane.
    assert counted(road, ways, (0, 1, 9, 0.0, 1)) == [[[1, 0], [0, 0]], NOBODY]
    assert counted(road, ways, (0, 0, 9, 5.0, 1)) == [NOBODY, [[0, 0], [0, 1]]]


def test_nobody_counts_behind_the_last_signals_or_off_the_road(road, ways):
    rows = (0, 3, 5, 0.0, 0), (2, 0, 290, 0.0, 0), (0, 2, 390, -(2.0**30), 0)
    assert counted(road, ways, *rows) == [NOBODY, NOBODY]


def test_halting_vehicles_count_wherever_they_are(ways):
    rows = (0, 3, 5, 0.09, 0), (2, 0, 290, 0.0, 0), (0, 1, 9, 0.0, 1), (0, 0, 9, 0.1, 0)
    seen = as_seen(*rows, (0, 2, 390, -(2.0**30), 0))
    assert count_vehicles(ways, seen, SHAPE, within_s=10, detection_m=200.0)[2] == 3


def test_stop_lines_that_vehicles_have_come_to(ways):
    assert reached_stop_lines(ways, as_seen((0, 0, 9, 1, 0), (1, 1, 9, 1, 0), (2, 0, 9, 1, 0))) == 1
    assert reached_stop_lines(ways, as_seen((0, 3, 9, 1, 0))) == 2


def test_who_is_sent_elsewhere_counts_there(road, ways):
    after = rerouted(road, ways, {1: ("in", "stub", "far", "out"), 2: ("in", "stub", "side")})
    assert counted(road, after, (1, 1, 45, 0.0, 0)) == [[[0, 0], [0, 1]], NOBODY]
    assert counted(road, after, (2, 1, 45, 0.0, 0)) == [[[0, 0], [1, 0]], NOBODY]
    assert counted(road, after, (0, 1, 45, 0.0, 0)) == [[[0, 0], [0, 1]], NOBODY]
    assert [passed_in_all(after, np.array([each])) for each in range(3)] == [2, 2, 1]
    assert [passed_in_all(ways, np.array([each])) for each in range(3)] == [2, 1, 0]
    back = rerouted(road, after, {1: ("in", "stub", "side")})
    assert counted(road, back, (1, 1, 45, 0.0, 0)) == [[[0, 0], [1, 0]], NOBODY]
    assert passed_in_all(back, np.arange(3)) == 4


def test_nobody_counts_on_an_edge_that_the_network_does_not_have(road, ways):
    after = rerouted(road, ways, {0: ("a bus lane", "stub", "far", "out")})
    assert counted(road, after, (0, 1, 45, 0.0, 0)) == [[[0, 0], [0, 1]], NOBODY]
    assert counted(road, after, (0, 0, 5, 0.0, 0)) == [NOBODY, NOBODY]


def test_no_vehicles_at_all(road):
    empty = Vehicles(np.zeros(0, np.int32), np.zeros(1, np.int32), np.zeros(0, np.int32))
    ways = build_ways(road, empty)
    assert counted(road, ways, *np.zeros((0, 5))) == [NOBODY, NOBODY]
