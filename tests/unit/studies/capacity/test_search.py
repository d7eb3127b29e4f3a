"""The search for the highest stable load."""

import pytest

from dmil.studies.capacity.search import highest_stable, loads_tried


def tried(capacity, *, highest=8.0, levels=8, halvings=4):
    return loads_tried(lambda load: load <= capacity, highest, levels, halvings)


def test_levels_rise_to_the_first_that_is_not_stable_then_the_interval_is_halved():
    assert tried(2.3) == [1.0, 2.0, 3.0, 2.5, 2.25, 2.375, 2.3125]


@pytest.mark.parametrize("capacity", [0.3, 1.0, 2.0, 4.44, 7.99])
def test_the_result_is_as_close_below_the_capacity_as_was_said(capacity):
    loads = tried(capacity)
    found, at_least = highest_stable(loads, [load - capacity for load in loads], 0.0)
    assert 0 <= capacity - found <= 8 / 8 / 2**4
    assert not at_least


def test_where_everything_is_stable_the_capacity_is_at_least_the_highest():
    loads = tried(100.0)
    assert loads == [1, 2, 3, 4, 5, 6, 7, 8]
    assert highest_stable(loads, [0.0] * 8, 0.02) == (8.0, True)


def test_where_nothing_is_stable_it_is_0():
    loads = tried(0.0)
    assert loads == [1.0, 0.5, 0.25, 0.125, 0.0625]
    assert highest_stable(loads, [1.0] * 5, 0.02) == (0.0, False)


def test_without_halvings_it_is_a_level():
    assert tried(2.3, halvings=0) == [1.0, 2.0, 3.0]
