"""Shortest routes and the rule for ties."""

import gc

import numpy as np
import pytest

from dmil.demand import PoissonDemand, routes
from dmil.demand.routes import MOST_ALTERNATIVES, route_table, router
from dmil.network import Intersection, Link, Movement, RoadNetwork, check_network, grid
from dmil.seeding import stream


def network_of(moves, lengths_m=None, *, name="ways"):
    """Make a network from movements (from link, to link, turn); links are named start-end."""
    ids = sorted({link for start, end, _ in moves for link in (start, end)})
    links = tuple(
        Link(link, *link.split("-"), (lengths_m or {}).get(link, 100.0), 10.0, 1) for link in ids
    )
    nodes = sorted({start.split("-")[1] for start, _, _ in moves})
    intersections = []
    for node in nodes:
        here = [move for move in moves if move[0].endswith(f"-{node}")]
        sides = sorted({start for start, _, _ in here})
        movements = tuple(
            Movement(start, end, turn, sides.index(start), (0,)) for start, end, turn in here
        )
        everything = frozenset(range(len(movements)))
        intersections.append(Intersection(node, movements, (everything,), frozenset()))
    ends = {end for link in links for end in (link.start, link.end)}
    fringe = tuple(sorted(ends - set(nodes)))
    network = RoadNetwork(
        name, links, tuple(intersections), fringe, {end: (0.0, 0.0) for end in ends}
    )
    check_network(network)
    return network


def diamond(*, straight=False, lengths_m=None):
    """From A to Z past L or R, which take equally long, and if wished straight on past M."""
    moves = [
        ("A-s", "s-l", "left"),
        ("A-s", "s-r", "right"),
        ("s-l", "l-e", "right"),
        ("s-r", "r-e", "left"),
        ("l-e", "e-Z", "right"),
        ("r-e", "e-Z", "left"),
    ]
    if straight:
        moves += [
            ("A-s", "s-m", "straight"),
            ("s-m", "m-e", "straight"),
            ("m-e", "e-Z", "straight"),
        ]
    return network_of(moves, lengths_m)


def ways(network, origin="A", destination="Z"):
    return {
        tuple(network.links[k].id for k in route): probability
        for route, probability in router(network).between_nodes(origin, destination)
    }


PAST_LEFT = ("A-s", "s-l", "l-e", "e-Z")
PAST_RIGHT = ("A-s", "s-r", "r-e", "e-Z")
PAST_MIDDLE = ("A-s", "s-m", "m-e", "e-Z")


def test_equally_short_turns_are_chosen_by_a_fair_coin():
    assert ways(diamond()) == {PAST_LEFT: 0.5, PAST_RIGHT: 0.5}


def test_straight_on_is_preferred_while_it_is_as_short():
    assert ways(diamond(straight=True)) == {PAST_MIDDLE: 1.0}


def test_straight_on_is_not_taken_where_it_is_longer():
    longer = diamond(straight=True, lengths_m={"s-m": 100.01})
    assert ways(longer) == {PAST_LEFT: 0.5, PAST_RIGHT: 0.5}


def test_the_shorter_way_wins_whatever_its_turns():
    assert ways(diamond(straight=True, lengths_m={"r-e": 99.0})) == {PAST_RIGHT: 1.0}


def test_of_equally_long_ways_the_one_over_fewer_links_is_shorter():
    # Past the middle there is one link less, and the others' first links take no time.
    network = network_of(
        [
            ("A-s", "s-l", "straight"),
            ("s-l", "l-e", "straight"),
            ("l-e", "e-Z", "straight"),
            ("A-s", "s-e", "right"),
            ("s-e", "e-Z", "left"),
        ],
        {"s-l": 0.0, "l-e": 100.0, "s-e": 100.0},
    )
    assert ways(network) == {("A-s", "s-e", "e-Z"): 1.0}


def test_only_movements_can_be_driven():
    # l-e reaches e, but there is no movement from it to e-Z: only from r-e.
    network = network_of(
        [
            ("A-s", "s-l", "left"),
            ("A-s", "s-r", "right"),
            ("s-l", "l-e", "right"),
            ("s-r", "r-e", "left"),
            ("r-e", "e-Z", "left"),
            ("l-e", "e-Y", "straight"),
        ],
        {"s-r": 1000.0},
    )
    assert ways(network) == {PAST_RIGHT: 1.0}
    assert ways(network, "Z", "A") == {}


def test_vehicles_follow_the_coin():
    network = diamond()
    vehicles = PoissonDemand({"A": 600.0}).vehicles(network, 400, stream(0, "coin"))
    middle = [network.links[vehicles.route(v)[1]].id for v in range(len(vehicles))]
    share = np.mean([link == "s-l" for link in middle])
    assert set(middle) == {"s-l", "s-r"}
    assert abs(share - 0.5) < 5 * 0.5 / np.sqrt(len(vehicles))


def test_many_ties_are_cut_and_still_every_route_is_shortest():
    # Eight diamonds in a row have 256 equally short ways.
    moves, before = [], "A-n0"
    for k in range(8):
        end = f"n{k + 1}"
        after = f"e{k}-{end}"
        for side, turn in (("l", "left"), ("r", "right")):
            first, second = f"n{k}-{side}{k}", f"{side}{k}-e{k}"
            moves += [(before, first, turn), (first, second, "straight"), (second, after, turn)]
        before = after
    moves.append((before, "n8-Z", "straight"))
    network = network_of(moves)
    found = ways(network)
    assert 8 < len(found) <= MOST_ALTERNATIVES
    assert {len(route) for route in found} == {1 + 3 * 8 + 1}
    assert sum(found.values()) == pytest.approx(1.0)


def test_the_table_numbers_pairs_origin_by_origin():
    network = grid(1, 1)
    table = route_table(network)
    assert table.pair_offset.tolist() == [0, 3, 6, 9, 12]
    assert table.threshold.tolist() == list(range(1, 13))
    first = table.links[table.link_offset[0] : table.link_offset[1]]
    assert [network.links[k].id for k in first] == ["E0>0,0", "0,0>N0"]


def test_a_table_is_computed_once_and_forgotten_with_its_network():
    network = grid(2, 4)
    assert route_table(network) is route_table(network)
    assert route_table(grid(2, 4)) is route_table(network)
    gc.collect()
    before = len(routes._TABLES)
    del network
    gc.collect()
    assert len(routes._TABLES) == before - 1


def test_one_shortest_route_takes_the_first_continuation_at_every_tie():
    network = diamond()
    index = network.link_index
    route = router(network).first_between([index["A-s"]], [index["e-Z"]])
    assert [network.links[k].id for k in route] == ["A-s", "s-l", "l-e", "e-Z"]
    assert route == router(network).between_links([index["A-s"]], [index["e-Z"]])[0][0]


def test_one_shortest_route_begins_at_the_nearest_start():
    network = diamond(lengths_m={"s-l": 500.0})
    index = network.link_index
    find = router(network).first_between
    assert find([index["s-l"], index["s-r"]], [index["e-Z"]])[0] == index["s-r"]
    assert find([index["e-Z"]], [index["e-Z"]]) == (index["e-Z"],)
    assert find([index["e-Z"]], [index["A-s"]]) == ()
    assert find([], [index["A-s"]]) == ()


def test_a_router_forgets_the_oldest_costs_and_finds_them_again(monkeypatch):
    network = diamond()
    index = network.link_index
    find = router(network).first_between
    whole = find([index["A-s"]], [index["e-Z"]])
    monkeypatch.setattr(routes, "MOST_KEPT", 0)
    assert find([index["A-s"]], [index["s-l"]])[-1] == index["s-l"]
    assert find([index["A-s"]], [index["e-Z"]]) == whole
    assert len(router(network)._remaining) == 1
