"""The vehicles of one draw at any load."""

from itertools import pairwise

import numpy as np
import pytest

from dmil.demand import DemandLevels, FileDemand, PoissonDemand
from dmil.errors import DemandError
from dmil.network import grid
from dmil.seeding import stream

HORIZON_S = 3600
NETWORK = grid(1, 1)


def levels(demand=None, highest=8.0, seed=0, **more):
    demand = demand or PoissonDemand()
    rng = stream(seed, "demand")
    return DemandLevels.draw(demand, NETWORK, HORIZON_S, highest, rng, **more)


def journeys(vehicles):
    return [(int(second), tuple(vehicles.route(v))) for v, second in enumerate(vehicles.depart_s)]


def contains(more, fewer):
    """Whether all journeys of some vehicles, in order, are among those of others."""
    left = iter(journeys(more))
    return all(each in left for each in journeys(fewer))


def test_a_higher_load_has_the_vehicles_of_a_lower_one():
    drawn = levels()
    loads = (0.5, 1.0, 3.7, 8.0)
    vehicles = [drawn.at(load) for load in loads]
    for fewer, more in pairwise(vehicles):
        assert len(fewer) < len(more)
        assert contains(more, fewer)
    assert len(drawn.at(0.0)) == 0


def test_a_load_has_the_arrivals_of_the_demand_at_that_load():
    counts = np.array([len(levels(seed=seed).at(3.0)) for seed in range(40)])
    expected = 3.0 * 27 * 60  # 27 vehicles per minute in the paper
    assert counts.mean() == pytest.approx(expected, rel=0.01)
    # Poisson: the variance is the mean; 40 seeds know it to about a fifth.
    assert 0.5 < counts.var(ddof=1) / expected < 1.7


def recorded():
    one = PoissonDemand().vehicles(NETWORK, 600, stream(0, "record"))
    return FileDemand(NETWORK, one)


def test_recorded_vehicles_come_at_a_steady_rate_over_the_whole_run():
    record = recorded()
    drawn = levels(record, highest=4.0, recorded_s=600).at(2.0)
    per_record = len(record.recorded)
    # An hour of a record of ten minutes at load 2 is twelve times the record.
    assert len(drawn) == pytest.approx(12 * per_record, rel=0.1)
    quarters = np.histogram(drawn.depart_s, bins=4, range=(0, HORIZON_S))[0]
    assert quarters.min() > 0.85 * quarters.mean()
    assert {route for _, route in journeys(drawn)} <= {
        route for _, route in journeys(record.recorded)
    }
    assert (np.diff(drawn.depart_s) >= 0).all()


def test_a_surge_is_more_of_the_same_for_a_while():
    drawn = levels()
    calm, surge = drawn.at(4.0), drawn.with_surge(4.0, 1.3, 900, 2100)
    assert contains(surge, calm)

    def within(vehicles):
        return int(((vehicles.depart_s >= 900) & (vehicles.depart_s < 2100)).sum())

    assert len(surge) - len(calm) == within(surge) - within(calm)
    assert within(surge) / within(calm) == pytest.approx(1.3, abs=0.06)


def test_loads_that_were_not_drawn_are_refused():
    drawn = levels()
    with pytest.raises(DemandError, match="the load is 9"):
        drawn.at(9.0)
    with pytest.raises(DemandError, match="the load is 10"):
        drawn.with_surge(8.0, 1.25, 0, 10)
    with pytest.raises(DemandError, match="at load 0"):
        levels(highest=0.0)
