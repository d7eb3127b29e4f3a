import numpy as np
import scipy.stats

from dmil.seeding import stream
from dmil.statistics import performance_profile

THRESHOLDS = np.array([0.0, 1.0, 2.0, 3.0])


def test_shares_are_those_of_runs_at_or_below_each_threshold():
    tasks = [np.array([[1.0, 0.5], [2.0, 4.0]]), np.array([[3.0, 0.5], [1.5, 0.5]])]
    found = performance_profile(tasks, THRESHOLDS, stream(1, "b"))
    assert found.share[:, 0].tolist() == [0.0, 0.25, 0.75, 1.0]
    assert found.share[:, 1].tolist() == [0.0, 0.75, 0.75, 0.75]
    assert (found.low <= found.share).all() and (found.share <= found.high).all()


def test_a_missing_run_does_not_count_and_a_failed_one_meets_no_threshold():
    values = np.array([[1.0, 1.0], [np.nan, np.inf]])
    found = performance_profile(values, THRESHOLDS, stream(1, "b"))
    assert found.share[-1].tolist() == [1.0, 0.5]


def test_the_band_covers_the_true_share_at_each_threshold():
    values = stream(2, "worlds").normal(size=(30, 500))
    found = performance_profile(values, np.array([-0.5, 0.0, 0.5]), stream(2, "b"))
    truth = scipy.stats.norm.cdf(found.thresholds)[:, None]
    covered = ((found.low <= truth) & (truth <= found.high)).mean(axis=1)
    # Shares of 30 runs are coarse, so a band covers somewhat more or less than it says.
    assert (covered > 0.91).all() and (covered < 0.985).all()


def test_no_threshold_gives_an_empty_profile():
    found = performance_profile(np.ones((3, 2)), np.array([]), stream(1, "b"))
    assert found.share.shape[0] == 0


def test_share_without_runs_is_missing():
    found = performance_profile(np.full((3, 1), np.nan), THRESHOLDS, stream(1, "b"))
    assert np.isnan(found.share).all()
    assert found.share.shape == (4, 1)


def test_one_seed_has_no_band():
    found = performance_profile(np.ones((1, 1)), THRESHOLDS, stream(1, "b"))
    assert found.share[:, 0].tolist() == [0.0, 1.0, 1.0, 1.0]
    assert np.isnan(found.low).all()
