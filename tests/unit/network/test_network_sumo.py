"""The reader of SUMO networks: movements, phases, programs, right of way, remarks."""

import re
from itertools import combinations

import pytest

from dmil.controllers.tabular.agents import agents_of
from dmil.network import check_network, read_sumo_network
from tests.unit.network.conftest import ONE

NS, EW = "GGgrrrGGgrrr", "rrrGGgrrrGGg"
CLEAR_NS, CLEAR_EW = "yyyrrryyyrrr", "rrryyyrrryyy"
PROGRAM = ((30, NS), (3, CLEAR_NS), (2, "r" * 12), (20, EW), (4, CLEAR_EW))


def kinds(found):
    return [remark.kind for remark in found.remarks]


def shown(signals, phase, letters):
    """The movements one of whose links shows one of the letters."""
    state = signals.states[phase]
    return {j for j, own in enumerate(signals.links) if any(state[k] in letters for k in own)}


def test_movements_are_ordered_and_know_their_lanes(with_states):
    network = read_sumo_network(with_states(*PROGRAM)).network
    movements = network.intersections[0].movements
    assert [(m.approach, m.turn) for m in movements] == [
        (side, turn) for side in range(4) for turn in ("right", "straight", "left")
    ]
    sides = ("right0", "top0", "left0", "bottom0")
    assert [m.from_link for m in movements[::3]] == [f"{side}A0.80.00" for side in sides]
    assert [m.to_link for m in movements[1::3]] == [f"A0{sides[k]}" for k in (2, 3, 0, 1)]
    assert [m.lanes for m in movements[:3]] == [(0,), (0,), (1,)]


def test_nodes_links_and_junctions(with_states):
    network = read_sumo_network(with_states(*PROGRAM)).network
    assert network.name == "own"
    assert [node.id for node in network.intersections] == ["A0"]
    assert sorted(network.fringe) == ["bottom0", "left0", "right0", "top0"]
    # netgenerate widens the approaches 20 m before the stop line: junctions without signals.
    assert sorted(junction.id for junction in network.junctions) == [
        f"{side}0A0.80.00" for side in ("bottom", "left", "right", "top")
    ]
    link = network.links[network.link_index["right0A0"]]
    assert (link.start, link.end, link.lanes) == ("right0", "right0A0.80.00", 1)
    assert link.length_m == pytest.approx(76)
    assert link.speed_m_per_s == pytest.approx(13.89)
    assert network.position_m["A0"] == (100.0, 100.0)
    assert not any(link.id.startswith(":") for link in network.links)


def test_phases_program_and_clearance_come_from_the_stages(with_states):
    found = read_sumo_network(with_states(*PROGRAM))
    node = found.network.intersections[0]
    assert node.phases == (frozenset({3, 4, 5, 9, 10, 11}), frozenset({0, 1, 2, 6, 7, 8}))
    assert node.phase_names == ("N/S F+L+R", "E/W F+L+R")
    assert found.signals[0].states == (NS, EW)
    assert found.signals[0].links == tuple((k,) for k in (3, 4, 5, 0, 1, 2, 9, 10, 11, 6, 7, 8))
    assert node.program is not None
    assert [stage.duration_s for stage in node.program.stages] == [30, 3, 2, 20, 4]
    assert [len(stage.green) for stage in node.program.stages] == [6, 0, 0, 6, 0]
    assert node.clearance_s == 5.0
    assert found.remarks == ()


def test_yielding_left_turns_and_nobody_else(with_states):
    node = read_sumo_network(with_states(*PROGRAM)).network.intersections[0]
    # East, North, West, South; a left turn yields to what comes from the opposite side.
    assert node.gives_way == ((), (), (6, 7), (), (), (9, 10), (), (), (0, 1), (), (), (3, 4))
    assert (2, 7) in node.conflicts
    assert (1, 7) not in node.conflicts


def test_protected_left_turn_yields_to_nobody(with_states):
    stages = ((20, "GGrrrrGGrrrr"), (3, "yyrrrryyrrrr"), (9, "rrGrrrrrGrrr"), (3, "rryrrrrryrrr"))
    node = read_sumo_network(with_states(*stages, (9, EW), (3, CLEAR_EW))).network.intersections[0]
    assert node.gives_way[5] == ()
    assert node.gives_way[2] == (6, 7)


def test_gives_way_has_no_circle_where_all_yield_to_each_other(with_states):
    path = with_states((20, "g" * 12), (3, "y" * 12))
    text = path.read_text()  # everybody yields to everybody whom he meets
    path.write_text(re.sub(r'response="\d+" foes="(\d+)"', r'response="\1" foes="\1"', text))
    network = read_sumo_network(path).network
    check_network(network)
    node = network.intersections[0]
    kept = {(i, j) for i, foes in enumerate(node.gives_way) for j in foes}
    assert kept
    assert {(min(pair), max(pair)) for pair in kept} <= node.conflicts


def test_stages_that_serve_the_same_are_one_phase(with_states):
    again = NS.replace("g", "G")
    found = read_sumo_network(with_states((20, NS), (10, again), (3, CLEAR_NS), (20, EW)))
    assert found.signals[0].states == (NS, EW)


def test_right_turn_on_red_is_unsignalled(with_states):
    stages = ((20, "sGgsrrsGgsrr"), (3, "syysrrsyysrr"), (20, "srrsGgsrrsGg"), (3, "srrsyysrrsyy"))
    node = read_sumo_network(with_states(*stages)).network.intersections[0]
    assert node.unsignalled == {0, 3, 6, 9}
    assert node.phases == (frozenset({4, 5, 10, 11}), frozenset({1, 2, 7, 8}))
    assert node.gives_way[0] == (10,)


def test_left_turn_first_yielding_then_alone_keeps_its_signal(with_states):
    found = read_sumo_network(
        with_states((30, "GGgGGgGGgGGg"), (3, "yygyygyygyyg"), (6, "rrGrrGrrGrrG"))
    )
    node = found.network.intersections[0]
    assert node.unsignalled == frozenset()
    assert node.phases == (frozenset(range(12)), frozenset({2, 5, 8, 11}))


def test_movement_without_green_gets_a_phase_and_a_remark(with_states):
    blocked = NS[:2] + "r" + NS[3:]
    stages = ((20, blocked), (3, "yyrrrryyyrrr"), (20, EW), (3, CLEAR_EW))
    found = read_sumo_network(with_states(*stages))
    node, signals = found.network.intersections[0], found.signals[0]
    assert kinds(found) == ["never-served"]
    assert "from top0A0.80.00 to A0right0" in found.remarks[0].text
    assert len(node.phases) == 3
    assert 5 in node.phases[2]
    assert signals.states[2][2] == "G"
    assert not [p for p in combinations(sorted(node.phases[2]), 2) if p in node.conflicts]
    assert node.program is not None
    assert not any(5 in stage.green for stage in node.program.stages)


def test_last_program_is_the_one_of_sumo(with_states):
    more = (
        '<tlLogic id="A0" type="static" programID="a" offset="7">'
        f'<phase duration="50" state="{EW}"/><phase duration="40" state="{NS}"/></tlLogic>'
    )
    found = read_sumo_network(with_states(*PROGRAM, more=more))
    assert found.signals[0].states == (EW, NS)
    assert found.network.intersections[0].program.offset_s == 7
    assert kinds(found) == ["several-programs", "missing-yellow", "missing-yellow"]


def test_remarks_tell_what_is_suspicious_where(with_states):
    path = with_states((20, "G" * 12), (30, "r" * 12), (20, EW))
    found = read_sumo_network(path)
    assert kinds(found) == ["missing-yellow", "empty-stage", "conflicting-greens"]
    assert found.remarks[0].where == f"{path}: tlLogic A0, stage 0"
    assert "for 30 s" in found.remarks[1].text
    assert all(remark.mend for remark in found.remarks)


def test_missing_matrix_makes_roads_conflict(with_states):
    path = with_states(*PROGRAM)
    path.write_text(re.sub(r"<request [^>]*/>", "", path.read_text()))
    found = read_sumo_network(path, phases="derived")
    node = found.network.intersections[0]
    assert kinds(found) == ["no-right-of-way"]
    assert set(node.phases) == {frozenset(range(k, k + 3)) for k in (0, 3, 6, 9)}
    assert node.gives_way == ((),) * 12


def test_junction_of_two_controllers_goes_to_the_greater_one(with_states):
    path = with_states(*PROGRAM)
    other = '<tlLogic id="B" type="static" programID="0" offset="0">'
    other += '<phase duration="9" state="G"/></tlLogic>'
    text = path.read_text().replace("<tlLogic", other + "<tlLogic", 1)
    path.write_text(text.replace('tl="A0" linkIndex="0"', 'tl="B" linkIndex="0"'))
    found = read_sumo_network(path)
    assert kinds(found) == ["two-controllers", "no-vehicles"]
    assert [node.id for node in found.network.intersections] == ["A0"]
    assert found.network.intersections[0].unsignalled == {3}


def test_stages_in_another_order_and_in_rings_are_remarked(with_states, generate):
    path = with_states(*PROGRAM)
    path.write_text(
        path.read_text().replace('<phase duration="30"', '<phase next="2" duration="30"')
    )
    assert kinds(read_sumo_network(path)) == ["stage-order"]
    options = ("--grid", "--grid.number", "2", "--grid.attach-length", "100", "-j", "traffic_light")
    rings = read_sumo_network(generate(*options, "--tls.default-type", "NEMA"))
    crossings = [n for n in rings.network.intersections if len(n.movements) > 10]
    assert len(crossings) == 4
    assert all(node.program is None and len(node.phases) > 3 for node in crossings)
    assert kinds(rings).count("own-control") == 4


def test_single_action_and_none_at_all(with_states):
    single = read_sumo_network(with_states((20, NS.replace("r", "g")), (3, "y" * 12)))
    assert kinds(single) == ["single-action"]
    assert single.network.intersections[0].phases == (frozenset(range(12)),)
    none = read_sumo_network(with_states((20, "O" * 12)))
    assert kinds(none) == ["no-action"]
    assert len(none.network.intersections[0].phases) == 8


def test_actuated_program_without_durations_takes_the_middle(with_states):
    path = with_states((20, NS), (3, CLEAR_NS), (20, EW), (3, CLEAR_EW))
    text = path.read_text().replace('duration="20"', 'minDur="10" maxDur="50"')
    path.write_text(text)
    program = read_sumo_network(path).network.intersections[0].program
    assert [stage.duration_s for stage in program.stages] == [30, 3, 30, 3]


def test_pedestrians_crossings_and_bicycles_are_no_movements(generate):
    options = ("--grid", "--grid.number", "3", "--grid.attach-length", "100", "-L", "2")
    options += ("--sidewalks.guess", "--bikelanes.guess", "--crossings.guess")
    found = read_sumo_network(generate(*options, "-j", "traffic_light", "--no-turnarounds"))
    middle = next(node for node in found.network.intersections if node.id == "B1")
    assert [m.turn for m in middle.movements] == ["right", "straight", "left"] * 4
    used = {lane for m in middle.movements for lane in m.lanes}
    assert used == {2, 3}  # 0 is the sidewalk, 1 the bicycle lane
    assert {link.lanes for link in found.network.links} == {4}


def test_lights_for_pedestrians_only_are_left_out(with_states):
    path = with_states(*PROGRAM)
    logic = '<tlLogic id="lonely" type="static" programID="0" offset="0">'
    logic += '<phase duration="9" state="G"/></tlLogic>'
    path.write_text(path.read_text().replace("<tlLogic", logic + "<tlLogic", 1))
    found = read_sumo_network(path)
    assert [signals.id for signals in found.signals] == ["A0"]
    assert kinds(found) == ["no-vehicles"]


def test_stage_for_pedestrians_is_no_clearance(with_states):
    stages = [(30, NS + "r"), (3, CLEAR_NS + "r"), (25, "r" * 12 + "G"), (20, EW + "r")]
    found = read_sumo_network(with_states(*stages, (4, CLEAR_EW + "r")))
    assert kinds(found) == ["pedestrian-stage"]
    assert found.network.intersections[0].clearance_s == 4.0


def test_one_controller_over_several_junctions(generate):
    options = ("--grid", "--grid.x-number", "2", "--grid.y-number", "1", "--grid.length", "40")
    options += ("--grid.attach-length", "100", "-j", "traffic_light", "--no-turnarounds")
    path = generate(*options, "--tls.join", "--tls.join-dist", "60")
    network = read_sumo_network(path).network
    (node,) = network.intersections
    inner = {link.id for link in network.links if link.start == link.end == node.id}
    assert inner == {"A0B0", "B0A0"}
    assert {m.from_link for m in node.movements} >= inner
    assert network.position_m[node.id] == (120.0, 100.0)
    derived = read_sumo_network(path, phases="derived").network.intersections[0]
    assert frozenset().union(*derived.phases) | derived.unsignalled == set(range(24))


def test_slip_lane_without_signal_is_unsignalled(with_states):
    path = with_states(*PROGRAM)
    text, count = re.subn(r'tl="A0" linkIndex="0" ', "", path.read_text())
    assert count == 1
    path.write_text(text)
    found = read_sumo_network(path)
    assert found.network.intersections[0].unsignalled == {3}
    assert found.signals[0].links[3] == ()


def test_derived_phases_are_protected_and_symmetric(generate):
    options = ("--grid", "--grid.number", "3", "--grid.attach-length", "100", "-L", "3")
    path = generate(*options, "-j", "traffic_light", "--no-turnarounds")
    network = read_sumo_network(path, phases="derived").network
    middle = next(node for node in network.intersections if node.id == "B1")
    straight_and_left = {frozenset(p) - {0, 3, 6, 9} for p in middle.phases}
    assert straight_and_left == {
        *(frozenset({k, k + 1}) for k in (1, 4, 7, 10)),
        *(frozenset({k, k + 6}) for k in (1, 2, 4, 5)),
    }
    assert len(agents_of(network).groups[agents_of(network).shape[4]].phase_image) == 4


@pytest.mark.parametrize(
    "options",
    [
        *(("--spider", "--spider.arm-number", str(k), "-j", "traffic_light") for k in (3, 5, 6)),
        *(("--rand", "--rand.iterations", "40", "--seed", str(k), "-L", "2") for k in (1, 2)),
        ("--grid", "--grid.number", "3", "-j", "traffic_light", "--lefthand"),
        ("--grid", "--grid.number", "3", "-j", "traffic_light", "--tls.default-type", "NEMA"),
        ("--grid", "--grid.number", "3", "-j", "traffic_light_right_on_red", "--tls.join"),
    ],
    ids=lambda options: "-".join(options[0:3]).strip("-"),
)
@pytest.mark.parametrize("phases", ["program", "derived"])
def test_made_networks_read_and_serve_every_movement(generate, options, phases):
    if options[0] == "--rand":
        options += ("--tls.guess", "--tls.guess.threshold", "20", "--tls.guess.joining")
        options += ("--rand.neighbor-dist5", "10", "--rand.neighbor-dist6", "10")
    found = read_sumo_network(generate(*options), phases=phases)
    for node, signals in zip(found.network.intersections, found.signals, strict=True):
        assert len(signals.states) == len(node.phases)
        assert len({len(state) for state in signals.states}) == 1
        for index, phase in enumerate(node.phases):
            assert phase <= shown(signals, index, "GgsoO")
            if phases == "derived":
                green = shown(signals, index, "G")
                assert phase <= green
                assert not set(combinations(sorted(green), 2)) & node.conflicts
        if phases == "derived":
            assert len(node.phases) <= 16


def test_six_approaches_and_three(generate):
    options = ("--rand", "--rand.iterations", "60", "--seed", "1", "-L", "2", "--tls.guess")
    options += ("--tls.guess.threshold", "20", "--rand.neighbor-dist6", "10")
    network = read_sumo_network(generate(*options)).network
    sides = {max(m.approach for m in node.movements) + 1 for node in network.intersections}
    assert {3, 4, 6} <= sides


def test_zipped_file_is_the_same(generate):
    plain, zipped = (read_sumo_network(generate(*ONE, zipped=zip_)) for zip_ in (False, True))
    assert plain.network.intersections == zipped.network.intersections
    assert plain.network.links == zipped.network.links
