"""Derived tables and the shape signature."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

from dmil.network import Program, Stage, exit_sides, grid, shape_signature


def test_indices_point_at_their_objects():
    network = grid(2, 2)
    assert all(network.links[i].id == name for name, i in network.link_index.items())
    assert all(
        network.intersections[i].id == name for name, i in network.intersection_index.items()
    )
    assert len(network.link_index) == len(network.links)
    for (start, end), (i, j) in network.movement_index.items():
        movement = network.intersections[i].movements[j]
        assert (movement.from_link, movement.to_link) == (
            network.links[start].id,
            network.links[end].id,
        )


def test_entry_and_exit_links_touch_the_fringe():
    network = grid(2, 1)
    assert [network.links[i].start for i in network.entry_links] == [
        node for node in ("E0", "N0", "W0", "E1", "W1", "S0")
    ]
    assert {network.links[i].end for i in network.exit_links} == set(network.fringe)


def test_successors_are_the_movements():
    network = grid(1, 2)
    pairs = {(start, end) for start, ends in enumerate(network.successors) for end, _ in ends}
    assert pairs == set(network.movement_index)


def test_travel_times_cannot_be_changed():
    with pytest.raises(ValueError, match="read-only"):
        grid(1, 1).free_flow_time_s[0] = 1.0


def test_networks_are_equal_by_value_and_survive_the_way_to_another_process():
    network = grid(2, 2)
    assert network == grid(2, 2)
    assert hash(network) == hash(grid(2, 2))
    assert network != grid(2, 3)
    assert network.entry_links  # a filled cache must not change the copy
    copy = pickle.loads(pickle.dumps(network))
    assert copy == network
    np.testing.assert_array_equal(copy.free_flow_time_s, network.free_flow_time_s)


def test_the_signature_sees_shape_only():
    node = grid(1, 1).intersections[0]
    same = replace(
        node,
        id="another",
        program=Program((Stage(9.0, node.phases[0]),)),
        phase_names=(),
        clearance_s=3.0,
    )
    assert shape_signature(same) == shape_signature(node)
    narrower = replace(node, movements=tuple(replace(m, lanes=(0,)) for m in node.movements))
    assert shape_signature(narrower) == shape_signature(node)


@pytest.mark.parametrize(
    "change",
    [
        {"phases": grid(1, 1).intersections[0].phases[:7]},
        {"phases": grid(1, 1).intersections[0].phases[::-1]},
        {"unsignalled": frozenset()},
        {"movements": grid(1, 1).intersections[0].movements[:11]},
    ],
)
def test_the_signature_sees_every_part_of_the_shape(change):
    node = grid(1, 1).intersections[0]
    assert shape_signature(replace(node, **change)) != shape_signature(node)


def test_a_side_that_only_leads_away_gets_the_next_number():
    network = grid(1, 1)
    node = network.intersections[0]
    # Nobody comes from the South any more, but the way there is still open.
    kept = replace(node, movements=node.movements[:9])
    assert exit_sides(network, kept) == (1, 2, 3, 2, 3, 0, 3, 0, 1)
