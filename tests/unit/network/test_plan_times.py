"""What plans say of clearance and greens, change by change."""

import re
from dataclasses import replace

import numpy as np
import pytest

from dmil.network import Program, Stage, grid, plan_times, read_sumo_network
from dmil.network.plan_times import stops_all

NS, EW, LEFT = "GGrrrrGGrrrr", "rrrGGGrrrGGG", "rrGrrrrrGrrr"


def times_of(path):
    return plan_times(read_sumo_network(path).network.intersections[0])


@pytest.fixture
def stages():
    """A function that writes stages as they stand in a file: seconds, state, limits."""

    def write(*given):
        return "".join(
            f'<phase duration="{seconds}" state="{state}" {limits}/>'
            for seconds, state, limits in ((*each, "")[:3] for each in given)
        )

    return write


@pytest.fixture
def written(with_states, stages, tmp_path):
    """A function that puts such stages into a network."""

    def write(*given, kind="static"):
        path = with_states((30, NS))
        text = re.sub("<phase .*?/>", stages(*given), path.read_text())
        path.write_text(text.replace('type="static"', f'type="{kind}"'))
        return path

    return write


def test_each_change_has_the_yellow_and_all_red_that_the_plan_gives_it(written):
    found = times_of(
        written(
            (30, NS),
            (3, "yyrrrryyrrrr"),
            (2, "r" * 12),
            (20, EW),
            (4, "rrryyyrrryyy"),
            (10, LEFT),
            (3, "rryrrrrryrrr"),
            (1, "r" * 12),
        )
    )
    # From North and South to the left turns the plan never changes: their longest clearance.
    assert found.yellow_s.tolist() == [[0, 3, 3], [4, 0, 4], [3, 3, 0]]
    assert found.all_red_s.tolist() == [[0, 2, 2], [0, 0, 0], [1, 1, 0]]
    assert found.min_green_s.tolist() == [5, 5, 5]
    assert found.max_green_s.tolist() == [0, 0, 0]


def test_fractions_count_as_whole_seconds(written):
    found = times_of(written((30, NS), (2.5, "yyrrrryyrrrr"), (1.2, "r" * 12), (20, EW)))
    assert found.yellow_s[0, 1] == 3
    assert found.all_red_s[0, 1] == 1
    assert found.yellow_s[0, 1] + found.all_red_s[0, 1] >= 2.5 + 1.2


def test_a_green_that_turns_red_at_once_is_no_example(written):
    found = times_of(written((30, NS), (4, "yyrrrryyrrrr"), (20, EW), (10, LEFT)))
    assert found.yellow_s.tolist() == [[0, 4, 4], [4, 0, 4], [4, 4, 0]]


def test_a_plan_that_clears_nobody_is_given_the_usual_yellow(written):
    found = times_of(written((30, NS), (20, EW), (10, LEFT)))
    assert found.yellow_s.tolist() == [[0, 3, 3], [3, 0, 3], [3, 3, 0]]


def test_who_loses_nothing_needs_no_clearance(written):
    both = "GGGrrrGGGrrr"
    found = times_of(written((10, LEFT), (20, both), (3, "yyyrrryyyrrr"), (20, EW)))
    assert (found.yellow_s[0, 1], found.yellow_s[1, 2]) == (0, 3)


def test_what_clears_pedestrians_clears_no_vehicles(written):
    walk = "rrrrrrrrrrrrG"
    given = ((30, NS + "r"), (3, "yyrrrryyrrrrr"), (1, "r" * 13), (12, walk), (9, "r" * 13))
    found = times_of(written(*given, (20, EW + "r"), (3, "rrryyyrrryyyr")))
    assert (found.yellow_s[0, 1], found.all_red_s[0, 1]) == (3, 1)


@pytest.mark.parametrize(
    ("kind", "stage", "least_s", "longest_s"),
    [
        ("static", (30, NS), 5, 0),
        ("static", (4, NS), 4, 0),
        ("actuated", (30, NS, 'minDur="8" maxDur="45"'), 8, 45),
        ("actuated", (30, NS), 30, 0),
        ("actuated", (30, NS, 'minDur="8" maxDur="2147483"'), 8, 0),
        ("static", (30, NS, 'minDur="8"'), 8, 0),
    ],
)
def test_greens_are_as_short_and_long_as_the_file_allows(written, kind, stage, least_s, longest_s):
    found = times_of(written(stage, (3, "yyrrrryyrrrr"), (20, EW), kind=kind))
    assert (found.min_green_s[0], found.max_green_s[0]) == (least_s, longest_s)


def test_a_phase_of_two_stages_has_the_limits_of_both(written):
    first, second = 'minDur="6" maxDur="20"', 'minDur="4" maxDur="10"'
    found = times_of(written((10, NS, first), (9, NS, second), (20, EW), kind="actuated"))
    assert (found.min_green_s[0], found.max_green_s[0]) == (10, 30)


def test_a_file_that_does_not_tell_yellow_from_red_has_yellow():
    item = grid(1, 1).intersections[0]
    stages = (Stage(20, item.phases[0]), Stage(5, frozenset(), True), Stage(20, item.phases[1]))
    found = plan_times(replace(item, program=Program(stages)))
    changes = ~np.eye(len(item.phases), dtype=bool)
    assert found.yellow_s[0, 1] == 5
    assert set(found.yellow_s[changes].tolist()) <= {0, 5}
    assert not found.all_red_s.any()


OVERLAP = "GGGrrrGGGrrr"
"""As NS, the left turns besides."""


@pytest.mark.parametrize(
    ("between", "stops"),
    [
        ("GGyrrrGGyrrr", False),
        ("yyyrrryyyrrr", True),
        ("rrrrrrrrrrrr", True),
    ],
)
def test_a_plan_shows_whether_those_stop_who_keep_their_green(written, between, stops):
    path = written((30, OVERLAP), (3, between), (20, NS), (20, EW), (3, "rrryyyrrryyy"))
    assert read_sumo_network(path).network.intersections[0].all_stop is stops


def test_what_most_changes_do_counts_and_without_an_example_the_kind_of_the_file(written):
    left = frozenset({1, 2})
    stages = (Stage(30, left), Stage(3, frozenset(), clearance=True), Stage(20, frozenset({2, 3})))
    keeping = (Stage(3, frozenset({2}), clearance=True),)
    assert stops_all((*stages, *keeping), untold=False) is False
    assert stops_all((*stages, *keeping), untold=True) is True
    assert stops_all((*stages, *keeping, *stages[:1], *keeping, *stages[2:]), untold=True) is False
    assert stops_all(stages, untold=False) is True
    assert stops_all((), untold=True) is True
    none_in_common = (Stage(9, frozenset({0})), Stage(3, frozenset(), clearance=True))
    assert stops_all((*none_in_common, Stage(9, frozenset({1}))), untold=True) is True
    assert not read_sumo_network(written((30, NS), (20, EW))).network.intersections[0].all_stop
