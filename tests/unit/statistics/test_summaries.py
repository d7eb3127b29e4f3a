import numpy as np
import pytest
from scipy.stats import trim_mean

from dmil.seeding import stream
from dmil.statistics import interquartile_mean, standard_deviation, wins
from dmil.statistics.summaries import resampled_interquartile_means, resampled_means


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


def resamples_of(runs, values, rng):
    """Return counts of some resamples, and the values each of them drew, one by one."""
    counts = rng.multinomial(runs, np.full(runs, 1 / runs), size=200).T.astype(float)
    drawn = [np.repeat(values, times.astype(int), axis=0) for times in counts.T]
    return counts, np.stack(drawn, axis=-1)  # (runs, columns, resamples)


@pytest.mark.parametrize("runs", [1, 2, 3, 4, 5, 8, 30])
def test_resamples_summed_up_at_once_are_what_each_gives_alone(runs):
    rng = stream(2, "values", runs)
    values = np.round(rng.normal(size=(runs, 3)), 1)  # some are equal
    counts, drawn = resamples_of(runs, values, rng)
    assert resampled_means(values, counts) == pytest.approx(drawn.mean(axis=0))
    found = resampled_interquartile_means(values, counts)
    assert found == pytest.approx(trim_mean(drawn, 0.25, axis=0))


def test_an_outlier_costs_the_resamples_no_digits():
    values = np.append(stream(3, "values").normal(size=19), 1e15)[:, None]
    once = np.ones((20, 1))
    found = resampled_interquartile_means(values, once)[0, 0]
    assert found == pytest.approx(trim_mean(values[:, 0], 0.25), rel=1e-14)


def test_resamples_of_runs_that_are_all_equal_give_exactly_their_value():
    values, counts = np.full((10, 1), 0.1), np.ones((10, 1))
    assert resampled_interquartile_means(values, counts)[0, 0] == 0.1


def test_standard_deviation_skips_missing_runs():
    values = np.array([[1.0, 5.0, np.nan], [3.0, np.nan, np.nan]])
    deviation = standard_deviation(values)
    assert deviation[0] == pytest.approx(np.sqrt(2.0))
    assert np.isnan(deviation[1:]).all()
