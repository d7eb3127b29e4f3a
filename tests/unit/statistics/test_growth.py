"""The test for growth of a queue, on series of which it is known whether they grow."""

import numpy as np
import pytest

from dmil.seeding import stream
from dmil.statistics import mean_interval, queue_growth, stability

TOLERANCE = 0.02


def queue_of(arrivals_veh_per_s, capacity_veh_per_s, seed, horizon_s=3600):
    """A queue in discrete time with Poisson arrivals and services, empty at first."""
    rng = stream(seed, "test", "queue")
    changes = rng.poisson(arrivals_veh_per_s, horizon_s) - rng.poisson(
        capacity_veh_per_s, horizon_s
    )
    walk = np.concatenate([[0], np.cumsum(changes)])
    return (walk - np.minimum.accumulate(walk))[1:]


def test_a_line_grows_by_its_slope_over_the_arrivals():
    assert queue_growth(np.arange(1000) * 3, 12.0) == pytest.approx(0.25)
    assert queue_growth(np.arange(1000)[::-1], 2.0) == pytest.approx(-0.5)


def test_the_first_half_does_not_count():
    filling = np.concatenate([np.arange(500), np.full(500, 500)])
    assert queue_growth(filling, 1.0) == pytest.approx(0.0)
    late = np.concatenate([np.zeros(500), np.arange(500)])
    assert queue_growth(late, 1.0) == pytest.approx(1.0)


def test_nobody_comes_nothing_grows():
    assert queue_growth(np.zeros(100), 0.0) == 0.0
    assert queue_growth(np.zeros(1), 1.0) == 0.0


@pytest.mark.parametrize(
    ("load", "expected"), [(0.5, "stable"), (0.9, "stable"), (1.1, "grows"), (1.5, "grows")]
)
def test_many_runs_below_capacity_are_stable_and_above_they_grow(load, expected):
    growth = np.array([[queue_growth(queue_of(load, 1.0, seed), load)] for seed in range(20)])
    found = mean_interval(growth, stream(0, "test"))
    assert stability(found.low[0], found.high[0], TOLERANCE) == expected
    if load > 1:
        assert found.value[0] == pytest.approx(1 - 1 / load, abs=0.02)


def test_an_interval_about_the_tolerance_leaves_it_open():
    assert stability(0.01, 0.03, TOLERANCE) == "open"
    assert stability(-0.01, TOLERANCE, TOLERANCE) == "stable"
    assert stability(TOLERANCE, 0.04, TOLERANCE) == "open"
    assert stability(0.021, 0.04, TOLERANCE) == "grows"
