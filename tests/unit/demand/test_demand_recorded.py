"""Recorded vehicles."""

import math
from dataclasses import replace

import numpy as np
import pytest

from dmil.demand import Demand, FileDemand, PoissonDemand, ProfileDemand, ScalableDemand
from dmil.demand.recorded import in_order, link_indices
from dmil.errors import DemandError
from dmil.network import grid
from dmil.network.model import Junction
from dmil.seeding import stream

NETWORK = grid(1, 2)
ACROSS = ["W0>0,0", "0,0>0,1", "0,1>E0"]
TURN = ["N0>0,0", "0,0>W0"]


def made(depart_s=(5, 2, 9), routes=(ACROSS, TURN, ACROSS)):
    return FileDemand.from_routes(NETWORK, depart_s, routes)


def test_vehicles_come_in_order_of_departure_on_their_routes():
    vehicles = made().vehicles(NETWORK, 100, stream(0))
    assert vehicles.depart_s.tolist() == [2, 5, 9]
    assert vehicles.route_offset.tolist() == [0, 2, 5, 8]
    assert [NETWORK.links[k].id for k in vehicles.route_links] == TURN + ACROSS + ACROSS


def test_a_route_may_begin_and_end_inside_the_network():
    vehicles = made(routes=(ACROSS[1:2], ACROSS[1:], TURN[:1])).vehicles(NETWORK, 9, stream(0))
    ids = [[NETWORK.links[k].id for k in vehicles.route(vehicle)] for vehicle in range(2)]
    assert ids == [["0,0>0,1", "0,1>E0"], ["0,0>0,1"]]


def test_a_route_may_lead_over_a_junction_without_signals():
    node = NETWORK.intersections[1]
    network = replace(
        NETWORK,
        intersections=NETWORK.intersections[:1],
        junctions=(Junction(node.id, node.movements),),
    )
    assert link_indices(network, ACROSS, where="here") == link_indices(
        NETWORK, ACROSS, where="here"
    )
    with pytest.raises(DemandError, match="no movement joins them"):
        link_indices(network, ["W0>0,0", "0,1>E0"], where="here")


def test_vehicles_keep_their_kind_when_they_are_sorted():
    vehicles = in_order(np.array([5.0, 2.0]), [[0], [1]], [7, 8])
    assert vehicles.kind is not None
    assert (vehicles.depart_s.tolist(), vehicles.kind.tolist()) == ([2, 5], [8, 7])


def test_parts_of_a_second_are_rounded_up():
    vehicles = made(depart_s=(0.2, 3.0, 2.999)).vehicles(NETWORK, 100, stream(0))
    assert vehicles.depart_s.tolist() == [1, 3, 3]


def test_vehicles_beyond_the_horizon_are_dropped_and_counted():
    demand = made()
    vehicles = demand.vehicles(NETWORK, 5, stream(0))
    assert (vehicles.depart_s.tolist(), vehicles.dropped) == ([2], 2)
    vehicles = demand.vehicles(NETWORK, 6, stream(0))
    assert (vehicles.depart_s.tolist(), vehicles.dropped) == ([2, 5], 1)


def test_the_record_is_the_same_for_every_seed_and_draws_nothing():
    rng, untouched = stream(1), stream(1)
    made().vehicles(NETWORK, 100, rng)
    assert rng.random() == untouched.random()


def test_there_may_be_no_vehicle():
    demand = FileDemand.from_routes(NETWORK, [], [])
    assert demand.last_departure_s == -1
    assert len(demand.vehicles(NETWORK, 10, stream(0))) == 0


def test_the_last_departure_is_known():
    assert made().last_departure_s == 9


def test_scaling_repeats_or_leaves_out_vehicles():
    assert isinstance(made(), Demand)
    assert isinstance(made(), ScalableDemand)
    twice = made().scaled(2.0).vehicles(NETWORK, 6, stream(0))
    assert (twice.depart_s.tolist(), twice.dropped) == ([2, 2, 5, 5], 2)
    assert [NETWORK.links[k].id for k in twice.route(3)] == ACROSS
    assert made().scaled(2.0).scaled(0.5).load == 1.0
    with pytest.raises(DemandError, match="the load is nan"):
        made().scaled(math.nan)


def test_the_network_must_be_that_of_the_routes():
    assert len(made().vehicles(grid(1, 2), 10, stream(0))) == 3
    with pytest.raises(DemandError, match=r"on the network 'grid:1x2', not on 'grid:2x1'"):
        made().vehicles(grid(2, 1), 10, stream(0))


def test_recorded_vehicles_have_no_rates_to_vary():
    with pytest.raises(DemandError, match="a FileDemand has no rates that could vary"):
        ProfileDemand(made(), [0], [1.0])


@pytest.mark.parametrize(
    ("depart_s", "routes", "message"),
    [
        ([1], [], "there are 1 departures and 0 routes"),
        ([0, -1], [TURN, TURN], r"vehicles\[1\]: it departs at -1 s"),
        ([math.nan], [TURN], r"vehicles\[0\]: it departs at nan s"),
        ([math.inf], [TURN], r"vehicles\[0\]: it departs at inf s"),
        ([0], [[]], r"vehicles\[0\]: its route is empty"),
        ([0], [["Z"]], r"vehicles\[0\]: its route is over 'Z', which the network does not have"),
        (
            [0, 0],
            [TURN, [ACROSS[0], ACROSS[2]]],
            r"vehicles\[1\]: its route goes from 'W0>0,0' to '0,1>E0', but no movement joins",
        ),
    ],
)
def test_an_impossible_vehicle_is_named(depart_s, routes, message):
    with pytest.raises(DemandError, match=message):
        FileDemand.from_routes(NETWORK, depart_s, routes)


@pytest.mark.parametrize("demand", [made(), PoissonDemand()])
def test_a_horizon_of_0_is_refused(demand):
    with pytest.raises(DemandError, match="the horizon is 0 s"):
        demand.vehicles(NETWORK, 0, stream(0))
