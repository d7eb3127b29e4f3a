"""Crossings: with which phases they go, and how long pedestrians take."""

import re

import pytest

from dmil.network import read_sumo_network
from dmil.network.model import Walk
from dmil.scenarios import PLAN, SignalTiming, signal_times
from dmil.simulation.sumo.programs import Plan, stages
from dmil.simulation.sumo.signals import walk_ends

CROSSROADS = ("--grid", "--grid.number", "1", "--grid.attach-length", "200", "--no-turnarounds")
CROSSROADS += ("-j", "traffic_light", "--turn-lanes", "1", "--sidewalks.guess", "--crossings.guess")
STAGES = (
    (26, "gGgrrrgGgrrrrGrG"),
    (6, "gGgrrrgGgrrrrrrr"),
    (3, "yyyrrryyyrrrrrrr"),
    (2, "rrrrrrrrrrrrrrrr"),
    (26, "rrrgGgrrrgGgGrGr"),
    (3, "rrryyyrrryyyrrrr"),
)


@pytest.fixture
def with_crossings(generate, tmp_path):
    def write(given=STAGES):
        phases = "".join(f'<phase duration="{s}" state="{state}"/>' for s, state in given)
        logic = f'<tlLogic id="A0" type="static" programID="0" offset="0">{phases}</tlLogic>'
        path = tmp_path / "crossings.net.xml"
        text = generate(*CROSSROADS).read_text()
        path.write_text(re.sub('<tlLogic id="A0".*?</tlLogic>', logic, text, flags=re.DOTALL))
        return read_sumo_network(path)

    return write


def test_a_crossing_goes_with_its_phases_and_clears_as_in_the_plan(with_crossings):
    found = with_crossings()
    (item,) = found.network.intersections
    assert found.signals[0].crossings == (12, 13, 14, 15)
    # Those over the north and the south arm go with East and West, who then have 3 s of yellow.
    over_ns, over_ew = Walk(frozenset({1}), 5, 3), Walk(frozenset({0}), 5, 6 + 3 + 2)
    assert item.walks == (over_ns, over_ew, over_ns, over_ew)


def test_without_a_green_the_length_of_the_crossing_decides(with_crossings):
    never = [(seconds, state[:12] + "rrrr") for seconds, state in STAGES]
    (item,) = with_crossings(never).network.intersections
    # 9.6 m at 1.2 m/s.
    lengths = {walk.clear_s for walk in item.walks}
    assert lengths == {8}
    assert {walk.phases for walk in item.walks} == {frozenset()}


def test_a_protected_turn_over_the_crossing_is_who_ends_the_clearing(with_crossings):
    given = (STAGES[0], STAGES[1], (3, "yygrrryygrrrrrrr"), (8, "rrGrrrrrGrrrrrrr"), *STAGES[3:])
    (item,) = with_crossings(given).network.intersections
    # The left turn had g before, and gave way.
    assert item.walks[1].clear_s == 6 + 3


def test_no_green_is_too_short_to_walk_and_to_clear(with_crossings):
    network = with_crossings().network
    times = signal_times(SignalTiming(**PLAN), network)
    # 5 s to set out, 11 s to clear of which 5 s are yellow and all-red.
    assert times.min_green_s.tolist() == [[11, 5]]
    hasty = signal_times(SignalTiming(clearance_s=0, min_green_s=0, max_green_s=10), network)
    assert hasty.min_green_s.tolist() == [[16, 8]]
    assert hasty.max_green_s.tolist() == [[16, 10]]


def test_pedestrians_stop_setting_out_in_time(with_crossings):
    found = with_crossings()
    times = signal_times(SignalTiming(**PLAN), found.network)
    (ends,) = walk_ends(found.network, found.signals, times)
    assert ends == (((5, "gGgrrrgGgrrrrrrr"),), ((5, "rrrgGgrrrgGgrrrr"),))


def test_an_exported_plan_has_the_stages_of_the_original(with_crossings):
    found = with_crossings()
    times = signal_times(SignalTiming(**PLAN), found.network)
    (item,) = found.network.intersections
    made = stages(found.signals[0], Plan((0, 1), (32, 26)), times, item, 0)
    assert made == list(STAGES)
    shorter = stages(found.signals[0], Plan((0, 1), (11, 10)), times, item, 0)
    assert [seconds for seconds, _ in shorter] == [5, 6, 3, 2, 10, 3]
    assert [state for _, state in shorter] == [state for _, state in STAGES]


def test_the_state_of_a_phase_is_the_one_in_which_pedestrians_go(with_crossings):
    before = (5, "gGgrrrgGgrrrrrrr")
    assert with_crossings((before, *STAGES)).signals[0].states[0] == STAGES[0][1]
