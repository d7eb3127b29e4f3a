"""Prioritised replay: the tree of sums against a scan, its samples against their distribution."""

import numpy as np
import pytest

from dmil.errors import PolicyError
from dmil.memory.sum_tree import Priorities, sample_stratified, set_priorities
from dmil.seeding import stream


def plain_sample(priority, draws):
    """Go through the rows one after the other until the draw is used up."""
    rows = []
    for k, draw in enumerate(draws):
        rest = (k + draw) / len(draws) * sum(priority)
        row = 0
        while rest >= priority[row]:
            rest -= priority[row]
            row += 1
        rows.append(row)
    return rows


@pytest.mark.parametrize("capacity", [1, 2, 5, 64, 100])
def test_a_sample_is_that_of_a_scan(capacity):
    rng = stream(capacity, "tree")
    tree = Priorities(capacity, 1.0, 0.0)
    priority = np.zeros(capacity)
    for _ in range(30):
        rows = rng.integers(0, capacity, 6)
        # Multiples of a power of two, so that sums are exact in any order.
        priority[rows] = new = rng.integers(1, 1000, 6) / 64
        # Of one row named twice the last priority counts, as in an assignment of numpy.
        set_priorities(tree.sums, rows, new)
        assert tree.of(np.arange(capacity)).tolist() == priority.tolist()
        assert tree.sums[1] == priority.sum()
        draws, found = rng.integers(0, 64, 8) / 64, np.empty(8, np.int64)
        sample_stratified(tree.sums, draws, found)
        assert found.tolist() == plain_sample(priority, draws)


def test_rows_without_priority_are_never_found_not_even_at_the_very_end():
    rng, tree = stream(7), Priorities(1000, 1.0, 0.0)
    used = rng.choice(1000, 37, replace=False)
    set_priorities(tree.sums, used, rng.random(37) * 1e-3)
    found = np.empty(500, np.int64)
    for draws in (np.zeros(500), np.full(500, np.nextafter(1, 0)), rng.random(500)):
        sample_stratified(tree.sums, draws, found)
        assert np.isin(found, used).all()


def test_samples_are_distributed_as_numpys():
    rng, tree = stream(8), Priorities(20, 0.6, 1e-6)
    errors = rng.normal(size=20) * 5
    tree.update(np.arange(20), errors)
    chance = (np.abs(errors) + 1e-6) ** 0.6
    chance /= chance.sum()
    rows = np.concatenate([tree.sample(rng.random(32), 20, 0.4)[0] for _ in range(2000)])
    numpys = rng.choice(20, rows.size, p=chance)
    spread = np.sqrt(rows.size * chance * (1 - chance))
    for sample in (rows, numpys):
        off = (np.bincount(sample, minlength=20) - rows.size * chance) / spread
        assert np.abs(off).max() < 4
    # One draw in each of equal strata varies less than draws without strata.
    strata = (np.bincount(rows, minlength=20) - rows.size * chance) / spread
    assert (strata**2).mean() < 1


def test_weights_undo_the_preference():
    """Σ P·w·x over rows is the plain mean of x up to one factor, if β = 1 (Schaul, §3.4)."""
    rng, tree = stream(9), Priorities(6, 0.6, 1e-6)
    tree.update(np.arange(6), np.array([0.1, 0.5, 1.0, 2.0, 3.0, 8.0]))
    rows, weights = tree.sample((np.arange(32) + rng.random(32)) / 32, 6, 1.0)
    priority = tree.of(rows)
    assert weights.max() == 1.0
    assert np.allclose(weights, priority.min() / priority)
    assert np.allclose(tree.sample(rng.random(32), 6, 0.0)[1], 1.0)
    rows, weights = tree.sample(rng.random(32), 6, 0.4)
    by_hand = (6 * tree.of(rows) / tree.of(np.arange(6)).sum()) ** -0.4
    assert np.allclose(weights, by_hand / by_hand.max())


def test_new_rows_get_the_largest_priority_there_has_been():
    tree = Priorities(8, 0.5, 0.0)
    tree.add(np.array([0]))
    assert tree.of(np.array([0])) == 1.0
    tree.update(np.array([0]), np.array([-16.0]))
    assert tree.of(np.array([0])) == 4.0
    tree.update(np.array([0]), np.array([0.25]))
    tree.add(np.array([1]))
    assert tree.of(np.array([0, 1])).tolist() == [0.5, 4.0]


@pytest.mark.parametrize("size", [5, 13])
def test_a_restored_tree_has_the_same_bits(size):
    rng, old, new = stream(size), Priorities(13, 0.6, 1e-6), Priorities(13, 0.6, 1e-6)
    for _ in range(50):
        old.update(rng.integers(0, size, 4), rng.normal(size=4))
    new.add(np.arange(13))
    saved = old.arrays(size)
    new.restore(saved, size)
    assert new.sums.tobytes() == old.sums.tobytes()
    assert new.largest == old.largest
    for wrong in ({}, {**saved, "priority": saved["priority"][1:]}, {**saved, "largest": -1.0}):
        with pytest.raises(PolicyError):
            new.restore({k: np.asarray(v) for k, v in wrong.items()}, size)
