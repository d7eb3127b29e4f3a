"""Who may use which lane: SUMO's rules for allow and disallow, and which lanes count as lanes."""

from pathlib import Path

import pytest

from dmil.network import read_sumo_network
from dmil.network.permissions import ALL_CLASSES, MOTOR_CLASSES, driven, permitted
from dmil.network.sumo.reader import driven_by

CASES = Path(__file__).parents[2] / "cases"
CAR, BUS, BIKE = (frozenset({name}) for name in ("passenger", "bus", "bicycle"))


@pytest.mark.parametrize(
    ("allow", "disallow", "expected"),
    [
        (None, None, ALL_CLASSES),
        ("", "", ALL_CLASSES),
        ("all", None, ALL_CLASSES),
        (None, "all", frozenset()),
        ("bus bicycle", None, BUS | BIKE),
        ("bus", "bus passenger", BUS),  # SUMO ignores disallow beside allow
        (None, "pedestrian", ALL_CLASSES - {"pedestrian"}),
        ("custom1", None, frozenset({"custom1"})),
        (None, "custom1 custom2", ALL_CLASSES - {"custom1", "custom2"}),
        ("public_transport transport", None, frozenset({"bus", "truck"})),
    ],
)
def test_permissions_follow_the_rules_of_sumo(allow, disallow, expected):
    assert permitted(allow, disallow) == expected


def test_a_lane_counts_from_a_third_of_the_vehicles_on():
    lanes = [BIKE, BUS, MOTOR_CLASSES]

    assert driven(lanes, None) == (1, 2)
    assert driven(lanes, {CAR: 10}) == (2,)
    assert driven(lanes, {CAR: 10, BUS: 4}) == (2,)
    assert driven(lanes, {CAR: 10, BUS: 5}) == (1, 2)
    assert driven(lanes, {BUS: 1}) == (1, 2)
    assert driven([BUS, CAR], {CAR: 4, BUS: 1}) == (1,)
    assert driven([BUS, frozenset({"taxi"})], {CAR: 4}) == (0, 1), "nobody drives there"
    assert driven([BIKE, MOTOR_CLASSES], {frozenset(): 1}) == (0, 1), "ignoring goes anywhere"
    assert driven([BUS, MOTOR_CLASSES], {CAR | BUS: 1}) == (1,), "a distribution: where all may go"


def test_lanes_that_the_vehicles_do_not_use_are_closed():
    roads = read_sumo_network(CASES / "bus-lane" / "bus2.net.xml")
    anybody, cars, mixed = (
        each.network
        for each in (roads, driven_by(roads, {CAR: 9.0}), driven_by(roads, {CAR: 9.0, BUS: 9.0}))
    )

    assert [link.open_lanes for link in anybody.links if link.lanes == 2] == [2, 2]
    assert [link.closed for link in cars.links if link.lanes == 2] == [{0}, {0}]
    assert [m.lanes for m in cars.intersections[0].movements[6:9]] == [(1,), (1,), (1,)]
    assert [m.lanes for m in mixed.intersections[0].movements[6:9]] == [(0, 1), (0, 1), (1,)]
    # The right turn from the car lane crosses the bus lane: it gives way to buses, not to cars.
    assert cars.intersections[0].gives_way[6] == ()
    assert mixed.intersections[0].gives_way[6] == (7,)
    assert driven_by(roads, {CAR | BUS: 1.0}).network.links == cars.links


def test_green_for_the_bus_lane_alone_is_no_phase_of_cars(tmp_path):
    text = (CASES / "bus-lane" / "bus2.net.xml").read_text()
    only_buses = '<phase duration="10" state="rrrrrrrrrrGGrrr"/>'
    path = tmp_path / "own.net.xml"
    path.write_text(text.replace("</tlLogic>", f"{only_buses}</tlLogic>"))
    roads = read_sumo_network(path)

    assert len(roads.network.intersections[0].phases) == 3
    cars = driven_by(roads, {CAR: 1.0})
    assert len(cars.network.intersections[0].phases) == 2
    assert cars.network.intersections[0].program.stages[-1].green == frozenset()
    assert cars.signals[0].links[6:9] == ((12,), (13,), (14,))


def test_where_permissions_make_no_difference_the_network_is_the_same(generate):
    roads = read_sumo_network(
        generate("--grid", "--grid.number", "1", "--grid.attach-length", "100", "--sidewalks.guess",
                 "-j", "traffic_light")
    )  # fmt: skip

    assert driven_by(roads, {CAR: 1.0, BUS: 1.0}) is roads
    assert all(link.lanes == 2 and link.closed == {0} for link in roads.network.links)
