import numpy as np
import pytest
import scipy.stats

from dmil.seeding import stream
from dmil.statistics import (
    mean_interval,
    paired_difference,
    paired_ratio_of_ratios,
)


def _expanded(seeds, level):
    tail = scipy.stats.t.ppf((1 - level) / 2, seeds - 1) * np.sqrt(seeds / (seeds - 1))
    return 1 - 2 * scipy.stats.norm.cdf(tail)


def test_interval_agrees_with_scipy_at_the_expanded_level():
    values = stream(1, "data").gamma(2.0, size=(12, 3))
    ours = mean_interval(values, stream(1, "bootstrap"), resamples=40_000)
    for column in range(3):
        theirs = scipy.stats.bootstrap(
            (values[:, column],),
            np.mean,
            confidence_level=_expanded(12, 0.95),
            n_resamples=40_000,
            method="percentile",
            random_state=np.random.default_rng(2),
        ).confidence_interval
        spread = theirs.high - theirs.low
        assert ours.value[column] == pytest.approx(values[:, column].mean())
        assert ours.low[column] == pytest.approx(theirs.low, abs=0.03 * spread)
        assert ours.high[column] == pytest.approx(theirs.high, abs=0.03 * spread)


def test_paired_difference_agrees_with_scipy():
    rng = stream(3, "data")
    demand = rng.normal(10, 3, size=20)
    a, b = demand + rng.normal(0.2, 0.1, 20), demand + rng.normal(0, 0.1, 20)
    ours = paired_difference(
        a[:, None], b[:, None], stream(3, "bootstrap"), relative=True, resamples=40_000
    )
    theirs = scipy.stats.bootstrap(
        (a, b),
        lambda x, y, axis=-1: x.mean(axis=axis) / y.mean(axis=axis) - 1,
        paired=True,
        vectorized=True,
        confidence_level=_expanded(20, 0.95),
        n_resamples=40_000,
        method="percentile",
        random_state=np.random.default_rng(4),
    ).confidence_interval
    spread = theirs.high - theirs.low
    assert ours.low[0] == pytest.approx(theirs.low, abs=0.03 * spread)
    assert ours.high[0] == pytest.approx(theirs.high, abs=0.03 * spread)


@pytest.mark.parametrize(("seeds", "expected"), [(5, 0.92), (10, 0.945), (30, 0.95)])
def test_the_interval_covers_the_truth_as_often_as_it_says(seeds, expected):
    worlds = 4_000
    values = stream(5, "worlds", seeds).normal(3.0, 1.0, size=(seeds, worlds))
    estimate = mean_interval(values, stream(5, "bootstrap", seeds), resamples=1_000)
    covered = ((estimate.low <= 3.0) & (estimate.high >= 3.0)).mean()
    # Standard error of a coverage of .95 in 4,000 worlds: .0034. Without expanded levels five seeds
    # would cover .83 only.
    assert covered == pytest.approx(expected, abs=0.012)


def test_pairing_finds_what_shared_demand_hides():
    rng = stream(6, "data")
    demand = rng.normal(10, 3, size=(30, 1))
    a, b = demand + 0.2, demand
    paired = paired_difference(a, b, stream(6, "bootstrap"))
    alone = mean_interval(a, stream(6, "bootstrap")), mean_interval(b, stream(6, "bootstrap"))
    assert paired.low[0] == pytest.approx(0.2) and paired.high[0] == pytest.approx(0.2)
    assert alone[0].low[0] < alone[1].high[0]


def test_a_missing_run_leaves_its_pair_out_and_no_other():
    values = np.array([[1.0, 1.0], [2.0, 2.0], [np.nan, 6.0]])
    reference = np.ones((3, 2))
    estimate = paired_difference(values, reference, stream(0, "bootstrap"))
    assert estimate.value.tolist() == [0.5, 2.0]
    assert estimate.seeds.tolist() == [2, 3]


def test_one_seed_has_a_value_and_no_interval_and_none_has_neither():
    estimate = mean_interval(np.array([[4.0, np.nan]]), stream(0, "bootstrap"))
    assert estimate.value[0] == 4.0 and np.isnan(estimate.value[1])
    assert np.isnan(estimate.low).all() and np.isnan(estimate.high).all()


def test_ratio_of_ratios_is_zero_when_the_change_helps_both_alike():
    a = stream(7, "data").uniform(1, 2, size=(10, 1))
    estimate = paired_ratio_of_ratios((a / 2, a), (3 * a / 2, 3 * a), stream(7, "bootstrap"))
    assert estimate.value[0] == pytest.approx(0.0)
    better = paired_ratio_of_ratios((a / 4, a), (3 * a / 2, 3 * a), stream(7, "bootstrap"))
    assert better.value[0] == pytest.approx(-0.5) and better.high[0] < 0


def test_same_generator_same_interval():
    values = stream(8, "data").normal(size=(9, 4))
    first, second = (mean_interval(values, stream(8, "bootstrap")) for _ in range(2))
    assert np.array_equal(first.low, second.low)


def test_level_outside_its_range_is_refused():
    with pytest.raises(ValueError, match="level"):
        mean_interval(np.ones((3, 1)), stream(0, "b"), level=95)
