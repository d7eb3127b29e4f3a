"""What controllers keep at signals, and whether that is less than the plan."""

from dataclasses import replace

import numpy as np
import pytest

from dmil.network import Program, Stage, grid
from dmil.scenarios import PLAN, SignalTiming, lost_s, signal_times, uniform_timing
from dmil.scenarios.timing import Advantage, advantages, safest_times

NOBODY = frozenset()


@pytest.fixture
def network():
    """Two intersections; the first one's plan changes from phase 0 to 1 and back."""
    made = grid(1, 2)
    first, second = made.intersections
    there, back = first.phases[:2]
    stages = (
        Stage(30, there, min_s=12, max_s=50),
        Stage(3, NOBODY, True, yellow=there),
        Stage(2, NOBODY, True),
        Stage(20, back),
        Stage(4, NOBODY, True, yellow=back),
    )
    return replace(made, intersections=(replace(first, program=Program(stages)), second))


def test_numbers_hold_for_all_and_none_is_the_plans(network):
    uniform = signal_times(SignalTiming(clearance_s=4, all_red_s=1, min_green_s=6), network)
    assert set(uniform.clearance_s.ravel()) == {4}
    assert set(uniform.all_red_s.ravel()) == {1}
    assert set(uniform.min_green_s.ravel()) == {6}
    own = signal_times(SignalTiming(**PLAN), network)
    assert own.clearance_s[0, :2, :2].tolist() == [[0, 5], [4, 0]]
    assert own.all_red_s[0, :2, :2].tolist() == [[0, 2], [0, 0]]
    assert own.min_green_s[0, :2].tolist() == [12, 5]
    assert own.max_green_s[0, :2].tolist() == [50, 0]
    # The other one has no plan: 3 s of yellow and 5 s of green.
    assert set(own.clearance_s[1][~np.eye(8, dtype=bool)].tolist()) <= {0, 3}
    assert set(own.min_green_s[1].tolist()) == {5}


def test_what_the_user_says_holds_and_the_rest_is_the_plans(network):
    def at(**given):
        times = signal_times(SignalTiming(**PLAN | given), network)
        return [int(each[0, 0, 1]) for each in times[:2]]

    assert at() == [5, 2]
    assert at(clearance_s=1) == [1, 1]
    assert at(clearance_s=8) == [8, 2]
    assert at(all_red_s=0) == [3, 0]
    assert at(clearance_s=6, all_red_s=3) == [6, 3]
    times = signal_times(SignalTiming(**PLAN | {"max_green_s": 10}), network)
    assert times.min_green_s[0, :2].tolist() == [10, 5]


def test_lost_time_is_the_mean_of_the_changes_and_the_longest_where_one_number_is_wanted(network):
    timing = SignalTiming(**PLAN, startup_lost_s=1)
    clearance_s = signal_times(timing, network).clearance_s[0]
    assert lost_s(timing, network)[0] == 1 + clearance_s.sum() / (8 * 7)
    one = uniform_timing(timing, network, 0)
    assert one == (10, 5, 12, 50, 1, False)
    assert lost_s(SignalTiming(clearance_s=3), network).tolist() == [3.0, 3.0]


def test_the_times_of_the_plan_are_no_advantage(network):
    assert advantages(SignalTiming(**PLAN), network) == []
    assert advantages(SignalTiming(clearance_s=6, all_red_s=2, min_green_s=12), network) == []


def test_less_of_anything_is_an_advantage(network):
    found = advantages(SignalTiming(decision_interval_s=5, clearance_s=3), network)
    assert found == [
        Advantage(0, "clearance", 5, 3),
        Advantage(0, "all-red", 2, 0),
        Advantage(0, "minimum green", 12, 2),
    ]
    assert str(found[0]) == "clearance 3 s, 5 s in its plan"


def test_a_green_up_to_the_next_decision_may_be_long_enough(network):
    timing = SignalTiming(decision_interval_s=20, clearance_s=5, all_red_s=2)
    assert advantages(timing, network) == []


def test_the_safest_times_fall_short_of_neither(network):
    found = safest_times(SignalTiming(clearance_s=4, min_green_s=8), network)
    assert (found.clearance_s[0, 0, 1], found.all_red_s[0, 0, 1]) == (6, 2)
    assert (found.clearance_s[0, 1, 0], found.all_red_s[0, 1, 0]) == (4, 0)
    assert found.min_green_s[0, :2].tolist() == [12, 8]
