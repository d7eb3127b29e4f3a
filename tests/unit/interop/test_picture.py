"""Pictures: what is drawn where and in which colour."""

from dataclasses import replace

import numpy as np
import pytest

from dmil.interop import parallel_env
from dmil.interop.picture import COMING, GREEN, RED, Picture
from dmil.network import grid
from dmil.simulation import Observation


def seen(network, queue=(), approaching=(), phase=-1):
    """An observation of a network: {(intersection, movement): vehicles}."""
    count = len(network.intersections)
    shape = count, max(len(item.movements) for item in network.intersections)
    found = Observation(
        np.zeros(shape, np.int32),
        np.zeros(shape, np.int32),
        np.full(count, phase, np.int32),
        np.zeros(count, np.int32),
        0,
        np.zeros(shape),
    )
    for place, vehicles in dict(queue).items():
        found.queue_veh[place] = vehicles
    for place, vehicles in dict(approaching).items():
        found.approaching_veh[place] = vehicles
    return found


def painted(picture, colour):
    """Where a picture has a colour, its header left out: (points, 2), x and y."""
    wanted = [int(colour[i : i + 2], 16) for i in (1, 3, 5)]
    rows, columns = np.nonzero((picture == wanted).all(axis=2))
    inside = rows > 56
    return np.column_stack([columns[inside], rows[inside]])


def test_a_queue_stands_on_its_side_and_grows_backwards():
    network = grid(1, 1)
    picture = Picture(network)
    short = painted(picture.draw(seen(network, {(0, 1): 2}), "a"), RED)
    long = painted(picture.draw(seen(network, {(0, 1): 6}), "a"), RED)
    middle = np.array([720, 720]) / 2 + (0, 56)
    # Movement 1 comes from the East: to the right of the middle, driving on the right, so above it.
    assert (short[:, 0] > middle[0]).all()
    assert (short[:, 1] < middle[1]).all()
    assert len(long) == pytest.approx(3 * len(short), rel=0.1)
    assert long[:, 0].min() == short[:, 0].min()
    assert long[:, 0].max() > short[:, 0].max()


def test_colours_tell_red_from_green_and_who_approaches():
    network = grid(1, 1)
    picture = Picture(network)
    drawn = picture.draw(seen(network, {(0, 1): 3, (0, 4): 3}, {(0, 7): 2}, phase=0), "a")
    assert len(painted(drawn, RED)) > 0
    assert len(painted(drawn, GREEN)) > len(painted(drawn, RED))
    assert len(painted(drawn, COMING)) > 0
    # Phase 2 serves movement 4 and not 1: the same queues change colours.
    other = picture.draw(seen(network, {(0, 1): 3}, phase=2), "a")
    assert (painted(other, RED)[:, 0] > 360).all()


def test_a_queue_longer_than_its_link_stays_on_it():
    network = grid(1, 2)
    drawn = Picture(network).draw(seen(network, {(0, 1): 500}), "a")
    place = painted(drawn, RED)
    between = 720 * 0.35, 720 * 0.65
    assert (place[:, 0] > between[0]).all()
    assert (place[:, 0] < between[1]).all()


def test_networks_of_all_shapes_fit():
    for network in (grid(1, 6), grid(6, 1), grid(7, 7)):
        drawn = Picture(network).draw(seen(network, phase=0), network.name)
        assert drawn.dtype == np.uint8
        assert drawn.shape[2] == 3
        assert max(drawn.shape) <= 1136
        assert len(painted(drawn, GREEN)) > 0


def test_links_without_a_length_in_the_picture_are_left_out(mixed_network):
    nowhere = replace(mixed_network, position_m=dict.fromkeys(mixed_network.position_m, (3.0, 3.0)))
    drawn = Picture(nowhere).draw(seen(nowhere, {(0, 0): 9}, phase=0), "a")
    assert len(painted(drawn, RED)) == 0
    gone = {name: xy for name, xy in mixed_network.position_m.items() if name != "N0"}
    assert Picture(replace(mixed_network, position_m=gone)).draw(seen(nowhere), "a").any()


def test_an_environment_renders_what_is_seen_now():
    made = parallel_env("grid:2x2", render_mode="rgb_array", load=3)
    assert made.metadata["render_fps"] > 0
    made.reset(seed=0)
    first = made.render()
    made.step(dict.fromkeys(made.agents, 0))
    second = made.render()
    assert first.shape == second.shape
    assert len(painted(first, RED)) == 0
    assert len(painted(second, RED)) > 0
