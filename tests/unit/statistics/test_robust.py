import numpy as np
import pytest
from scipy.stats import trim_mean

from dmil.seeding import stream
from dmil.statistics import interquartile_mean, stratified, wins


@pytest.mark.parametrize("runs", [1, 2, 3, 4, 7, 8, 40])
def test_interquartile_mean_is_the_mean_without_a_quarter_at_either_end(runs):
    values = stream(1, "values").normal(size=(5, runs))
    assert interquartile_mean(values) == pytest.approx(trim_mean(values, 0.25, axis=-1))


def test_an_outlier_does_not_move_the_interquartile_mean():
    assert interquartile_mean(np.array([1.0, 2.0, 3.0, 1e9])) == 2.5


def test_wins_count_the_lower_and_half_of_the_equal():
    ours = np.array([1.0, 3.0, 2.0, np.nan, 1.0])
    theirs = np.array([2.0, 2.0, 2.0, 1.0, np.nan])
    assert wins(ours, theirs)[:3].tolist() == [1.0, 0.0, 0.5]
    assert np.isnan(wins(ours, theirs)[3:]).all()


def mean(drawn):
    return drawn.mean(axis=-1)


def test_seeds_are_drawn_within_each_task():
    # Two tasks far apart, nothing varies within: only drawing across tasks would give an interval.
    tasks = [np.full(5, 1.0), np.full(5, 100.0)]
    assert stratified(tasks, mean, stream(1, "draws")) == (50.5, 50.5, 50.5)


def test_the_interval_covers_the_truth_about_as_often_as_it_says():
    covered = 0
    for trial in range(200):
        rng = stream(2, "trial", str(trial))
        tasks = [rng.normal(task, 1, 6) for task in range(4)]
        _, low, high = stratified(tasks, mean, rng, resamples=500)
        covered += low <= 1.5 <= high
    assert 180 <= covered <= 200


def test_missing_runs_are_left_out():
    tasks = [np.array([1.0, np.nan, 3.0]), np.full(3, np.nan)]
    value, low, high = stratified(tasks, mean, stream(1, "draws"))
    assert value == 2.0 and low == 1.0 and high == 3.0


@pytest.mark.parametrize("tasks", [[], [np.full(3, np.nan)]])
def test_without_runs_there_is_nothing(tasks):
    assert np.isnan(stratified(tasks, mean, stream(1, "draws"))).all()


def test_one_seed_has_no_interval():
    value, low, high = stratified([np.array([4.0])], mean, stream(1, "draws"))
    assert value == 4.0 and np.isnan([low, high]).all()
