"""Rows whose keys are replaced: the index against a scan of all keys, after every change."""

import numpy as np
import pytest

from dmil.memory import ABSENT, append, clear, find, make_rows, replace
from dmil.memory.rows import rows_of
from dmil.seeding import stream

TURNS = np.array([[(place + 2 * turn) % 6 for place in range(6)] for turn in range(3)])


class Keys:
    """Rows beside a list of keys."""

    def __init__(self, tolerance, capacity, images):
        self.rows = make_rows(2, capacity, 6, tolerance)
        self.plain = [[], []]
        self.images = images

    def variants(self, key):
        moved = np.zeros((len(self.images), 6), np.int32)
        for variant, image in enumerate(self.images):
            moved[variant, image] = key
        return moved

    def find(self, owner, key):
        return find(self.rows, owner, self.variants(key), len(self.images))

    def scan(self, owner, key):
        known = np.array(self.plain[owner]).reshape(-1, 1, 6)
        off = np.abs(known - self.variants(key))
        near = np.argwhere(off.max(axis=2) <= self.rows.tolerance).tolist()
        candidates = [(int(off[row, variant].sum()), row, variant) for row, variant in near]
        return min(candidates)[1:] if candidates else (ABSENT, 0)


@pytest.mark.parametrize("most", [2, 5, 40])
@pytest.mark.parametrize("images", [TURNS[:1], TURNS], ids=["alone", "turns"])
@pytest.mark.parametrize("tolerance", [0, 1, 2, 9])
def test_a_look_up_is_a_scan_after_every_replacement(tolerance, images, most):
    rng = stream(most, "replaced", tolerance, len(images))
    # 70 rows: two words of bits, and a hash table with long runs of neighbours.
    keys, capacity = Keys(tolerance, 70, images), 70
    replaced, gone = 0, []
    for _ in range(700):
        owner = int(rng.integers(2))
        key = rng.integers(0, most + 1, 6).astype(np.int32)
        if keys.find(owner, key)[0] == ABSENT:
            if len(keys.plain[owner]) < capacity:
                append(keys.rows, owner, key)
                keys.plain[owner].append(key)
            else:
                row = int(rng.integers(capacity))
                gone.append((owner, keys.plain[owner][row]))
                replace(keys.rows, owner, row, key)
                keys.plain[owner][row] = key
                replaced += 1
        asked = [rng.integers(0, most + 1, 6), *keys.plain[owner][:1]]
        asked += [old for of, old in gone[-2:] if of == owner]
        for question in asked:
            assert keys.find(owner, question) == keys.scan(owner, question)
    # With few values or much tolerance all keys are near each other, and none is ever replaced.
    assert replaced > 50 or len(keys.plain[0]) < capacity
    for owner in (0, 1):
        for row, key in enumerate(keys.plain[owner]):
            assert keys.find(owner, key) == keys.scan(owner, key)
            assert keys.rows.keys[owner, row].tolist() == key.tolist()


@pytest.mark.parametrize("tolerance", [0, 1])
def test_replaced_rows_are_copied_and_cleared(tolerance):
    rng = stream(1, "replaced", "copied")
    keys = Keys(tolerance, 20, TURNS[:1])
    known = 100 * np.arange(40, dtype=np.int32)[:, None] + rng.integers(0, 9, (40, 6), np.int32)
    for key in known[:20]:
        append(keys.rows, 0, key)
    for row, key in enumerate(known[20:]):
        replace(keys.rows, 0, row, key)
    copies = rows_of(keys.rows, np.array([0, 0]), 50)
    for rows in (keys.rows, copies):
        for row, key in enumerate(known[20:]):
            assert find(rows, 0, key[None], 1) == (row, 0)
        for key in known[:20]:
            assert find(rows, 0, key[None], 1) == (ABSENT, 0)
    clear(keys.rows, 0)
    # No bit and no slot is left behind of keys that came second.
    assert not keys.rows.near.any()
    assert (keys.rows.slots == ABSENT).all()


def test_a_replaced_row_leaves_no_bit_behind():
    """Values that share a set, more than LEVELS apart, are told apart as before."""
    rows = make_rows(1, 3, 2, 1)
    append(rows, 0, np.array([3, 3], np.int32))
    append(rows, 0, np.array([19, 19], np.int32))
    replace(rows, 0, 0, np.array([35, 35], np.int32))
    for key, row in (([3, 3], ABSENT), ([19, 20], 1), ([36, 34], 0)):
        assert find(rows, 0, np.array([key], np.int32), 1)[0] == row
    # 2 rows × 2 places × 3 values.
    assert int(np.bitwise_count(rows.near).sum()) == 12
