"""What stands where in the vectors, and the masks."""

import numpy as np
import pytest

from dmil.interop import VectorLayout
from dmil.simulation import Observation


@pytest.fixture
def tee_and_crossing(tee):
    """Two intersections that differ, and what is seen of them."""
    from dataclasses import replace

    small = replace(
        tee.intersections[0], id="small", movements=tee.intersections[0].movements[:4],
        phases=(frozenset({0, 3}), frozenset({1, 2})), unsignalled=frozenset(),
    )  # fmt: skip
    network = replace(tee, intersections=(tee.intersections[0], small))
    seen = Observation(
        queue_veh=np.array([[1, 2, 3, 4, 5, 6], [7, 8, 9, 10, 0, 0]], np.int32),
        approaching_veh=np.array([[6, 5, 4, 3, 2, 1], [1, 2, 3, 4, 0, 0]], np.int32),
        phase=np.array([2, -1], np.int32),
        phase_elapsed_s=np.array([15, 0], np.int32),
        time_s=40,
        waiting_veh=np.zeros((2, 6)),
    )
    return network, seen


def test_the_vector_of_an_intersection_holds_what_it_has(tee_and_crossing):
    network, seen = tee_and_crossing
    layout = VectorLayout(network, 10, padded=False)
    tee, small = layout.vectors(seen)
    assert tee.tolist() == [1, 2, 3, 4, 5, 6, 6, 5, 4, 3, 2, 1, 0, 0, 0, 1, 1.5]
    assert small.tolist() == [7, 8, 9, 10, 1, 2, 3, 4, 1, 0, 0, 0]
    assert tee.dtype == small.dtype == np.float32
    assert layout.actions == (3, 2)
    for i, vector in enumerate((tee, small)):
        assert layout.highest(i).shape == vector.shape
        assert (vector <= layout.highest(i)).all()


def test_padded_vectors_have_equal_places(tee_and_crossing):
    network, seen = tee_and_crossing
    layout = VectorLayout(network, 5, padded=True)
    tee, small = layout.vectors(seen)
    assert tee.tolist() == [1, 2, 3, 4, 5, 6, 6, 5, 4, 3, 2, 1, 0, 0, 0, 1, 3]
    assert small.tolist() == [7, 8, 9, 10, 0, 0, 1, 2, 3, 4, 0, 0, 1, 0, 0, 0, 0]
    assert layout.actions == (3, 3)
    assert [mask.tolist() for mask in layout.masks(seen)] == [[1, 1, 1], [1, 1, 0]]


def test_masks_keep_the_shortest_and_the_longest_green(tee_and_crossing):
    network, seen = tee_and_crossing
    layout = VectorLayout(network, 10, padded=False)

    def masks(*rules):
        return [mask.tolist() for mask in layout.masks(seen, *rules)]

    assert masks(15, 16) == [[1, 1, 1], [1, 1]]
    assert masks(16, 20) == [[0, 0, 1], [1, 1]]
    assert masks(5, 15) == [[1, 1, 0], [1, 1]]


def test_vectors_are_new_every_time(tee_and_crossing):
    network, seen = tee_and_crossing
    layout = VectorLayout(network, 10, padded=True)
    first, second = layout.vectors(seen), layout.vectors(seen)
    first[0][:] = 99
    assert second[0].max() < 99
    assert layout.vectors(seen)[0].max() < 99
