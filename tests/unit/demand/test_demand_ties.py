"""Equally short ways: straight on first, or a fair coin at every place."""

import hashlib
from collections import Counter
from fractions import Fraction
from itertools import product

import numpy as np
import pytest

from dmil.demand import CompoundPoissonDemand, PoissonDemand, ProfileDemand
from dmil.demand.destinations import draw_destinations, route_graph
from dmil.demand.routes import route_table
from dmil.errors import DemandError
from dmil.network import grid
from dmil.seeding import stream

DEMANDS = {
    "poisson": PoissonDemand(),
    "compound": CompoundPoissonDemand(batch_veh=3.0),
    "profile": ProfileDemand(PoissonDemand(), (0, 100), (0.5, 2.0), "linear"),
}
BEFORE = {
    "poisson": ("d7c997c4e4e4164f", "0aa4221611e67fc7", "a4eba824490f11ae"),
    "compound": ("7762160cd09f8187", "4fd5cf1e02ab6653", "c07e1c56f896d60b"),
    "profile": ("d75c86b4662cc702", "ef9a36c0fdbcafe3", "7437a103e845f237"),
}
"""Digests of the vehicles of seed 7 on 1×1, 3×3, 5×5, from before there was a choice."""


def digest(vehicles):
    arrays = (vehicles.depart_s, vehicles.route_offset, vehicles.route_links)
    whole = b"".join(array.tobytes() for array in arrays)
    return hashlib.blake2b(whole, digest_size=8).hexdigest()


def plain_costs(network, destination):
    """Return every link's (time in µs, links) to a fringe node by repeated relaxation."""
    own = [(round(link.free_flow_time_s * 1e6), 1) for link in network.links]
    best = {k: own[k] for k, link in enumerate(network.links) if link.end == destination}
    for _ in network.links:
        for k, following in enumerate(network.successors):
            for link, _ in following:
                if link in best and network.links[k].end != destination:
                    longer = (own[k][0] + best[link][0], own[k][1] + best[link][1])
                    best[k] = min(best.get(k, longer), longer)
    return best


def plain_choices(network, best, here, destination):
    """Return the links after one that lie on a shortest way, all links of a way's kind."""
    if network.links[here].end == destination:
        return []
    following = [link for link, _ in network.successors[here] if link in best]
    least = min(best[link] for link in following)
    return [link for link in following if best[link] == least]


def plain_routes(network, origin, destination):
    """Return every shortest route with its exact probability under a fair coin at every place."""
    best = plain_costs(network, destination)
    starts = [k for k in network.entry_links if network.links[k].start == origin and k in best]
    if not starts:
        return {}
    least = min(best[k] for k in starts)
    starts = [k for k in starts if best[k] == least]
    open_routes = [((k,), Fraction(1, len(starts))) for k in starts]
    found = {}
    while open_routes:
        route, probability = open_routes.pop()
        choices = plain_choices(network, best, route[-1], destination)
        if not choices:
            found[route] = probability
        open_routes += [((*route, k), probability / len(choices)) for k in choices]
    return found


def all_from(network, origin, count, seed=0):
    """Return the routes of many vehicles from one fringe node, by destination."""
    node = np.full(count, network.fringe.index(origin))
    vehicles = draw_destinations(network, np.zeros(count, int), node, stream(seed, "ties"), "coin")
    found = {}
    for v in range(count):
        route = tuple(vehicles.route(v).tolist())
        found.setdefault(network.links[route[-1]].end, Counter())[route] += 1
    return found


@pytest.mark.parametrize("name", DEMANDS)
def test_straight_on_first_is_the_default_and_gives_the_same_bytes_as_ever(name):
    for ties in (DEMANDS[name], DEMANDS[name].with_ties("straight")):
        found = [digest(ties.vehicles(grid(n, n), 300, stream(7, "demand"))) for n in (1, 3, 5)]
        assert tuple(found) == BEFORE[name]


@pytest.mark.parametrize("rows, columns", [(1, 1), (2, 3), (5, 5)])
def test_straight_on_first_leaves_one_way_per_pair_on_grids(rows, columns):
    table = route_table(grid(rows, columns))
    assert len(table.threshold) == table.pair_offset[-1]


def test_a_grid_has_more_equally_short_ways_than_can_be_listed():
    # From the west of the first row to the north of the last column there is one way only; to the
    # south of the last column there are as many as ways down a board of 5×5, C(8, 4) = 70.
    network = grid(5, 5)
    assert len(plain_routes(network, "W0", "S4")) == 70
    assert len(plain_routes(network, "W0", "N4")) == 1


@pytest.mark.parametrize("network", [grid(1, 1), grid(2, 3), grid(3, 3)], ids=lambda n: n.name)
def test_each_of_k_ways_on_has_the_chance_of_one_in_k(network):
    count = 4000
    for origin in network.fringe[:: max(1, len(network.fringe) // 4)]:
        for destination, routes in all_from(network, origin, count).items():
            exact = plain_routes(network, origin, destination)
            assert set(routes) <= set(exact)
            total = routes.total()
            for route, probability in exact.items():
                spread = float(total * probability * (1 - probability)) ** 0.5
                assert abs(routes[route] - total * probability) <= 5 * spread + 1


def test_vehicles_take_the_ways_that_plain_python_takes_with_the_same_coins():
    network = grid(4, 3)
    rng = stream(3, "nodes")
    origin = rng.integers(0, len(network.fringe), 300)
    vehicles = draw_destinations(network, np.zeros(300, int), origin, stream(3, "ties"), "coin")
    # The twin: destinations, then one coin per step for those that still drive, in their order.
    rng = stream(3, "ties")
    others = [[n for n in network.fringe if n != network.fringe[o]] for o in origin]
    first = np.arange(len(network.fringe)) * (len(network.fringe) - 1)
    pair = rng.integers(first[origin], first[origin] + len(network.fringe) - 1)
    goals = [others[v][pair[v] - first[origin[v]]] for v in range(300)]
    costs = {goal: plain_costs(network, goal) for goal in set(goals)}
    routes = [[] for _ in range(300)]
    choices = [
        [k for k in network.entry_links if network.links[k].start == network.fringe[o]]
        for o in origin
    ]
    driving = list(range(300))
    while driving:
        coins = rng.integers(np.array([len(choices[v]) for v in driving]))
        for v, coin in zip(driving, coins, strict=True):
            routes[v].append(choices[v][coin])
            choices[v] = plain_choices(network, costs[goals[v]], routes[v][-1], goals[v])
        driving = [v for v in driving if choices[v]]
    assert [vehicles.route(v).tolist() for v in range(300)] == routes


def test_the_coin_changes_ways_but_neither_who_comes_nor_where_to():
    network = grid(5, 5)
    for demand in DEMANDS.values():
        straight = demand.vehicles(network, 300, stream(1, "demand"))
        coin = demand.with_ties("coin").vehicles(network, 300, stream(1, "demand"))
        assert np.array_equal(straight.depart_s, coin.depart_s)
        # Both ways are shortest, so they are over equally many links.
        assert np.array_equal(straight.route_offset, coin.route_offset)
        ends = straight.route_offset[1:] - 1
        for place in (straight.route_offset[:-1], ends):
            assert np.array_equal(straight.route_links[place], coin.route_links[place])
        assert not np.array_equal(straight.route_links, coin.route_links)


def test_a_place_that_leads_nowhere_has_no_pairs(mixed_network):
    graph, table = route_graph(mixed_network), route_table(mixed_network)
    assert np.array_equal(graph.pair_offset, table.pair_offset)
    demand = PoissonDemand({"W": 60.0}, ties="coin")
    vehicles = demand.vehicles(mixed_network, 60, stream(0, "demand"))
    for v in range(len(vehicles)):
        route = vehicles.route(v).tolist()
        ends = mixed_network.links[route[0]].start, mixed_network.links[route[-1]].end
        assert tuple(route) in plain_routes(mixed_network, *ends)


def test_a_large_grid_needs_no_list_of_ways():
    network = grid(20, 20)
    vehicles = PoissonDemand(ties="coin").vehicles(network, 60, stream(0, "demand"))
    straight = PoissonDemand().vehicles(network, 60, stream(0, "demand"))
    assert np.array_equal(vehicles.route_offset, straight.route_offset)
    for v, place in product(range(0, len(vehicles), 50), (0, -1)):
        assert vehicles.route(v)[place] == straight.route(v)[place]


def test_nobody_comes_where_rates_are_zero():
    vehicles = PoissonDemand({"E": 0.0}, ties="coin").vehicles(grid(2, 2), 60, stream(0, "demand"))
    assert len(vehicles) == len(vehicles.route_links) == 0


@pytest.mark.parametrize("kind", [PoissonDemand, CompoundPoissonDemand])
def test_other_ties_are_refused(kind):
    with pytest.raises(DemandError, match="ties: they are 'left'; expected 'straight' or 'coin'"):
        kind(ties="left")
