"""Poisson arrivals at one movement against queueing theory in discrete time.

A arrivals with mean q join in a step, then one vehicle goes if there is one and the signal is
green: the queue after the step is X' = max(X + A − 1, 0), else X' = X + A.
"""

import numpy as np
import pytest
from scipy.stats import poisson

from dmil.demand import Vehicles
from dmil.scenarios import SignalTiming, scenario
from dmil.seeding import stream
from dmil.simulation import QueueSimulator

RIGHT, STRAIGHT = ("E0>0,0", "0,0>N0"), ("E0>0,0", "0,0>W0")
EW_STRAIGHT, NS_STRAIGHT = 0, 2
RUNS, HORIZON_S, WARM_UP_S = 16, 30_000, 3_000


def mean_queues(route, draw_counts, *, interval_s, phase_at, name):
    """Return the mean queue of every run after its warm-up: (RUNS,)."""
    made = scenario(
        "grid:1x1", horizon_s=HORIZON_S, timing=SignalTiming(decision_interval_s=interval_s)
    )
    simulator = QueueSimulator(made)
    links = [made.network.link_index[link] for link in route]
    means = []
    for run in range(RUNS):
        counts = draw_counts(stream(run, "arrivals", name))
        depart_s = np.repeat(np.arange(HORIZON_S, dtype=np.int32), counts)
        offset = 2 * np.arange(depart_s.size + 1, dtype=np.int32)
        simulator.reset(Vehicles(depart_s, offset, np.tile(links, depart_s.size).astype(np.int32)))
        for time_s in range(0, HORIZON_S, interval_s):
            simulator.advance(np.array([phase_at(time_s)], np.int32))
        measures = simulator.measures()
        assert measures.spawned_veh == depart_s.size
        means.append(measures.queued_at[WARM_UP_S:].mean())
    return np.array(means)


def standard_error(means):
    return means.std(ddof=1) / np.sqrt(means.size)


@pytest.mark.parametrize("q", [0.2, 0.5, 0.8])
def test_poisson_arrivals_at_an_open_movement_queue_as_pollaczek_and_khinchine_say(q):
    # Squaring X' = Y − 1{Y>0}, Y = X + A, gives E X = E[A(A−1)] / (2(1−q)); for Poisson arrivals
    # this is q²/(2(1−q)), the mean queue of M/D/1.
    means = mean_queues(
        RIGHT,
        lambda rng: rng.poisson(q, HORIZON_S),
        interval_s=1000,
        phase_at=lambda time_s: 0,
        name=f"open {q}",
    )
    expected = q**2 / (2 * (1 - q))
    assert abs(means.mean() - expected) < 4 * standard_error(means)
    assert standard_error(means) < expected / 20  # the comparison says something


def test_pairs_of_vehicles_queue_longer_by_what_theory_says():
    # Pairs with rate q/2: E[A(A−1)] = q² + q.
    q = 0.6
    means = mean_queues(
        RIGHT,
        lambda rng: 2 * rng.poisson(q / 2, HORIZON_S),
        interval_s=1000,
        phase_at=lambda time_s: 0,
        name="pairs",
    )
    expected = (q**2 + q) / (2 * (1 - q))
    assert abs(means.mean() - expected) < 4 * standard_error(means)
    assert standard_error(means) < expected / 20


@pytest.mark.parametrize(
    ("saturation", "red_s", "cycle_s"), [(0.3, 20, 40), (0.5, 30, 60), (0.8, 20, 40), (0.8, 30, 40)]
)
def test_poisson_arrivals_at_a_fixed_cycle_queue_as_the_markov_chain_and_webster_say(
    saturation, red_s, cycle_s
):
    green_ratio = 1 - red_s / cycle_s
    q = saturation * green_ratio
    means = mean_queues(
        STRAIGHT,
        lambda rng: rng.poisson(q, HORIZON_S),
        interval_s=10,
        phase_at=lambda time_s: NS_STRAIGHT if time_s % cycle_s < red_s else EW_STRAIGHT,
        name=f"cycle {saturation} {red_s} {cycle_s}",
    )
    assert abs(means.mean() - chain_queue(q, red_s, cycle_s)) < 4 * standard_error(means)
    # Webster's formula is a fit to simulations, good to some per cent; Little's law joins them.
    webster_s = webster_delay(q, saturation, green_ratio, cycle_s)
    assert means.mean() / q == pytest.approx(webster_s, rel=0.06)
    assert standard_error(means) < means.mean() / 50


def chain_queue(q, red_s, cycle_s, states=400):
    """Return the mean queue of the Markov chain's cyclic steady state."""
    arriving = poisson.pmf(np.arange(30), q)
    probability = np.zeros(states)
    probability[0] = 1.0
    mean, last = 0.0, -1.0
    while abs(mean - last) > 1e-9:
        mean, last = 0.0, mean
        for time_s in range(cycle_s):
            probability = np.convolve(probability, arriving)[:states]
            if time_s >= red_s:
                probability = np.append(probability[1:], 0.0) + probability[0] * (
                    np.arange(states) == 0
                )
            mean += probability @ np.arange(states) / cycle_s
    assert probability.sum() == pytest.approx(1.0, abs=1e-9)
    return mean


def webster_delay(q, saturation, green_ratio, cycle_s):
    """Return the mean delay in s (Webster 1958): uniform, random, and a correction."""
    uniform = cycle_s * (1 - green_ratio) ** 2 / (2 * (1 - q))
    random = saturation**2 / (2 * q * (1 - saturation))
    correction = 0.65 * (cycle_s / q**2) ** (1 / 3) * saturation ** (2 + 5 * green_ratio)
    return uniform + random - correction
