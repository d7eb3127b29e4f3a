"""Which phases of a CityFlow light are actions, and who gives way."""

import pytest

from dmil.controllers import make_controller
from dmil.network import read_cityflow_roadnet
from dmil.rewards import make_reward
from dmil.scenarios import cityflow_scenario
from dmil.simulation import QueueSimulator
from dmil.training import evaluate, vehicles_of_seed

RIGHTS = "ER NR WR SR"


@pytest.fixture
def read(crossing, write):
    """Return a function that reads a crossing whose light has given phases.

    Right turns may go in all of them, unless the phases name them.
    """

    def read_phases(phases):
        named = any(way.endswith("R") for ways, _ in phases for way in ways.split())
        document, links = crossing()
        number = {link: index for index, link in enumerate(links)}
        turns = {"R": "turn_right", "F": "go_straight", "L": "turn_left"}
        document["intersections"][0]["trafficLight"]["lightphases"] = [
            {
                "time": time_s,
                "availableRoadLinks": [
                    number[way[0], turns[way[1]]]
                    for way in f"{ways} {'' if named else RIGHTS}".split()
                ],
            }
            for ways, time_s in phases
        ]
        (node,) = read_cityflow_roadnet(write(document)).intersections
        return node

    return read_phases


EIGHT = ["EF WF", "NF SF", "EL WL", "NL SL", "EF EL", "WF WL", "NF NL", "SF SL"]


def cleared(yellow):
    """Eight greens, each with a yellow of its own."""
    return [stage for green in EIGHT for stage in ((f"{green} {RIGHTS}", 30), (yellow(green), 3))]


@pytest.mark.parametrize(
    "yellow",
    [
        lambda green: green,  # right turns stop
        lambda green: f"{green.split()[0]} {RIGHTS}",  # one of the two goes on
        lambda green: RIGHTS,
        lambda green: "",
        lambda green: f"{green.split()[1]} ER",
    ],
)
def test_a_yellow_of_its_own_after_every_green_is_no_action(read, yellow):
    node = read(cleared(yellow))
    assert len(node.phases) == 8
    assert node.clearance_s == 3.0
    assert [stage.clearance for stage in node.program.stages] == [False, True] * 8
    assert node.program.cycle_s == 8 * 33


def test_yellow_and_all_red_are_one_clearance(read):
    node = read([("EF WF", 30), ("EF", 3), ("", 2), ("NF SF EL WL NL SL", 25), ("", 4)])
    assert [sorted(phase) for phase in node.phases] == [[1, 7], [2, 4, 5, 8, 10, 11]]
    assert node.unsignalled == {0, 3, 6, 9}
    assert node.clearance_s == 5.0


def test_who_begins_early_does_so_in_a_clearance(read):
    node = read([("EF WF", 30), ("EF EL", 4), ("EF EL", 20), ("NF SF WL NL SL", 25), ("", 3)])
    assert len(node.phases) == 3
    node = read([("EF WF", 30), ("EF EL", 4), ("EL WL", 20), ("NF SF NL SL", 25), ("", 3)])
    assert len(node.phases) == 3
    assert node.clearance_s == 4.0


@pytest.mark.parametrize(
    "phases",
    [
        # Short, but it serves somebody who has green in no phase beside it.
        [("EF WF", 30), ("EL WL", 5), ("NF SF NL SL", 30)],
        # As short as all others.
        [("EF WF", 5), ("EF EL WL", 5), ("NF SF EL NL SL", 5)],
        # Longer than any yellow.
        [("EF WF", 30), ("EF", 10), ("NF SF EL WL NL SL", 30)],
        # Not part of the plan, but offered.
        [("EF WF", 30), ("EF", 0), ("NF SF EL WL NL SL", 30)],
    ],
)
def test_what_is_no_yellow_stays_an_action(read, phases):
    assert len(read(phases).phases) == 3


def test_a_long_phase_for_those_who_always_may_go_is_no_clearance(read):
    greens = [(f"{green} {RIGHTS}", 30) for green in EIGHT[:4]]
    node = read([(RIGHTS, 5), *greens, (RIGHTS, 40)])
    assert node.clearance_s == 5.0
    # It is a phase of its own, so they have their signal.
    assert node.unsignalled == frozenset()
    assert len(node.phases) == 5
    assert node.phases[-1] == {0, 3, 6, 9}
    assert [stage.clearance for stage in node.program.stages] == [True, *[False] * 5]


def test_a_long_time_in_which_nobody_goes_is_neither_action_nor_clearance(read):
    greens = [(green, 30) for green in EIGHT[:4]]
    node = read([*greens, ("", 3), (RIGHTS, 20), ("", 25)])
    assert len(node.phases) == 5
    assert node.clearance_s == 3.0


def test_a_left_turn_yields_to_opposite_traffic_that_has_green_with_it(read):
    protected = read([("EF WF", 30), ("EL WL", 30), ("NF SF", 30), ("NL SL", 30), ("", 3)])
    assert protected.gives_way == ()
    node = read([("EF WF EL WL", 30), ("NF SF", 30), ("NL SL", 30)])
    # Movements by side E, N, W, S: right, straight, left. Lefts from N and S are protected.
    assert {j: foes for j, foes in enumerate(node.gives_way) if foes} == {2: (7,), 8: (1,)}


def test_without_signals_turns_give_way_to_all_whom_they_cross(crossing, write):
    document, _ = crossing()
    del document["intersections"][0]["trafficLight"]
    (node,) = read_cityflow_roadnet(write(document)).intersections
    lefts = {j: set(foes) for j, foes in enumerate(node.gives_way) if foes}
    # The left turn from E crosses straight on from W and S and merges with that from N.
    assert set(lefts) == {2, 5, 8, 11}
    assert lefts[2] == {4, 7, 10}


def test_a_lane_link_drawn_in_the_file_is_where_it_is_drawn(crossing, write):
    document, links = crossing()
    del document["intersections"][0]["trafficLight"]
    east_left = document["intersections"][0]["roadLinks"][links.index(("E", "turn_left"))]
    for lane_link in east_left["laneLinks"]:
        lane_link["points"] = [{"x": 500, "y": 500}, {"x": 600, "y": 600}]
    (node,) = read_cityflow_roadnet(write(document)).intersections
    assert node.gives_way[2] == ()
    assert node.gives_way[5]


def test_left_turns_wait_for_opposite_traffic_in_the_queue_simulator(crossing, write):
    document, links = crossing()
    light = document["intersections"][0]["trafficLight"]
    everyone = [k for k, (arm, _) in enumerate(links) if arm in "EW"]
    others = [k for k in range(len(links)) if k not in everyone]
    light["lightphases"] = [
        {"time": 40, "availableRoadLinks": everyone},
        {"time": 5, "availableRoadLinks": []},
        {"time": 20, "availableRoadLinks": others},
        {"time": 5, "availableRoadLinks": []},
    ]
    roadnet = write(document)

    def wait_s(opposite_every_s):
        flows = [
            {"route": ["E_in", "S_out"], "interval": 10, "startTime": 0, "endTime": 890},
            {
                "route": ["W_in", "E_out"],
                "interval": opposite_every_s,
                "startTime": 0,
                "endTime": 890,
            },
        ]
        made = cityflow_scenario(roadnet, write(flows, "flow.json"), horizon_s=900)
        simulator = QueueSimulator(made)
        run = evaluate(
            simulator,
            make_controller("program"),
            vehicles_of_seed(made, 0),
            make_reward("queue"),
            0,
        )
        return run.measures.wait_per_spawned_s * run.measures.spawned_veh

    assert wait_s(2.5) > wait_s(900) + 500
