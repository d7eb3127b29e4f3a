import numpy as np
import pytest
import scipy.stats

from dmil.seeding import stream
from dmil.statistics import holm, signed_rank_tests


@pytest.mark.parametrize("seeds", [6, 30, 80])
def test_each_column_has_scipy_s_p_value(seeds):
    rng = stream(1, "data", seeds)
    reference = rng.normal(10, 3, size=(seeds, 1))
    values = reference + rng.normal([0.0, 0.3, 2.0], 1.0, size=(seeds, 3))
    found = signed_rank_tests(values, reference)
    expected = [scipy.stats.wilcoxon(values[:, i], reference[:, 0]).pvalue for i in range(3)]
    assert found.p == pytest.approx(expected)
    assert found.p_holm == pytest.approx(holm(np.array(expected)))
    assert found.pairs.tolist() == found.differing.tolist() == [seeds] * 3


def test_tasks_are_ranked_together():
    rng = stream(2, "data")
    tasks = [rng.normal(0.2, 1, size=(10, 1)) for _ in range(3)]
    found = signed_rank_tests(tasks, [np.zeros((10, 1))] * 3)
    assert found.p[0] == pytest.approx(scipy.stats.wilcoxon(np.concatenate(tasks)[:, 0]).pvalue)


def test_ties_and_pairs_that_are_equal():
    values = np.array([1.0, 1.0, -1.0, 2.0, 2.0, 0.0, 3.0, 0.0])[:, None]
    found = signed_rank_tests(values, np.zeros((8, 1)))
    kept = values[values != 0]
    assert found.p[0] == pytest.approx(scipy.stats.wilcoxon(kept).pvalue)
    assert (found.pairs[0], found.differing[0]) == (8, 6)


def test_no_difference_no_pair_and_too_few_seeds_are_told_apart():
    values = np.array([[1.0, np.nan, 2.0], [5.0, 3.0, np.nan]])
    reference = np.array([[1.0, 1.0, 1.0], [5.0, np.nan, 4.0]])
    found = signed_rank_tests(values, reference)
    assert found.p[0] == 1.0 and np.isnan(found.p[1]) and found.p[2] == 1.0
    assert found.pairs.tolist() == [2, 0, 1]
    assert found.differing.tolist() == [0, 0, 1]


def test_holm_by_hand():
    found = holm(np.array([0.01, 0.04, 0.03, np.nan, 0.005]))
    assert found[[4, 0, 2, 1]] == pytest.approx([0.02, 0.03, 0.06, 0.06])
    assert np.isnan(found[3])


def test_holm_never_exceeds_one_and_keeps_the_order():
    p = stream(3, "p").uniform(size=50)
    found = holm(p)
    assert found.max() <= 1.0
    assert (np.diff(found[np.argsort(p)]) >= 0).all()
    assert (found >= p).all()


def test_holm_keeps_the_error_of_the_whole_family():
    # Six true null hypotheses, 300 times: an alarm in 5 % of them, give or take 3 standard errors.
    alarms = 0
    rng = stream(4, "worlds")
    for _ in range(300):
        found = signed_rank_tests(rng.normal(size=(20, 6)), np.zeros((20, 1)))
        alarms += (found.p_holm < 0.05).any()
    assert 3 <= alarms <= 27
