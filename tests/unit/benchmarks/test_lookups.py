"""Figures of look-ups: each beside its scan; how fast they are is not tested."""

import pytest

from dmil.benchmarks import lookups


def test_each_look_up_stands_beside_its_scan():
    figures = lookups.lookup_figures(keys=300, episodes=2, rounds=3)
    by_name = {figure.name: figure for figure in figures}
    assert len(by_name) == len(figures) == 8
    compared = [figure for figure in figures if figure.against]
    assert [figure.name for figure in compared] == [
        "L∞ ≤ 1 look-up at 300 keys",
        "L∞ ≤ 1 look-up in 4 rotations at 300 keys",
        "exact look-up at 300 keys",
        "cells look-up at 300 keys",
    ]
    for figure in compared:
        scan = by_name[figure.against]
        assert figure.unit == scan.unit
        assert 0 < figure.ratio_min <= figure.ratio_median <= figure.ratio_max
        assert min(figure.value, scan.value) > 0


def test_unlike_answers_are_noticed(monkeypatch):
    monkeypatch.setattr(lookups, "_ask", answer_by_turns)
    with pytest.raises(AssertionError, match="different answers"):
        lookups.lookup_figures(keys=10, episodes=2, rounds=1)


def answer_by_turns(rows, classes, states, scratch, scans, answers):
    answers[:] = scans


def test_too_few_states_are_noticed():
    with pytest.raises(AssertionError, match="too few states"):
        lookups.lookup_figures(keys=100_000, episodes=2, rounds=1)
