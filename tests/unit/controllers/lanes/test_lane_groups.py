"""Lane groups of small networks, by hand."""

from dataclasses import replace

import numpy as np
import pytest

from dmil.controllers import RunContext
from dmil.controllers.lanes.lane_groups import lane_groups
from dmil.network import Junction, Link, Movement, RoadNetwork, grid
from dmil.scenarios import QueueDynamics, SignalTiming
from dmil.seeding import stream


def groups_of(network, **dynamics):
    timing = SignalTiming(decision_interval_s=10)
    return lane_groups(RunContext(network, timing, stream(0), dynamics=QueueDynamics(**dynamics)))


def members(groups):
    """Return the movements of every group."""
    return [part.tolist() for part in np.split(groups.movements, groups.movement_offset[1:-1])]


def with_lanes(network, lanes):
    """Give the movements of the first intersection other lanes."""
    node = network.intersections[0]
    changed = (
        replace(movement, lanes=lanes.get(j, movement.lanes))
        for j, movement in enumerate(node.movements)
    )
    node = replace(node, movements=tuple(changed))
    return replace(network, intersections=(node, *network.intersections[1:]))


def test_the_papers_lanes_are_groups_of_their_own():
    network = grid(1, 2)
    groups = groups_of(network, saturation_flow_veh_per_s=0.5)
    signalled = [j for j in range(12) if j not in network.intersections[0].unsignalled]
    assert members(groups) == [[12 * i + j] for i in range(2) for j in signalled]
    assert groups.group_offset.tolist() == [0, 8, 16]
    assert groups.lanes.tolist() == [1.0] * 16
    assert groups.lane_veh.tolist() == [5.0] * 16
    assert groups.ways == 1
    as_block = groups.served.reshape(2, 8, 2).transpose(2, 1, 0)
    assert groups.served_block.tolist() == as_block.tolist()
    assert not groups.partly.any()
    # Two lanes a phase; with the right turns six may go.
    assert np.diff(groups.served_offset).tolist() == [2] * 16
    assert np.diff(groups.flow_offset).tolist() == [6] * 16
    between = [network.link_index[name] for name in ("0,0>0,1", "0,1>0,0")]
    nowhere = len(network.links)
    assert set(groups.ahead.tolist()) == {nowhere, *between}
    # 50 m at 10 m/s are half the interval; entries take no time.
    assert groups.unseen[between].tolist() == [0.5, 0.5]
    assert groups.unseen[nowhere] == 0.0
    assert set(groups.unseen[:nowhere].tolist()) == {0.5, 1.0}
    assert not groups.all_seen.any()
    fed = np.isin(groups.link, between)
    assert groups.unannounced.tolist() == np.where(fed, 0.0, 1.0).tolist()
    # Half of the 5 vehicles of an interval are in time.
    assert groups.in_time_veh.tolist() == np.where(groups.ahead == nowhere, 0.0, 2.5).tolist()


def test_movements_that_share_lanes_are_one_group():
    """Straight uses lanes 1 and 2, left lane 2: two lanes, left has half a lane."""
    network = with_lanes(grid(1, 1), {1: (1, 2)})
    groups = groups_of(network)
    assert members(groups)[0] == [1, 2]
    assert groups.lanes[0] == 2.0
    assert groups.link_share[0] == 1.0
    assert groups.ways == 2
    phases = network.intersections[0].phases
    for p, phase in enumerate(phases):
        place = groups.served_offset[p]
        if phase & {1, 2}:
            assert groups.served[place] == 0
            assert groups.partly[place] == (not phase >= {1, 2})
            assert groups.served_block[0, p, 0] == groups.lanes.size * groups.partly[place]


def test_the_block_is_padded_where_others_have_more():
    """Of two intersections the second has one phase fewer, and one phase that serves nobody."""
    network = grid(1, 2)
    first, second = network.intersections
    phases = (*second.phases[:-2], second.unsignalled)
    network = replace(network, intersections=(first, replace(second, phases=phases)))
    groups = groups_of(network)
    assert groups.served_block.shape == (2, 8, 2)
    nothing, no_phase = groups.lanes.size, groups.lanes.size + 1
    assert groups.served_block[:, 6, 1].tolist() == [nothing, nothing]
    assert groups.served_block[:, 7, 1].tolist() == [no_phase, nothing]
    rest = np.delete(groups.served_block.reshape(2, -1), [13, 15], axis=1)
    assert rest.max() < groups.lanes.size


def test_lanes_shared_through_a_third_movement_join_groups():
    network = with_lanes(grid(1, 1), {0: (0,), 1: (1,), 2: (2,)})
    node = network.intersections[0]
    assert 0 in node.unsignalled
    signalled = replace(node, unsignalled=node.unsignalled - {0})
    network = replace(network, intersections=(signalled,))
    assert members(groups_of(network))[:3] == [[0], [1], [2]]
    network = with_lanes(network, {0: (0, 1), 2: (1, 2)})
    assert members(groups_of(network))[0] == [0, 1, 2]


@pytest.mark.parametrize("ways", [1, 2])
def test_ahead_goes_on_across_junctions_while_there_is_one_way(ways):
    full = grid(1, 2)
    road = full.links[full.link_index["0,0>0,1"]]
    halves = (Link("in", road.start, "m", 20.0, 10.0, 3), Link("out", "m", road.end, 30.0, 10.0, 3))
    away = Link("away", "m", "X", 10.0, 10.0, 3)
    paths = [Movement("in", "out", "straight", 0, (0,)), Movement("in", "away", "left", 0, (1,))]
    renamed = tuple(
        replace(
            node,
            movements=tuple(
                replace(
                    move,
                    from_link={road.id: "out"}.get(move.from_link, move.from_link),
                    to_link={road.id: "in"}.get(move.to_link, move.to_link),
                )
                for move in node.movements
            ),
        )
        for node in full.intersections
    )
    links = (*(link for link in full.links if link is not road), *halves, away)
    network = RoadNetwork(
        "halved",
        links,
        renamed,
        (*full.fringe, "X"),
        full.position_m,
        (Junction("m", tuple(paths[:ways])),),
    )
    groups, out = groups_of(network), network.link_index["out"]
    eastward = [j for j, move in enumerate(renamed[0].movements) if move.to_link == "in"]
    assert len(eastward) == 3
    assert groups.ahead[eastward].tolist() == [out if ways == 1 else len(links)] * 3
    assert (groups.unannounced[groups.link == out] == 0.0).all() == (ways == 1)
