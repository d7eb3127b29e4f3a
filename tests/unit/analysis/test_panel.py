"""Runs on named axes, curves over seeds, ratios to a reference."""

import numpy as np
import polars as pl

from dmil.analysis.claims import Evidence, difference_text, in_words, undecided
from dmil.analysis.estimates import by_seed, ratios
from dmil.analysis.panel import RunPanel, on_axes

RUNS = pl.DataFrame(
    {"place": ["b", "a", "a"], "who": ["x", "x", "y"], "seed": [1, 1, 0], "wait": [3.0, 1.0, 2.0]}
)
AXES = {"place": ["a", "b"], "who": ["x", "y"], "seed": [0, 1]}


def test_a_measure_is_found_by_the_names_of_its_axes():
    panel = RunPanel(axes=AXES, measures={"wait": on_axes(RUNS, AXES)("wait")})
    assert panel.seeds == (0, 1) and panel.number("who", "z") is None
    assert panel.of("wait", place="b", who="x")[1] == 3.0
    assert panel.of("wait", seed=0, place="a").tolist()[1] == 2.0
    assert panel.of("wait", who="y").shape == (2, 2)
    assert np.isnan(panel.of("wait", who="z")).all()
    assert panel.of("wait", who="z", seed=0).shape == (2,)


def test_a_curve_has_a_row_for_each_seed_and_gaps_where_a_run_is_missing():
    runs = pl.DataFrame({"seed": [1, 0, 0], "episode": [10, 10, 9], "wait": [1.0, 2.0, 3.0]})
    episodes, values = by_seed(runs, "episode", "wait")
    assert episodes == [9, 10]
    assert np.array_equal(values, [[3.0, 2.0], [np.nan, 1.0]], equal_nan=True)


def test_there_is_no_ratio_to_nothing():
    (found,) = ratios([np.array([[1.0, 2.0], [3.0, 0.0]])], [np.array([[2.0], [0.0]])])
    assert np.array_equal(found, [[0.5, 1.0], [np.nan, np.nan]], equal_nan=True)


def test_evidence_is_told_in_full_or_by_its_extremes():
    evidence = [Evidence(name, value, 0, 0, 5, "open") for value, name in enumerate("abcde")]
    assert in_words(evidence[:2], lambda one: one.comparison) == "a; b"
    assert in_words(evidence, lambda one: one.comparison) == "lowest a; highest e"
    assert undecided([]) == "not run" and undecided(evidence) is None
    assert difference_text(-3.1, None, None) == "−3.1 %"
    assert difference_text(1.0, -2.0, 4.0) == "+1.0 % [−2.0, +4.0]"
