"""The networks that parts are checked on are valid, and different enough."""

import numpy as np
import pytest

from dmil.network import check_network
from dmil.testing.proving_grounds import proving_grounds
from dmil.training import vehicles_of_seed


@pytest.mark.parametrize("ground", proving_grounds(), ids=lambda ground: ground.name)
def test_a_proving_ground_is_a_valid_scenario_with_traffic(ground):
    check_network(ground.network)
    vehicles = vehicles_of_seed(ground, 0)
    assert len(vehicles) > 50
    for item in ground.network.intersections:
        links = [ground.network.link_index[movement.from_link] for movement in item.movements]
        assert np.isin(links, vehicles.route_links).all(), "an approach without traffic"


def test_the_proving_grounds_differ_in_what_a_part_may_take_for_granted():
    grounds = proving_grounds()
    intersections = [item for ground in grounds for item in ground.network.intersections]
    assert {len(ground.network.intersections) for ground in grounds} == {1, 3, 6}
    assert {len(item.phases) for item in intersections} == {1, 2, 3, 8}
    assert {len(item.movements) for item in intersections} == {6, 8, 12}
    widths = {
        max(len(item.movements) for item in ground.network.intersections) for ground in grounds
    }
    assert widths == {8, 12}
    assert {ground.timing.decision_interval_s for ground in grounds} == {5, 10}
    assert any(ground.timing.min_green_s and ground.timing.clearance_s for ground in grounds)
