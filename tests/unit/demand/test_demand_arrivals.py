"""Arrival processes: what they accept, what they draw."""

import math

import numpy as np
import pytest

from dmil.demand import (
    PAPER_RATE_VEH_PER_MIN,
    CompoundPoissonDemand,
    Demand,
    PoissonDemand,
    ProfileDemand,
    ScalableDemand,
)
from dmil.demand.destinations import rates_at_fringe
from dmil.errors import DemandError, UnknownNameError
from dmil.network import Intersection, Link, Movement, RoadNetwork, check_network, grid
from dmil.seeding import stream


def one_way_street(names=("W", "E")):
    """One junction that can only be crossed from the first to the second node."""
    first, second = names
    network = RoadNetwork(
        "street",
        (Link("in", first, "c", 100.0, 10.0, 1), Link("out", "c", second, 100.0, 10.0, 1)),
        (
            Intersection(
                "c", (Movement("in", "out", "straight", 0, (0,)),), (frozenset({0}),), frozenset()
            ),
        ),
        names,
        {first: (-100.0, 0.0), "c": (0.0, 0.0), second: (100.0, 0.0)},
    )
    check_network(network)
    return network


PROCESSES = {
    "poisson": PoissonDemand(),
    "batches": CompoundPoissonDemand(),
    "given batches": CompoundPoissonDemand(batch_veh={1: 0.5, 3: 0.5}),
    "profile": ProfileDemand(PoissonDemand(), [0, 50], [0.5, 2.0], "linear"),
}


@pytest.fixture(params=PROCESSES.values(), ids=PROCESSES)
def process(request):
    return request.param


def test_processes_are_demands_that_can_be_scaled(process):
    assert isinstance(process, Demand)
    assert isinstance(process, ScalableDemand)


def test_the_same_seed_gives_the_same_bytes(process):
    def drawn(seed):
        vehicles = process.vehicles(grid(2, 3), 120, stream(seed, "demand"))
        return tuple(
            array.tobytes()
            for array in (vehicles.depart_s, vehicles.route_offset, vehicles.route_links)
        )

    assert drawn(1) == drawn(1)
    assert drawn(1) != drawn(2)


def test_arrays_are_as_promised(process):
    network = grid(2, 2)
    vehicles = process.vehicles(network, 200, stream(3))
    assert {a.dtype for a in (vehicles.depart_s, vehicles.route_offset, vehicles.route_links)} == {
        np.dtype(np.int32)
    }
    assert len(vehicles) > 50
    assert vehicles.route_offset[0] == 0
    assert vehicles.route_offset[-1] == len(vehicles.route_links)
    assert (np.diff(vehicles.route_offset) >= 2).all()
    assert (np.diff(vehicles.depart_s) >= 0).all()
    assert vehicles.depart_s[0] >= 0
    assert vehicles.depart_s[-1] < 200
    assert vehicles.dropped == 0


def test_no_load_means_no_vehicles(process):
    vehicles = process.scaled(0.0).vehicles(grid(1, 1), 500, stream(0))
    assert len(vehicles) == 0
    assert vehicles.route_offset.tolist() == [0]


def test_the_papers_rates_are_the_default_and_belong_to_the_sides():
    assert PAPER_RATE_VEH_PER_MIN == {"E": 5.0, "N": 5.0, "W": 10.0, "S": 7.0}
    rates = rates_at_fringe(grid(2, 1), PAPER_RATE_VEH_PER_MIN)
    assert rates.tolist() == [5.0, 5.0, 5.0, 10.0, 10.0, 7.0]


def test_a_nodes_own_rate_comes_before_its_sides():
    rates = rates_at_fringe(grid(2, 1), {"E": 6.0, "E1": 1.0})
    assert rates.tolist() == [6.0, 1.0, 0.0, 0.0, 0.0, 0.0]


def test_any_network_can_have_rates_by_fringe_node():
    network = one_way_street(("Einfahrt", "exit"))
    vehicles = PoissonDemand({"Einfahrt": 30.0}).vehicles(network, 100, stream(0))
    assert len(vehicles) > 20
    assert {tuple(vehicles.route(v).tolist()) for v in range(len(vehicles))} == {(0, 1)}
    # "Einfahrt" begins with an E but is no side of a grid.
    with pytest.raises(UnknownNameError, match="no fringe node or side named 'E'"):
        PoissonDemand({"E": 30.0}).vehicles(network, 100, stream(0))


def test_vehicles_of_a_batch_come_together():
    demand = CompoundPoissonDemand({"W": 6.0}, batch_veh={7: 1.0})
    network = grid(1, 1)
    vehicles = demand.vehicles(network, 600, stream(5))
    _, together = np.unique(vehicles.depart_s, return_counts=True)
    assert (together % 7 == 0).all()
    first = {network.links[vehicles.route(v)[0]].start for v in range(len(vehicles))}
    last = {network.links[vehicles.route(v)[-1]].end for v in range(len(vehicles))}
    assert first == {"W0"}
    assert last == {"E0", "N0", "S0"}


def test_batches_of_one_are_a_poisson_demand():
    assert CompoundPoissonDemand(batch_veh={1: 1.0}).mean_batch_veh == 1.0
    slots = CompoundPoissonDemand(batch_veh=1.0).arrivals(grid(1, 1), np.ones(300), stream(4))
    poisson = PoissonDemand().arrivals(grid(1, 1), np.ones(300), stream(4))
    np.testing.assert_array_equal(slots, poisson)


@pytest.mark.parametrize(
    ("between", "expected"),
    [("step", [2.0, 2.0, 0.0, 0.0, 4.0, 4.0]), ("linear", [2.0, 1.0, 0.0, 2.0, 4.0, 4.0])],
)
def test_profiles_step_or_run_straight_between_their_times(between, expected):
    profile = ProfileDemand(PoissonDemand(), [0, 20, 40], [2.0, 0.0, 4.0], between)
    assert profile.at(np.array([0, 10, 20, 30, 40, 1000])).tolist() == expected


def test_a_profile_of_ones_changes_nothing_and_profiles_multiply():
    network = grid(1, 2)
    plain = PoissonDemand().arrivals(network, np.ones(100), stream(0))
    ones = ProfileDemand(PoissonDemand(), [0], [1.0])
    np.testing.assert_array_equal(ones.arrivals(network, np.ones(100), stream(0)), plain)
    nested = ProfileDemand(ProfileDemand(PoissonDemand(), [0], [0.5]), [0], [2.0])
    np.testing.assert_array_equal(nested.arrivals(network, np.ones(100), stream(0)), plain)


def test_nobody_comes_while_the_multiplier_is_zero():
    profile = ProfileDemand(PoissonDemand(), [0, 100, 200], [1.0, 0.0, 1.0])
    depart_s = profile.vehicles(grid(2, 2), 300, stream(1)).depart_s
    assert not ((depart_s >= 100) & (depart_s < 200)).any()
    assert (depart_s < 100).any()
    assert (depart_s >= 200).any()


def test_scaling_multiplies_the_rates():
    assert PoissonDemand({"E": 4.0}).scaled(1.5) == PoissonDemand({"E": 6.0})
    batches = CompoundPoissonDemand({"E": 4.0}, {2: 1.0})
    assert batches.scaled(0.5) == CompoundPoissonDemand({"E": 2.0}, {2: 1.0})
    profile = ProfileDemand(PoissonDemand({"E": 4.0}), [0], [3.0])
    assert profile.scaled(2.0) == ProfileDemand(PoissonDemand({"E": 8.0}), [0], [3.0])


@pytest.mark.parametrize("load", [-0.1, math.nan, math.inf])
def test_a_load_that_is_no_number_of_0_or_more_is_refused(process, load):
    with pytest.raises(DemandError, match="load: the load is"):
        process.scaled(load)


@pytest.mark.parametrize("kind", [PoissonDemand, CompoundPoissonDemand])
@pytest.mark.parametrize(
    ("rates", "message"),
    [
        ({}, "there are no rates.*Write for example"),
        ({"E": -1.0}, r"rate_veh_per_min\['E'\]: the rate is -1.0 vehicles per minute"),
        ({"W": 1.0, "E": math.nan}, r"\['E'\]: the rate is nan"),
        ({"E": math.inf}, r"\['E'\]: the rate is inf.*expected a number of 0 or more"),
    ],
)
def test_rates_that_are_no_rates_are_refused(kind, rates, message):
    with pytest.raises(DemandError, match=message):
        kind(rates)


@pytest.mark.parametrize("horizon_s", [0, -5, 2.5, True, "300"])
def test_a_horizon_that_is_no_positive_whole_number_is_refused(process, horizon_s):
    with pytest.raises(DemandError, match=r"the horizon is .* expected a whole number above 0"):
        process.vehicles(grid(1, 1), horizon_s, stream(0))


def test_a_rate_for_a_node_that_is_not_there_is_refused():
    with pytest.raises(UnknownNameError, match="no fringe node or side named 'E7'"):
        PoissonDemand({"E7": 1.0}).vehicles(grid(2, 2), 10, stream(0))


def test_a_network_with_one_fringe_node_is_refused():
    street = one_way_street()
    network = RoadNetwork("stub", street.links, street.intersections, ("W",), street.position_m)
    with pytest.raises(
        DemandError, match="stub: the network has 1 fringe nodes; expected at least"
    ):
        PoissonDemand({"W": 1.0}).vehicles(network, 10, stream(0))


def test_a_rate_where_no_way_leads_anywhere_is_refused():
    with pytest.raises(DemandError, match=r"starting at 'E' can reach no other.*Set the rate of"):
        PoissonDemand({"W": 1.0, "E": 1.0}).vehicles(one_way_street(), 10, stream(0))
    assert len(PoissonDemand({"W": 60.0, "E": 0.0}).vehicles(one_way_street(), 60, stream(0))) > 20


@pytest.mark.parametrize(
    "batch",
    [0.5, math.nan, math.inf, {}, {0: 1.0}, {1: 0.5}, {1: 1.5, 2: -0.5}, {1.5: 1.0}, {1: math.nan}],
)
def test_a_batch_distribution_that_is_none_is_refused(batch):
    with pytest.raises(DemandError, match="batch_veh: the"):
        CompoundPoissonDemand(batch_veh=batch)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"time_s": [], "multiplier": []}, "there are 0 times and 0 multipliers"),
        ({"time_s": [0, 1], "multiplier": [1]}, "there are 2 times and 1 multipliers"),
        ({"time_s": [1], "multiplier": [1]}, "expected increasing seconds, the first 0"),
        ({"time_s": [0, 5, 5], "multiplier": [1, 1, 1]}, "expected increasing seconds"),
        ({"time_s": [0, math.nan], "multiplier": [1, 1]}, "expected increasing seconds"),
        ({"time_s": [0], "multiplier": [-1]}, "multiplier: .*expected numbers of 0 or more"),
        ({"time_s": [0], "multiplier": [math.inf]}, "multiplier: .*numbers of 0 or more"),
        ({"time_s": [0], "multiplier": [1], "between": "curve"}, "between: it is 'curve'"),
    ],
)
def test_a_profile_that_is_none_is_refused(options, message):
    with pytest.raises(DemandError, match=message):
        ProfileDemand(PoissonDemand(), **options)
