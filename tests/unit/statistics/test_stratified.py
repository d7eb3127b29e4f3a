import numpy as np
import pytest
import scipy.stats

from dmil.seeding import stream
from dmil.statistics import (
    interval_levels,
    mean_interval,
    paired_difference,
    probability_of_improvement,
)

IQM = "interquartile mean"


def test_interquartile_mean_of_one_task_agrees_with_scipy():
    values = stream(1, "data").gamma(2.0, size=20)
    ours = mean_interval(values[:, None], stream(1, "b"), summary=IQM, resamples=20_000)
    low, high = interval_levels(20)
    theirs = scipy.stats.bootstrap(
        (values,),
        lambda x, axis: scipy.stats.trim_mean(x, 0.25, axis=axis),
        confidence_level=high - low,
        n_resamples=20_000,
        method="percentile",
        random_state=np.random.default_rng(2),
    ).confidence_interval
    spread = theirs.high - theirs.low
    assert ours.value[0] == pytest.approx(scipy.stats.trim_mean(values, 0.25))
    assert ours.low[0] == pytest.approx(theirs.low, abs=0.03 * spread)
    assert ours.high[0] == pytest.approx(theirs.high, abs=0.03 * spread)


def test_paired_ratio_of_interquartile_means_agrees_with_scipy():
    rng = stream(2, "data")
    demand = rng.normal(10, 3, size=20)
    a, b = demand + rng.normal(0.4, 0.3, 20), demand
    ours = paired_difference(
        a[:, None], b[:, None], stream(2, "b"), relative=True, summary=IQM, resamples=20_000
    )
    low, high = interval_levels(20)

    def ratio(x, y, axis):
        means = (scipy.stats.trim_mean(each, 0.25, axis=axis) for each in (x, y))
        return np.divide(*means) - 1

    theirs = scipy.stats.bootstrap(
        (a, b),
        ratio,
        paired=True,
        vectorized=True,
        confidence_level=high - low,
        n_resamples=20_000,
        method="percentile",
        random_state=np.random.default_rng(3),
    ).confidence_interval
    spread = theirs.high - theirs.low
    assert ours.low[0] == pytest.approx(theirs.low, abs=0.04 * spread)
    assert ours.high[0] == pytest.approx(theirs.high, abs=0.04 * spread)


def test_seeds_are_drawn_within_each_task():
    # Two tasks far apart, nothing varies within: only drawing across tasks would give an interval.
    tasks = [np.full((5, 1), 1.0), np.full((5, 1), 100.0)]
    found = mean_interval(tasks, stream(1, "draws"))
    assert (found.value[0], found.low[0], found.high[0]) == (50.5, 50.5, 50.5)
    assert found.seeds[0] == 10


def worlds(seeds, count, effect):
    """Return values and reference (seeds, worlds) of simulated experiments with a known effect.

    Both meet the same demand, which varies far more than they differ.
    """
    rng = stream(4, "worlds", seeds)
    demand = rng.normal(100.0, 30.0, size=(seeds, count))
    reference = demand + rng.normal(0.0, 2.0, size=(seeds, count))
    return demand + effect + rng.normal(0.0, 2.0, size=(seeds, count)), reference


def covered(found, truth):
    return ((found.low <= truth) & (truth <= found.high)).mean()


@pytest.mark.parametrize("summary", ["mean", IQM])
def test_paired_intervals_cover_the_truth_in_95_of_100_experiments(summary):
    values, reference = worlds(seeds=30, count=800, effect=-1.0)
    rng = stream(4, "bootstrap")
    found = paired_difference(values, reference, rng, summary=summary, resamples=1_000)
    assert 0.92 <= covered(found, -1.0) <= 0.98
    # And they are of use: the shared demand, which varies by 30, has cancelled.
    assert (found.high - found.low).mean() < (2.5 if summary == "mean" else 3.5)


def test_stratified_intervals_cover_the_truth_as_often_as_they_say():
    rng = stream(5, "worlds")
    tasks = [rng.normal(task, 1 + task, size=(30, 800)) for task in range(4)]
    found = mean_interval(tasks, stream(5, "bootstrap"), resamples=1_000)
    assert 0.92 <= covered(found, 1.5) <= 0.98


def test_probability_of_improvement_and_its_coverage():
    rng = stream(6, "worlds")
    reference = rng.normal(size=(30, 2_000))
    values = reference + rng.normal(-0.5, 1.0, size=(30, 2_000))
    found = probability_of_improvement(values, reference, stream(6, "b"), resamples=2_000)
    truth = scipy.stats.norm.cdf(0.5)
    assert found.value.mean() == pytest.approx(truth, abs=0.005)
    assert 0.92 <= covered(found, truth) <= 0.98


def test_one_reference_serves_all_columns_in_every_task():
    rng = stream(7, "data")
    tasks = [rng.normal(5, 1, size=(6, 3)), rng.normal(9, 1, size=(8, 3))]
    first = [task[:, [0]] for task in tasks]
    found = paired_difference(tasks, first, stream(7, "b"), summary=IQM)
    assert (found.value[0], found.low[0], found.high[0]) == (0.0, 0.0, 0.0)
    assert found.low[1] < found.value[1] < found.high[1]
    better = probability_of_improvement(tasks, first, stream(7, "b"))
    assert better.value[0] == better.low[0] == better.high[0] == 0.5


def test_missing_runs_are_left_out_of_their_own_column_only():
    task = np.array([[1.0, 1.0], [np.nan, 2.0], [3.0, 3.0]])
    none = np.full((3, 2), np.nan)
    found = mean_interval([task, none], stream(1, "draws"), summary=IQM)
    assert found.value.tolist() == [2.0, 2.0]
    assert found.seeds.tolist() == [2, 3]
    assert (found.low[0], found.high[0]) == (1.0, 3.0)


def test_a_task_with_one_seed_counts_and_does_not_vary():
    tasks = [np.array([[0.0], [2.0]]), np.array([[10.0]])]
    found = mean_interval(tasks, stream(1, "draws"))
    assert (found.value[0], found.low[0], found.high[0]) == (4.0, 10 / 3, 14 / 3)


@pytest.mark.parametrize("tasks", [[np.full((3, 1), np.nan)], [np.empty((0, 1))]])
def test_without_runs_there_is_nothing(tasks):
    found = mean_interval(tasks, stream(1, "draws"))
    assert np.isnan([found.value, found.low, found.high]).all()
    assert found.seeds.tolist() == [0]


def test_one_seed_has_no_interval():
    found = mean_interval([np.array([[4.0]])], stream(1, "draws"))
    assert found.value[0] == 4.0 and np.isnan([found.low, found.high]).all()
