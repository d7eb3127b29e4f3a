"""Days like a recorded one."""

from __future__ import annotations

import numpy as np
import pytest

from dmil.demand import FileDemand, ResampledDemand
from dmil.errors import DemandError
from dmil.network import grid
from dmil.seeding import stream

HORIZON_S = 600


@pytest.fixture
def recorded():
    network = grid(1, 1)
    ways = [
        [network.links[a].id, network.links[b].id]
        for a in range(len(network.links))
        for b, _ in network.successors[a]
    ]
    times = np.arange(300) * 2
    return FileDemand.from_routes(network, times, [ways[k % len(ways)] for k in range(300)])


def day_of(demand, seed):
    return demand.vehicles(demand.base.network, HORIZON_S, stream(seed, "demand"))


def test_a_day_has_as_many_vehicles_of_the_record_and_no_others(recorded):
    base = recorded.vehicles(recorded.network, HORIZON_S, stream(0))
    known = {(int(s), tuple(base.route(v))) for v, s in enumerate(base.depart_s)}
    day = day_of(ResampledDemand(recorded, shift_s=0), 1)
    drawn = [(int(s), tuple(day.route(v))) for v, s in enumerate(day.depart_s)]
    assert len(drawn) == len(base)
    assert set(drawn) < known
    assert (np.diff(day.depart_s) >= 0).all()


def test_departures_move_by_the_shift_at_most(recorded):
    still = day_of(ResampledDemand(recorded, shift_s=0), 2)
    moved = day_of(ResampledDemand(recorded, shift_s=30), 2)
    assert len(moved) == len(still)
    assert (np.abs(np.sort(moved.depart_s) - np.sort(still.depart_s)) <= 30).all()
    assert moved.depart_s.min() >= 0
    assert moved.depart_s.max() < HORIZON_S


def test_every_seed_has_a_day_of_its_own_and_always_the_same(recorded):
    demand = ResampledDemand(recorded)
    first, again, other = day_of(demand, 0), day_of(demand, 0), day_of(demand, 1)
    assert np.array_equal(first.depart_s, again.depart_s)
    assert np.array_equal(first.route_links, again.route_links)
    assert not np.array_equal(first.depart_s, other.depart_s)


def test_more_load_is_more_of_the_record(recorded):
    assert len(day_of(ResampledDemand(recorded).scaled(2.0), 0)) == 600


def test_nobody_stays_nobody():
    network = grid(1, 1)
    empty = ResampledDemand(FileDemand.from_routes(network, [], []))
    assert len(day_of(empty, 0)) == 0


def test_a_negative_shift_is_refused(recorded):
    with pytest.raises(DemandError, match="-5 s"):
        ResampledDemand(recorded, shift_s=-5)
