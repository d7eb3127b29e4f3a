"""The shortest way between anchor points, as CityFlow's router finds it."""

from pathlib import Path

import pytest

from dmil.demand import read_cityflow_flow
from dmil.demand.cityflow import AnchorRouter
from dmil.errors import DemandError
from dmil.network import grid, read_cityflow_roadnet
from dmil.scenarios import cityflow_scenario
from dmil.seeding import stream

CASE = Path(__file__).parents[2] / "cases" / "cityflow-anchors"


@pytest.mark.parametrize("name", ["flow.json", "flow_two_anchors.json"])
def test_any_number_of_anchors_is_joined(name):
    made = cityflow_scenario(CASE / "roadnet.json", CASE / name, horizon_s=900)
    vehicles = made.demand.vehicles(made.network, 900, stream(0))
    assert len(vehicles) == 60
    for vehicle in range(60):
        way = [made.network.links[k].id for k in vehicles.route(vehicle)]
        assert way == ["r0", "r1", "r2", "r3", "r4"]


def ladder(upper, lower, *, width=0, roads=("in", "up", "down", "up2", "down2", "out")):
    """Two ways from ``in`` to ``out``: over node ``u`` and over node ``v``, of given lengths."""
    places = {"a": (-50, 0), "s": (0, 0), "u": (0, 1), "v": (0, -1), "t": (9, 0), "b": (99, 0)}
    points = {node: {"x": x, "y": y} for node, (x, y) in places.items()}

    def road(name, start, end, length):
        half = {"x": points[start]["x"] + length / 2, "y": 0.0}
        far = {"x": points[start]["x"] + length, "y": 0.0}
        return {
            "id": name,
            "startIntersection": start,
            "endIntersection": end,
            "points": [{"x": points[start]["x"], "y": 0.0}, half, far],
            "lanes": [{"width": 4, "maxSpeed": 10}],
        }

    def node(name, mine, links):
        return {
            "id": name,
            "point": points[name],
            "width": width if name == "u" else 0,
            "roads": list(mine),
            "virtual": not links,
            "roadLinks": [
                {
                    "type": "go_straight",
                    "startRoad": start,
                    "endRoad": end,
                    "laneLinks": [{"startLaneIndex": 0, "endLaneIndex": 0}],
                }
                for start, end in links
            ],
        }

    return {
        "roads": [
            road("in", "a", "s", 50),
            road("up", "s", "u", upper[0]),
            road("up2", "u", "t", upper[1]),
            road("down", "s", "v", lower[0]),
            road("down2", "v", "t", lower[1]),
            road("out", "t", "b", 90),
        ],
        "intersections": [
            node("a", ["in"], []),
            node(
                "s", [r for r in roads if r in ("in", "up", "down")], [("in", "up"), ("in", "down")]
            ),
            node("u", ["up", "up2"], [("up", "up2")]),
            node("v", ["down", "down2"], [("down", "down2")]),
            node(
                "t",
                [r for r in roads if r in ("up2", "down2", "out")],
                [("up2", "out"), ("down2", "out")],
            ),
            node("b", ["out"], []),
        ],
    }


def way(write, document):
    network = read_cityflow_roadnet(write(document))
    router = AnchorRouter(network)
    found = router.way([network.link_index["in"], network.link_index["out"]])
    return [network.links[k].id for k in found][1:-1]


def test_the_shorter_way_is_taken_and_not_the_faster_one(write):
    assert way(write, ladder((100, 100), (90, 100))) == ["down", "down2"]
    fast = ladder((100, 100), (90, 100))
    for road in fast["roads"]:
        if road["id"].startswith("up"):
            road["lanes"][0]["maxSpeed"] = 30
    assert way(write, fast) == ["down", "down2"]


def test_roads_end_where_junctions_begin(write):
    # Node u takes 8 m from both roads that it joins.
    assert way(write, ladder((100, 100), (95, 95), width=8)) == ["up", "up2"]


@pytest.mark.parametrize(
    ("lower", "first", "expected"),
    [
        # Equally long, in equal halves: the road that the junction lists first is found first.
        ((100, 100), "up", ["up", "up2"]),
        ((100, 100), "down", ["down", "down2"]),
        # Equally long in all, but its first half is nearer and its end therefore found first.
        ((80, 120), "up", ["down", "down2"]),
        ((120, 80), "down", ["up", "up2"]),
    ],
)
def test_of_two_ways_equally_long_the_one_found_first_is_taken(write, lower, first, expected):
    roads = ["in", "up", "down"] if first == "up" else ["in", "down", "up"]
    document = ladder((100, 100), lower, roads=(*roads, "up2", "down2", "out"))
    assert way(write, document) == expected


def test_a_way_may_come_back_over_a_u_turn(crossing, write):
    document, links = crossing()
    turn = {
        "type": "turn_u",
        "startRoad": "E_in",
        "endRoad": "E_out",
        "laneLinks": [{"startLaneIndex": 0, "endLaneIndex": 0}],
    }
    entry = {"route": ["E_in", "E_out"], "interval": 1, "startTime": 0, "endTime": 0}
    flow = write([entry], "flow.json")
    network = read_cityflow_roadnet(write(document))
    assert [each.kind for each in read_cityflow_flow(flow, network).remarks] == ["no-way"]
    document["intersections"][0]["roadLinks"].append(turn)
    document["intersections"][0]["trafficLight"]["lightphases"][1]["availableRoadLinks"].append(
        len(links)
    )
    network = read_cityflow_roadnet(write(document))
    assert len(read_cityflow_flow(flow, network).recorded) == 1


def test_a_junction_joins_only_the_roads_that_it_lists(write):
    document = ladder((10, 10), (90, 90), roads=("in", "down", "up2", "down2", "out"))
    assert way(write, document) == ["down", "down2"]


def test_networks_of_other_formats_have_ways_by_length_too():
    network = grid(1, 2)
    start = next(k for k in network.entry_links if network.links[k].id.startswith("W"))
    end = next(k for k in network.exit_links if network.links[k].end.startswith("E"))
    found = AnchorRouter(network).way([start, end])
    assert found[0] == start
    assert found[-1] == end
    assert len(found) == 3


def test_an_anchor_that_is_no_road_is_an_error(write):
    network = read_cityflow_roadnet(write(ladder((10, 10), (20, 20))))
    entry = {"route": ["in", "nowhere"], "interval": 1, "startTime": 0, "endTime": 0}
    with pytest.raises(DemandError, match="its route is over 'nowhere'"):
        read_cityflow_flow(write([entry], "flow.json"), network)
