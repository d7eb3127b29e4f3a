"""Pictures of networks and intersections, and the lines that they are made of."""

from dataclasses import replace

import altair as alt
import numpy as np
import pytest

from dmil.doctor import examine, read_case
from dmil.network.geometry import LANE_M, RoadGeometry
from dmil.network.lines import (
    along,
    beginning,
    bend_into,
    beside,
    direction,
    heading,
    inside,
    length_of,
    without_end,
    without_repeats,
)
from dmil.reports import specification
from dmil.reports.intersection_chart import Crossing, intersection_chart
from dmil.reports.network_chart import MOST_LISTED, SHAPE_COLOURS, apart, network_chart
from dmil.reports.sheet import Sheet, shortened, text_width
from dmil.scenarios.names import find_resco_configuration
from tests.unit.network.conftest import generate  # noqa: F401  a fixture
from tests.unit.vega_lite import check_valid

CORNER = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0]])


# Lines


def test_beside_is_to_the_right_and_as_far_everywhere():
    moved = beside(CORNER, 2.0)
    assert moved == pytest.approx(np.array([[0, -2], [12, -2], [12, 10]]))
    assert beside(moved, -2.0) == pytest.approx(CORNER)


def test_beside_a_line_that_turns_back_stays_finite():
    assert np.isfinite(beside(np.array([[0.0, 0], [10, 0], [0, 0]]), 3.0)).all()


def test_repeated_points_are_left_out():
    doubled = np.repeat(CORNER, 2, axis=0)
    assert without_repeats(doubled) == pytest.approx(CORNER)
    assert without_repeats(CORNER, 100.0) == pytest.approx(CORNER[[0, 2]])
    assert len(without_repeats(np.zeros((3, 2)))) == 1


def test_parts_of_a_line():
    assert beginning(CORNER, 12.0) == pytest.approx(np.array([[0, 0], [10, 0], [10, 2]]))
    assert beginning(CORNER, 99.0) == pytest.approx(CORNER)
    assert length_of(without_end(CORNER, 5.0)) == pytest.approx(15.0)
    assert length_of(without_end(CORNER, 99.0)) == pytest.approx(2.0)


def test_what_lies_along_a_line():
    place, rad = along(CORNER, np.array([0.0, 4.0, 13.0, 20.0, 21.0]))
    assert place == pytest.approx(np.array([[0, 0], [4, 0], [10, 3], [10, 10], [10, 11]]))
    assert rad == pytest.approx(np.array([0, 0, 1, 1, 1]) * np.pi / 2)
    assert heading(()) == 0.0
    assert heading(((0, 0), (5, 0), (5, 100))) == pytest.approx(np.arctan2(15, 5))


def test_what_is_inside_of_a_box():
    low, high = np.array([5.0, -1.0]), np.array([11.0, 4.0])
    (part,) = inside(CORNER, low, high)
    assert part == pytest.approx(np.array([[5, 0], [10, 0], [10, 4]]))
    assert inside(CORNER + 100, low, high) == []
    zigzag = np.array([[6.0, 0], [6, 9], [9, 9], [9, 0]])
    assert len(inside(zigzag, low, high)) == 2


def test_a_bend_keeps_the_directions_at_its_ends():
    east, north = np.array([1.0, 0.0]), np.array([0.0, 1.0])
    start, goal = np.array([[-5.0, 0.0], [0.0, 0.0]]), np.array([[9.0, 9.0], [9.0, 14.0]])
    curve = bend_into(start, goal, 0.5)
    assert curve[[0, -1]] == pytest.approx(np.array([[0, 0], [9, 9]]))
    assert direction(curve, at_end=False) @ east > 0.98
    assert direction(curve, at_end=True) @ north > 0.98


# Sheet


def test_texts_are_cut_to_the_room_there_is():
    assert shortened("short", 100, 10) == "short"
    cut = shortened("a very long name of something", 60, 10)
    assert cut.endswith("…")
    assert text_width(cut, 10) <= 60
    assert text_width("mm", 10) > text_width("ii", 10)


def test_later_things_lie_above_earlier_ones():
    sheet = Sheet(100, 50)
    sheet.line(CORNER, "red", 2)
    sheet.line(CORNER, "blue", 1)  # the same look: one layer
    sheet.dot((1, 2), 3, "green", tip={"name": "x"})
    sheet.arrows([CORNER], "black", 1)
    sheet.text((1, 2), "words", bold=True)
    chart = sheet.chart(alt.TitleParams("t"))
    spec = chart.to_dict(validate=False)
    check_valid(spec)
    marks = [layer["mark"]["type"] for layer in spec["layer"]]
    assert marks == ["line", "point", "line", "line", "text"]
    assert (spec["width"], spec["height"]) == (100, 50)


# Pictures


def rows(chart):
    """All rows of all layers of a chart, which is valid."""
    spec = specification(chart)
    check_valid(spec)
    return [row for data in spec["datasets"].values() for row in data]


def texts(rows_of_chart):
    return [row["text"] for row in rows_of_chart if "text" in row]


def test_the_picture_of_a_network_names_intersections_and_shapes(mixed_network):
    case = replace(read_case(["grid:2x3"]), network=mixed_network, demand=None)
    chart = network_chart(examine(case))
    drawn = rows(chart)
    words = texts(drawn)
    for index, node in enumerate(mixed_network.intersections, start=1):
        assert {node.id, str(index)} <= set(words)
    assert {"link", "lanes", "speed"} <= {key for row in drawn for key in row}
    assert any(word.startswith("Shape A") for word in words)
    assert any(row.get("colour") == SHAPE_COLOURS[0] for row in drawn)
    assert any(word.endswith(" m") for word in words)


def test_of_many_intersections_only_the_shapes_are_listed():
    diagnosis = examine(replace(read_case(["grid:7x7"]), demand=None))
    assert len(diagnosis.intersections) > MOST_LISTED
    words = texts(rows(network_chart(diagnosis)))
    assert "Shape A (49): 12 movements, 8 phases" in words
    assert "3,3" not in words


def test_everything_stays_on_the_sheet():
    for chart in (
        network_chart(examine(read_case(["grid:1x4"]))),
        intersection_chart(examine(read_case(["grid:2x2"])), 3),
    ):
        spec = specification(chart)
        for row in rows(chart):
            assert -0.01 <= row["x"] <= spec["width"] + 0.01
            assert -0.01 <= row["y"] <= spec["height"] + 0.01


def test_marks_of_intersections_do_not_overlap():
    places = np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [3.0, 1.0], [90.0, 0.0]])
    moved = apart(places, 10.0)
    gaps = [np.hypot(*(a - b)) for k, a in enumerate(moved) for b in moved[:k]]
    assert min(gaps) > 9.5
    assert moved[-1] == pytest.approx(places[-1])


def crossing(name="grid:1x1"):
    case = read_case([name])
    return Crossing(case.network, case.network.intersections[0]), case.network.intersections[0]


def test_ways_lead_from_stop_lines_into_lanes_and_do_not_cross_for_right_turns():
    ground, item = crossing()
    for movement, (way,) in zip(item.movements, ground.ways, strict=True):
        stop = ground.stops[movement.from_link, movement.lanes[0]]
        assert way[0] == pytest.approx(stop.mean(axis=0))
        (ax, ay), (bx, by) = direction(way, at_end=False), direction(way, at_end=True)
        turned = ax * by - ay * bx
        expected = {"right": -1, "straight": 0, "left": 1}[movement.turn]
        assert turned == pytest.approx(expected, abs=0.05)


def test_lanes_lie_beside_each_other_on_the_right_of_the_road():
    ground, _ = crossing()
    # The road from the South leads to the North, so its lanes are East of the middle.
    x = [ground.stops["S0>0,0", lane].mean(axis=0)[0] for lane in range(3)]
    assert x == pytest.approx([2.5 * LANE_M, 1.5 * LANE_M, 0.5 * LANE_M])


def test_lanes_may_be_counted_from_the_left():
    network = replace(read_case(["grid:1x1"]).network, lanes_from_left=True)
    ground = Crossing(network, network.intersections[0])
    x = [ground.stops["S0>0,0", lane].mean(axis=0)[0] for lane in range(3)]
    assert x == pytest.approx([0.5 * LANE_M, 1.5 * LANE_M, 2.5 * LANE_M])


def test_left_hand_traffic_is_mirrored(generate):  # noqa: F811
    net = generate("--grid", "--grid.number", "2", "-j", "traffic_light", "--lefthand")
    assert RoadGeometry(read_case([str(net)]).network).side == -1
    assert crossing()[0].geometry.side == 1


@pytest.mark.parametrize("name", ["resco/cologne3", "resco/ingolstadt21", "resco/grid4x4"])
def test_pictures_of_real_networks(name):
    pytest.importorskip("sumolib", reason="needs the extra sumo")
    # The picture of a network does not look at its vehicles, which take longest to read.
    net = find_resco_configuration(name).with_name(f"{name.removeprefix('resco/')}.net.xml")
    diagnosis = examine(read_case([name if name == "resco/cologne3" else str(net)]))
    assert rows(network_chart(diagnosis))
    for index, item in enumerate(diagnosis.intersections[:2]):
        drawn = rows(intersection_chart(diagnosis, index))
        words = texts(drawn)
        assert [str(p) for p in range(len(item.phases))] == sorted(
            set(words) & {str(p) for p in range(len(item.phases))}
        )
        assert f"Own program (static), cycle {item.cycle_s:g} s; grey: no phase" in words
        points = np.array([[row["x"], row["y"]] for row in drawn if "x" in row])
        assert np.isfinite(points).all()


def test_lanes_lead_into_lanes_of_their_own_where_a_road_ends(generate):  # noqa: F811
    # At its end only the left lane leads on, to turn round.
    net = generate(
        *("--grid", "--grid.number", "3", "--grid.attach-length", "200", "-L", "2"), "--tls.guess"
    )
    case = read_case([str(net)])
    item = next(each for each in case.network.intersections if each.id == "C0")
    ground = Crossing(case.network, item)
    found = {
        (movement.from_link, movement.to_link): [way[-1] for way in ways]
        for movement, ways in zip(item.movements, ground.ways, strict=True)
    }
    right, left = sorted(found["B0C0", "C0right0"], key=lambda place: place[1])
    assert left[1] - right[1] == pytest.approx(LANE_M)
    assert found["bottom2C0", "C0right0"][0][1] == pytest.approx(right[1])
