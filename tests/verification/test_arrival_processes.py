"""Arrival processes against their closed forms.

Tolerances are five standard errors; seeds are fixed, so a run never fails by chance.
"""

import numpy as np
import pytest
from scipy import stats

from dmil.demand import CompoundPoissonDemand, PoissonDemand, ProfileDemand
from dmil.network import grid
from dmil.seeding import stream

NETWORK = grid(1, 1)
RUNS = 400
HORIZON_S = 120
RATE = {"E": 5.0, "N": 20.0, "W": 60.0, "S": 0.5}


def counts_by_node(demand, seed="arrivals"):
    """Return vehicles per run and fringe node: (runs, fringe) int."""
    entry = {network_link: node for node, network_link in _entries().items()}
    counts = np.zeros((RUNS, len(NETWORK.fringe)), dtype=int)
    for run in range(RUNS):
        vehicles = demand.vehicles(NETWORK, HORIZON_S, stream(run, seed))
        first = vehicles.route_links[vehicles.route_offset[:-1]]
        for link, count in zip(*np.unique(first, return_counts=True), strict=True):
            counts[run, NETWORK.fringe.index(entry[link])] = count
    return counts


def _entries():
    return {NETWORK.links[k].start: k for k in NETWORK.entry_links}


def assert_mean_and_variance(counts, mean, variance, fourth_moment):
    """Compare with closed forms, five standard errors wide."""
    n = len(counts)
    assert abs(counts.mean() - mean) < 5 * np.sqrt(variance / n)
    of_variance = np.sqrt((fourth_moment - variance**2) / n)
    assert abs(counts.var(ddof=1) - variance) < 5 * of_variance


def test_poisson_counts_have_mean_and_variance_of_rate_times_time():
    counts = counts_by_node(PoissonDemand(RATE))
    for node, rate in enumerate(RATE.values()):
        mean = rate / 60 * HORIZON_S
        # Fourth central moment of a Poisson number.
        assert_mean_and_variance(counts[:, node], mean, mean, mean + 3 * mean**2)


def test_poisson_counts_of_different_nodes_are_uncorrelated():
    counts = counts_by_node(PoissonDemand(dict.fromkeys("ENWS", 20.0)))
    correlation = np.corrcoef(counts.T)[np.triu_indices(4, 1)]
    assert (abs(correlation) < 5 / np.sqrt(RUNS)).all()


def test_poisson_counts_follow_the_poisson_distribution():
    counts = counts_by_node(PoissonDemand({"W": 3.0}))[:, NETWORK.fringe.index("W0")]
    expected = stats.poisson.pmf(np.arange(12), 6.0) * RUNS
    seen = np.bincount(np.minimum(counts, 12), minlength=13)
    expected = np.append(expected, RUNS - expected.sum())
    # Classes of few expected runs are joined, as the test needs.
    low, high = expected[:3].sum(), expected[10:].sum()
    chi = stats.chisquare(
        [seen[:3].sum(), *seen[3:10], seen[10:].sum()], [low, *expected[3:10], high]
    )
    assert chi.pvalue > 1e-4


def test_poisson_arrivals_are_uniform_over_time():
    vehicles = PoissonDemand({"E": 600.0}).vehicles(NETWORK, 1000, stream(0, "time"))
    seen = np.bincount(vehicles.depart_s // 100, minlength=10)
    assert stats.chisquare(seen).pvalue > 1e-4


@pytest.mark.parametrize("mean_batch", [1.5, 2.5, 6.0])
def test_geometric_batches_raise_the_variance_and_keep_the_mean(mean_batch):
    demand = CompoundPoissonDemand({"W": 60.0}, batch_veh=mean_batch)
    counts = counts_by_node(demand)[:, NETWORK.fringe.index("W0")]
    mean = 60.0 / 60 * HORIZON_S
    # Moments of a geometric number from 1 on with p = 1/mean batch.
    moments = [stats.geom.moment(k, 1 / mean_batch) for k in (2, 4)]
    batches = mean / mean_batch
    variance = batches * moments[0]
    assert variance == pytest.approx(mean * (2 * mean_batch - 1))
    assert_mean_and_variance(counts, mean, variance, batches * moments[1] + 3 * variance**2)


def test_given_batches_raise_the_variance_and_keep_the_mean():
    sizes = {1: 0.25, 2: 0.25, 8: 0.5}
    demand = CompoundPoissonDemand({"W": 60.0}, batch_veh=sizes)
    counts = counts_by_node(demand)[:, NETWORK.fringe.index("W0")]
    first, second, fourth = (sum(p * k**m for k, p in sizes.items()) for m in (1, 2, 4))
    batches = HORIZON_S / first
    variance = batches * second
    assert_mean_and_variance(counts, HORIZON_S, variance, batches * fourth + 3 * variance**2)


@pytest.mark.parametrize("between", ["step", "linear"])
def test_varying_rates_give_the_integral_of_the_profile(between):
    base = PoissonDemand({"W": 120.0})
    profile = ProfileDemand(base, [0, 200, 400], [0.5, 3.0, 0.0], between)
    seen = np.zeros(4)
    for run in range(50):
        vehicles = profile.vehicles(NETWORK, 400, stream(run, "profile"))
        seen += np.bincount(vehicles.depart_s // 100, minlength=4)
    # Mean factor over the seconds of each 100 s window, times 2 vehicles per second.
    second = np.arange(100)
    if between == "step":
        factor = np.array([0.5, 0.5, 3.0, 3.0])
    else:
        rise, fall = 2.5 / 200, -3.0 / 200
        factor = np.array(
            [
                0.5 + rise * second.mean(),
                0.5 + rise * (100 + second.mean()),
                3.0 + fall * second.mean(),
                3.0 + fall * (100 + second.mean()),
            ]
        )
    expected = 50 * 2.0 * 100 * factor
    assert (abs(seen - expected) < 5 * np.sqrt(expected)).all()


def test_destinations_are_uniform_over_the_other_fringe_nodes():
    network = grid(2, 3)
    vehicles = PoissonDemand({"N1": 3000.0}).vehicles(network, 200, stream(0, "destinations"))
    last = vehicles.route_links[vehicles.route_offset[1:] - 1]
    seen = {
        network.links[k].end: count
        for k, count in zip(*np.unique(last, return_counts=True), strict=True)
    }
    assert set(seen) == set(network.fringe) - {"N1"}
    assert stats.chisquare(list(seen.values())).pvalue > 1e-4


def test_the_papers_demand_on_its_grids():
    for size, mean in ((1, 135), (3, 405), (5, 675)):
        network = grid(size, size)
        counts = [
            len(PoissonDemand().vehicles(network, 300, stream(run, "paper"))) for run in range(60)
        ]
        assert abs(np.mean(counts) - mean) < 5 * np.sqrt(mean / 60)
