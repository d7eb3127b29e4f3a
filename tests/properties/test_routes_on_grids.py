"""Grids of any size, and routes on them against a plain twin."""

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dmil.demand import CompoundPoissonDemand, PoissonDemand
from dmil.demand.routes import router
from dmil.network import check_network, grid
from dmil.seeding import stream

SIZES = st.integers(1, 5)


@given(SIZES, SIZES)
def test_a_grid_has_as_many_links_and_nodes_as_it_must(rows, columns):
    network = grid(rows, columns)
    check_network(network)
    assert len(network.intersections) == rows * columns
    assert len(network.fringe) == 2 * (rows + columns)
    # Two links between neighbours, an entry and an exit at every fringe node.
    inner = 2 * (rows * (columns - 1) + columns * (rows - 1))
    assert len(network.links) == inner + 4 * (rows + columns)
    assert len(network.entry_links) == len(network.exit_links) == 2 * (rows + columns)
    assert all(len(node.movements) == 12 for node in network.intersections)
    assert len(network.movement_index) == 12 * rows * columns


def plain_times(network, origin):
    """Return (time, links) to every fringe node by repeated relaxation of all movements."""
    best = {
        k: (link.free_flow_time_s, 1)
        for k, link in enumerate(network.links)
        if link.start == origin
    }
    for _ in network.links:
        for start, end in network.movement_index:
            if start in best:
                time_s, links = best[start]
                longer = (time_s + network.links[end].free_flow_time_s, links + 1)
                best[end] = min(best.get(end, longer), longer)
    return {network.links[k].end: best[k] for k in network.exit_links if k in best}


@given(st.integers(1, 4), st.integers(1, 4), st.data())
def test_routes_are_shortest(rows, columns, data):
    network = grid(rows, columns)
    origin = data.draw(st.sampled_from(network.fringe))
    times = plain_times(network, origin)
    for destination in network.fringe:
        if destination == origin:
            continue
        found = router(network).between_nodes(origin, destination)
        assert sum(probability for _, probability in found) == pytest.approx(1.0)
        for route, _ in found:
            taken = sum(network.links[k].free_flow_time_s for k in route)
            assert (taken, len(route)) == pytest.approx(times[destination])


@given(st.integers(1, 4), st.integers(1, 4), st.data())
def test_routes_go_straight_on_while_that_is_as_short(rows, columns, data):
    network = grid(rows, columns)
    origin = data.draw(st.sampled_from(network.fringe))
    destination = data.draw(st.sampled_from([n for n in network.fringe if n != origin]))
    ends = [k for k in network.exit_links if network.links[k].end == destination]
    ways = router(network)
    for route, _ in ways.between_nodes(origin, destination):
        for place, (here, there) in enumerate(pairwise(route)):
            node, movement = network.movement_index[here, there]
            if network.intersections[node].movements[movement].turn == "straight":
                continue
            ahead = [link for link, turn in network.successors[here] if turn == "straight"]
            others = ways.between_links(ahead, ends)
            assert all(len(other) > len(route) - place - 1 for other, _ in others)


@given(
    st.integers(1, 4),
    st.integers(1, 4),
    st.integers(0, 2**32),
    st.sampled_from([PoissonDemand(), CompoundPoissonDemand(batch_veh=3.0)]),
)
def test_every_vehicle_can_drive_its_route(rows, columns, seed, demand):
    network = grid(rows, columns)
    vehicles = demand.vehicles(network, 60, stream(seed, "demand"))
    again = demand.vehicles(network, 60, stream(seed, "demand"))
    for name in ("depart_s", "route_offset", "route_links"):
        assert getattr(vehicles, name).tobytes() == getattr(again, name).tobytes()
    entries, exits = set(network.entry_links), set(network.exit_links)
    for vehicle in range(len(vehicles)):
        route = vehicles.route(vehicle).tolist()
        assert route[0] in entries
        assert route[-1] in exits
        assert network.links[route[0]].start != network.links[route[-1]].end
        assert all(pair in network.movement_index for pair in pairwise(route))
        assert len(set(route)) == len(route)
