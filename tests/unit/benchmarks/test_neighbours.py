"""Figures of look-ups among neighbours: beside scipy's tree; how fast they are is not tested."""

import pytest

from dmil.benchmarks import neighbours


def test_each_look_up_stands_beside_the_tree():
    figures = neighbours.neighbour_figures(entries=300, episodes=2, rounds=2)
    by_name = {figure.name: figure for figure in figures}
    assert len(by_name) == len(figures) == 4
    compared = [figure for figure in figures if figure.against]
    assert [figure.name for figure in compared] == [
        "MFEC look-up, 11 nearest of 300",
        "NEC look-up, 50 nearest of 300",
    ]
    for figure in compared:
        assert figure.unit == by_name[figure.against].unit == "µs"
        assert 0 < figure.ratio_min <= figure.ratio_median <= figure.ratio_max


def test_neighbours_that_are_not_the_nearest_are_noticed(monkeypatch):
    monkeypatch.setattr(neighbours, "_ask", no_answer)
    with pytest.raises(AssertionError, match="nearer"):
        neighbours.neighbour_figures(entries=100, episodes=2, rounds=1)


def no_answer(store, questions, nearest, weighted, farthest):
    farthest[:] = 0.0


def test_too_few_states_are_noticed():
    with pytest.raises(AssertionError, match="too few states"):
        neighbours.states_apart(1_000_000, 2)
