"""Intervals of shares, against SciPy."""

import numpy as np
import pytest
from scipy.stats import binomtest

from dmil.statistics import share_interval


@pytest.mark.parametrize("level", [0.8, 0.95, 0.99])
@pytest.mark.parametrize(("successes", "runs"), [(0, 1), (0, 20), (1, 20), (7, 20), (20, 20)])
def test_ends_are_those_of_scipy(successes, runs, level):
    found = share_interval([successes], [runs], level=level)
    theirs = binomtest(successes, runs).proportion_ci(level, method="wilson")
    assert found.value[0] == successes / runs and found.seeds[0] == runs
    assert (found.low[0], found.high[0]) == pytest.approx((theirs.low, theirs.high), abs=1e-12)


def test_without_runs_there_is_no_share():
    found = share_interval([0, 3], [0, 4])
    assert np.isnan([found.value[0], found.low[0], found.high[0]]).all()
    assert found.value[1] == 0.75


@pytest.mark.parametrize("successes", [-1, 5])
def test_more_successes_than_runs_are_refused(successes):
    with pytest.raises(ValueError, match="successes of"):
        share_interval([successes], [4])
