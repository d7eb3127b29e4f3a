"""Where lanes lie: what a replay needs to put a vehicle on its lane."""

from dataclasses import replace

import numpy as np
import pytest

from dmil.network import grid
from dmil.network.geometry import LANE_M, RoadGeometry
from dmil.network.lines import along

ONE = grid(1, 1)


def test_a_vehicle_has_a_place_and_a_heading_on_its_lane_and_across():
    geometry, item = RoadGeometry(ONE), ONE.intersections[0]
    movement = next(each for each in item.movements if each.turn == "left")
    (lane,) = movement.lanes
    line = geometry.lane(movement.from_link, lane)
    (stopped,), (rad,) = along(line, np.array([np.hypot(*np.diff(line, axis=0).T).sum()]))
    assert stopped == pytest.approx(geometry.stop_line(movement.from_link, lane).mean(axis=0))
    (way,) = geometry.ways(movement)
    assert way[0] == pytest.approx(stopped)
    _, (turned,) = along(way, np.array([1e9]))
    assert (turned - rad) % (2 * np.pi) == pytest.approx(np.pi / 2, abs=0.05)


def test_a_files_line_to_the_stop_line_stays_and_one_between_nodes_makes_room():
    link = ONE.links[0]
    ends = [ONE.position_m[node] for node in (link.start, link.end)]
    bent = (ends[0], (ends[0][0] + 5.0, ends[0][1] + 50.0), ends[1])
    between = RoadGeometry(replace(ONE, line_m={link.id: bent}))
    assert len(between.line(link.id, 0.5)) == 3
    assert np.hypot(*(between.line(link.id, 0.0)[-1] - ends[1])) > 3 * LANE_M
    lane = tuple((x + 1.0, y + 1.0) for x, y in bent)
    assert RoadGeometry(replace(ONE, line_m={link.id: lane})).line(link.id, 0.5) == pytest.approx(
        np.array(lane)
    )
    straight = RoadGeometry(replace(ONE, line_m={link.id: lane}), straight=True)
    assert len(straight.course(link.id)) == 2


def test_links_without_a_length_in_the_plane_are_left_out():
    place = dict(ONE.position_m)
    link = ONE.links[0]
    place[link.start] = place[link.end]
    assert link.id not in RoadGeometry(replace(ONE, position_m=place)).links
    del place[link.start]
    assert link.id not in RoadGeometry(replace(ONE, position_m=place)).links
