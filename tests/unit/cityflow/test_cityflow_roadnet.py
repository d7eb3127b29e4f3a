"""Reading CityFlow's road networks."""

import json

import pytest

from dmil.errors import NetworkError
from dmil.network import exit_sides, grid, read_cityflow_roadnet, shape_signature


@pytest.fixture
def read(write):
    return lambda document: read_cityflow_roadnet(write(document))


def stages(node):
    """The stages of a program that show a phase, as (phase, duration)."""
    green = [stage for stage in node.program.stages if stage.green]
    return [(node.phases.index(stage.green), stage.duration_s) for stage in green]


def test_a_crossing_becomes_the_papers_intersection(crossing, read):
    network = read(crossing()[0])
    (node,) = network.intersections
    assert network.name == "roadnet"
    assert network.fringe == ("E", "N", "W", "S")
    turns = ("right", "straight", "left")
    assert [(m.approach, m.turn) for m in node.movements] == [
        (side, turn) for side in range(4) for turn in turns
    ]
    assert [m.from_link for m in node.movements[::3]] == ["E_in", "N_in", "W_in", "S_in"]
    assert [m.lanes for m in node.movements] == [(2,), (1,), (0,)] * 4
    assert exit_sides(network, node) == exit_sides(grid(1, 1), grid(1, 1).intersections[0])
    # The file's order of phases, the clearance phase left out.
    assert node.phase_names == ("E/W F", "N/S F", "E/W L", "N/S L")
    assert node.phases == ({1, 7}, {4, 10}, {2, 8}, {5, 11})
    assert node.unsignalled == {0, 3, 6, 9}
    assert stages(node) == [(0, 20.0), (1, 20.0), (2, 20.0), (3, 20.0)]
    assert (node.clearance_s, network.clearance_s) == (3.0, 3.0)


def test_links_have_the_length_of_their_points_and_the_speed_of_their_fastest_lane(crossing, read):
    document, _ = crossing()
    road = document["roads"][0]
    road["points"] = [{"x": 200, "y": 0}, {"x": 30, "y": 0}, {"x": 0, "y": 40}, {"x": 0, "y": 0}]
    road["lanes"] = [{"maxSpeed": 5}, {"maxSpeed": 20}, {"maxSpeed": 10}]
    network = read(document)
    link = network.links[0]
    assert (link.id, link.start, link.end) == ("E_in", "E", "c")
    assert link.length_m == pytest.approx(170 + 50 + 40)
    assert (link.speed_m_per_s, link.lanes) == (20.0, 3)
    assert link.free_flow_time_s == pytest.approx(13.0)


def test_a_three_way_junction_has_its_own_shape(crossing, read):
    network = read(crossing("ENW")[0])
    (node,) = network.intersections
    assert [(m.approach, m.turn) for m in node.movements] == [
        (0, "right"),
        (0, "straight"),
        (1, "right"),
        (1, "left"),
        (2, "straight"),
        (2, "left"),
    ]
    assert exit_sides(network, node) == (1, 2, 2, 0, 0, 1)
    assert node.phase_names == ("E/W F", "W L", "N L")
    assert node.unsignalled == {0, 2}
    assert shape_signature(node) != shape_signature(grid(1, 1).intersections[0])


def test_without_an_eastern_arm_the_first_approach_is_the_northern(crossing, read):
    (node,) = read(crossing("NWS")[0]).intersections
    assert [m.from_link for m in node.movements] == [
        *["N_in"] * 2,
        *["W_in"] * 2,
        *["S_in"] * 2,
    ]
    assert [m.approach for m in node.movements] == [0, 0, 1, 1, 2, 2]


def test_the_side_is_that_of_the_last_piece_of_road(crossing, read):
    document, _ = crossing("ENW")
    # The eastern road bends and arrives from the South.
    document["roads"][0]["points"] = [
        {"x": 200, "y": 0},
        {"x": 0, "y": -50},
        {"x": 0, "y": 0},
        {"x": 0, "y": 0},
    ]
    (node,) = read(document).intersections
    assert [m.from_link for m in node.movements[::2]] == ["N_in", "W_in", "E_in"]


def test_a_road_without_length_takes_no_time_and_counts_as_eastern(crossing, read):
    document, _ = crossing("NWS")
    document["roads"][2]["points"] = [{"x": 0, "y": 0}] * 2
    network = read(document)
    assert network.links[2].free_flow_time_s == 0.0
    assert network.intersections[0].movements[0].from_link == "W_in"


def test_movements_may_share_lanes(crossing, read):
    document, links = crossing()
    road_links = document["intersections"][0]["roadLinks"]
    # From the East: left on lane 0, straight on lanes 0, 1 and 2, right on lane 2.
    straight = road_links[links.index(("E", "go_straight"))]
    straight["laneLinks"] = [{"startLaneIndex": k, "endLaneIndex": 0} for k in (0, 1, 2, 2)]
    (node,) = read(document).intersections
    assert [m.lanes for m in node.movements[:3]] == [(2,), (0, 1, 2), (0,)]


def test_u_turns_come_last(crossing, read):
    document, links = crossing()
    node = document["intersections"][0]
    node["roadLinks"].append(
        {
            "type": "turn_u",
            "startRoad": "E_in",
            "endRoad": "E_out",
            "laneLinks": [{"startLaneIndex": 0, "endLaneIndex": 0}],
        }
    )
    node["trafficLight"]["lightphases"][1]["availableRoadLinks"].append(len(links))
    (node,) = read(document).intersections
    assert [m.turn for m in node.movements[:4]] == ["right", "straight", "left", "uturn"]
    assert node.phases[0] == {1, 3, 8}
    assert node.phase_names[0] == "E F+U, W F"


def test_of_two_exits_of_one_turn_the_one_further_right_comes_first(crossing, read):
    document, links = crossing("ENW")
    document["roads"].append(
        {
            "id": "NE_out",
            "points": [{"x": 0, "y": 0}, {"x": 50, "y": 90}],
            "lanes": [{"maxSpeed": 10}],
            "startIntersection": "c",
            "endIntersection": "N",
        }
    )
    node = document["intersections"][0]
    node["roadLinks"].append(
        {**node["roadLinks"][links.index(("E", "turn_right"))], "endRoad": "NE_out"}
    )
    for phase in node["trafficLight"]["lightphases"]:
        phase["availableRoadLinks"].append(len(links))
    (made,) = read(document).intersections
    assert [m.to_link for m in made.movements[:3]] == ["NE_out", "N_out", "W_out"]
    assert [m.lanes for m in made.movements[:2]] == [(2,), (2,)]


@pytest.mark.parametrize("light", ["absent", "null", "no phases"])
def test_a_junction_without_signals_has_one_phase_of_everything(crossing, read, light):
    document, _ = crossing("ENW")
    node = document["intersections"][0]
    if light == "absent":
        del node["trafficLight"]
    else:
        node["trafficLight"] = None if light == "null" else {"lightphases": []}
    (node,) = read(document).intersections
    assert node.phases == (frozenset(range(6)),)
    assert node.unsignalled == frozenset()
    assert node.program is None
    assert node.clearance_s == 0.0


def test_a_light_of_one_phase_serves_everything_in_it(crossing, read):
    document, links = crossing()
    everything = {"time": 30, "availableRoadLinks": list(range(len(links)))}
    document["intersections"][0]["trafficLight"]["lightphases"] = [everything]
    (node,) = read(document).intersections
    assert node.phases == (frozenset(range(12)),)
    assert stages(node) == [(0, 30.0)]
    assert (node.unsignalled, node.clearance_s) == (frozenset(), 0.0)


def test_an_all_red_phase_is_the_clearance(crossing, read):
    document, _ = crossing()
    phases = document["intersections"][0]["trafficLight"]["lightphases"]
    phases[0] = {"time": 4, "availableRoadLinks": []}
    (node,) = read(document).intersections
    assert node.clearance_s == 4.0
    # Right turns are in every phase but that one: they wait for it like all others.
    assert node.unsignalled == frozenset()
    assert node.phases[0] == {0, 1, 3, 6, 7, 9}


def test_a_phase_that_comes_twice_is_one_action_shown_twice(crossing, read):
    document, _ = crossing()
    phases = document["intersections"][0]["trafficLight"]["lightphases"]
    phases[2:2] = [phases[0]]
    phases.append({**phases[1], "time": 7})
    phases.append({**phases[3], "time": 0})
    (node,) = read(document).intersections
    assert len(node.phases) == 4
    assert stages(node) == [(0, 20.0), (1, 20.0), (2, 20.0), (3, 20.0), (0, 7.0)]


def test_links_of_a_virtual_node_are_ignored_as_cityflow_does(crossing, read):
    document, _ = crossing()
    document["intersections"][1]["roadLinks"] = [
        {**document["intersections"][0]["roadLinks"][0], "startRoad": "E_out", "endRoad": "E_in"}
    ]
    assert "E" in read(document).fringe


def test_a_node_without_road_links_is_fringe(crossing, read):
    document, _ = crossing()
    document["intersections"][1]["virtual"] = False
    assert read(document).fringe == ("E", "N", "W", "S")


def at(document, *path):
    for key in path[:-1]:
        document = document[key]
    return document, path[-1]


C = ("intersections", 0)
PHASES = (*C, "trafficLight", "lightphases")


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        (
            ("roads", 3, "lanes", 0, "maxSpeed"),
            "fast",
            r"roads\[3\]\.lanes\[0\]\.maxSpeed: .*'fast'",
        ),
        (("roads", 3, "lanes", 0, "maxSpeed"), 0, r"maxSpeed: .*greater than 0, but it is 0"),
        (("roads", 3, "lanes", 0, "maxSpeed"), float("nan"), "maxSpeed: .*finite number"),
        (("roads", 3, "lanes"), [], r"roads\[3\]\.lanes: .*at least 1 item"),
        (("roads", 3, "points"), [{"x": 0, "y": 0}], r"roads\[3\]\.points: .*at least 2 items"),
        (("roads", 3, "points", 0, "x"), None, r"roads\[3\]\.points\[0\]\.x: .*but it is None"),
        (("roads",), {}, "roads: input should be a valid list"),
        (("roads", 1, "startIntersection"), "q", "link E_out: it starts at 'q'"),
        ((*C, "roadLinks", 2, "type"), "turn_back", r"roadLinks\[2\]\.type: .*'turn_back'"),
        ((*C, "roadLinks", 2, "startRoad"), "q", r"\[0\]\.roadLinks\[2\]\.startRoad: there is no"),
        ((*C, "roadLinks", 2, "endRoad"), "q", r"\[0\]\.roadLinks\[2\]\.endRoad: there is no"),
        ((*C, "roadLinks", 2, "startRoad"), "E_out", "comes from link E_out, which ends at 'E'"),
        ((*C, "roadLinks", 2, "endRoad"), "E_in", "goes to link E_in, which starts at 'E'"),
        ((*C, "roadLinks", 2, "laneLinks"), [], r"roadLinks\[2\]\.laneLinks: .*at least 1 item"),
        (
            (*C, "roadLinks", 2, "laneLinks", 0, "startLaneIndex"),
            3,
            r"laneLinks: it starts on lane 3 of road N_in; expected a lane from 0 to 2",
        ),
        ((*PHASES, 1, "availableRoadLinks"), [99], r"lightphases\[1\].*there is no road link 99"),
        ((*PHASES, 1, "time"), -1, r"lightphases\[1\]\.time: .*greater than or equal to 0"),
        (PHASES, [{"time": 3, "availableRoadLinks": []}] * 2, "no phase of its light serves"),
        ((*PHASES, 1, "availableRoadLinks"), [0], "served by no phase"),
        (("intersections", 1, "id"), "N", "2 nodes are named 'N'"),
        (("intersections",), [], "there is no intersection; expected at least one"),
        ((*C, "point"), {"x": 0}, r"intersections\[0\]\.point\.y: this field is missing"),
        ((*C, "id"), 5, r"intersections\[0\]\.id: .*valid string, but it is 5"),
    ],
)
def test_a_wrong_place_is_named(crossing, write, path, value, message):
    document = json.loads(json.dumps(crossing()[0]))
    parent, key = at(document, *path)
    parent[key] = value
    file = write(document)
    with pytest.raises(NetworkError, match=message) as caught:
        read_cityflow_roadnet(file)
    assert str(caught.value).startswith(str(file))


def test_a_road_that_comes_twice_is_named(crossing, read):
    document, _ = crossing()
    document["roads"].append(document["roads"][0])
    with pytest.raises(NetworkError, match=r"2 links are named 'E_in'.*Rename all but one link"):
        read(document)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "the file is empty"),
        (b" \n", "the file is empty"),
        (b'{"intersections": [], "ro', "line 1, column 23: the file is cut off in the middle"),
        (b'{"intersections": [', "the file is cut off in the middle"),
        (b'{"intersections": ]}', r"line 1, column 19: this is not JSON \(Expecting value\)"),
        (b"<net></net>", "line 1, column 1: this is not JSON"),
        (b"\xff\xfe\x00", "not a text file in UTF-8"),
        (b"[1, 2]", "expected a CityFlow road network"),
        (b"{}", r"intersections: this field is missing \(the first of 2 problems\)"),
        (b"[" * 100_000, "not usable JSON|cut off"),
    ],
)
def test_a_file_that_is_no_network_is_refused(tmp_path, content, message):
    path = tmp_path / "net.json"
    path.write_bytes(content)
    with pytest.raises(NetworkError, match=message) as caught:
        read_cityflow_roadnet(path)
    assert str(caught.value).startswith(str(path))


def test_a_missing_file_and_a_folder_are_refused(tmp_path):
    with pytest.raises(NetworkError, match="there is no such file"):
        read_cityflow_roadnet(tmp_path / "none.json")
    with pytest.raises(NetworkError, match="it cannot be read"):
        read_cityflow_roadnet(tmp_path)


@pytest.mark.data
@pytest.mark.parametrize(
    ("name", "intersections", "fringe"),
    [("jinan_3x4/roadnet_3_4.json", 12, 14), ("hangzhou_4x4/roadnet_4_4.json", 16, 16)],
)
def test_recorded_networks_have_the_papers_intersection(data, name, intersections, fringe):
    network = read_cityflow_roadnet(data / name)
    assert len(network.intersections) == intersections
    assert len(network.fringe) == fringe
    assert network.clearance_s == 5.0
    assert len({shape_signature(node) for node in network.intersections}) == 1
    paper = grid(1, 1).intersections[0]
    for node in network.intersections:
        assert len(node.phases) == 8
        assert set(node.phases) == set(paper.phases)
        assert node.unsignalled == paper.unsignalled
        assert [(m.approach, m.turn) for m in node.movements] == [
            (m.approach, m.turn) for m in paper.movements
        ]
        assert exit_sides(network, node) == exit_sides(grid(1, 1), paper)
        names = dict(zip(paper.phases, paper.phase_names, strict=True))
        assert [names[phase] for phase in node.phases] == list(node.phase_names)
        assert stages(node) == [(phase, 30.0) for phase in range(8)]
