"""Hash and bit sets against a scan of all keys: nearest by L1, then oldest, then first variant."""

import numpy as np
import pytest

from dmil.memory import ABSENT, append, clear, find, make_rows
from dmil.memory.rows import LEVELS, copy_rows, is_short_of_room, larger_capacity, rows_of
from dmil.seeding import stream

ROTATIONS = [[(place + 3 * turn) % 12 for place in range(12)] for turn in range(4)]
IDENTITY = [list(range(12))]


class Table:
    """Compiled rows beside lists of keys, with one set of variants."""

    def __init__(self, tolerance, images, *, owners=2, capacity=4, parts=1):
        self.tolerance, self.images, self.parts = tolerance, np.array(images), parts
        self.rows = make_rows(owners, capacity, self.images.shape[1], tolerance, parts)
        self.plain = [[] for _ in range(owners)]

    def variants(self, key):
        moved = np.zeros(self.images.shape, np.int32)
        for variant, image in enumerate(self.images):
            moved[variant, image] = key
        return moved

    def find(self, owner, key):
        return find(self.rows, owner, self.variants(key), len(self.images))

    def scan(self, owner, key):
        if not self.plain[owner]:
            return ABSENT, 0
        off = np.abs(np.array(self.plain[owner])[:, None] - self.variants(key)[None])
        candidates = [
            (number, int(part[row, variant].sum()), row, variant)
            for number, part in enumerate(np.split(off, self.parts, axis=2))
            for row, variant in np.argwhere(part.max(axis=2) <= self.tolerance).tolist()
        ]
        return min(candidates)[2:] if candidates else (ABSENT, 0)

    def append(self, owner, key):
        if is_short_of_room(self.rows, 1):
            owners = np.arange(len(self.plain))
            self.rows = rows_of(self.rows, owners, larger_capacity(self.rows, 1))
        assert append(self.rows, owner, key) == len(self.plain[owner])
        self.plain[owner].append(key.tolist())


def keys_of(rng, count, most, places=12):
    """Draw keys whose places differ in how often they are zero, as lanes do."""
    busy = rng.random(places) * most
    return np.minimum(rng.poisson(busy, (count, places)), most).astype(np.int32)


@pytest.mark.parametrize("most", [2, 5, 40, 1000])
@pytest.mark.parametrize("images", [IDENTITY, ROTATIONS], ids=["alone", "rotations"])
@pytest.mark.parametrize("tolerance", [0, 1, 2, 20])
def test_a_look_up_is_a_scan(tolerance, images, most):
    rng = stream(most, "keys", tolerance)
    table = Table(tolerance, images)
    found = 0
    for owner, key in zip(rng.integers(0, 2, 400).tolist(), keys_of(rng, 400, most), strict=True):
        # A known key now and then, a little off and turned: scarce otherwise.
        if table.plain[owner] and rng.random() < 0.4:
            known = table.plain[owner][int(rng.integers(len(table.plain[owner])))]
            off = rng.integers(-tolerance, tolerance + 1, 12) * (rng.random(12) < 0.5)
            key = np.maximum(np.array(known) + off, 0).astype(np.int32)
            key = table.variants(key)[rng.integers(len(images))]
        answer = table.find(owner, key)
        assert answer == table.scan(owner, key)
        found += answer[0] != ABSENT
        if answer[0] == ABSENT:
            table.append(owner, key)
    assert found > 70


@pytest.mark.parametrize("tolerance", [0, 1, 2])
def test_a_look_up_is_a_scan_of_rows_near_each_other(tolerance):
    # First-come classes hold no two near keys; the table itself does not rely on that.
    rng = stream(1, "crowded")
    table = Table(tolerance, ROTATIONS, owners=1)
    for key in np.unique(keys_of(rng, 400, 2), axis=0):
        table.append(0, key)
    for key in keys_of(rng, 200, 3):
        assert table.find(0, key) == table.scan(0, key)


@pytest.mark.parametrize("most", [3, 40])
@pytest.mark.parametrize("images", [IDENTITY, ROTATIONS], ids=["alone", "rotations"])
def test_a_key_of_two_parts_is_looked_up_by_the_first_then_by_the_second(images, most):
    rng = stream(most, "parts", len(images))
    both = [[*image, *(12 + place for place in image)] for image in images]
    table = Table(1, both, owners=1, parts=2)
    found = {ABSENT: 0, 0: 0, 1: 0}
    for key in keys_of(rng, 500, most, 24):
        if table.plain[0] and rng.random() < 0.6:
            known = np.array(table.plain[0][int(rng.integers(len(table.plain[0])))])
            part = int(rng.integers(2))
            near = known[12 * part : 12 * part + 12] + rng.integers(-1, 2, 12)
            key[12 * part : 12 * part + 12] = np.maximum(near, 0)
            key = table.variants(key)[rng.integers(len(images))]
        answer = table.find(0, key)
        assert answer == table.scan(0, key)
        if answer[0] == ABSENT:
            table.append(0, key)
            found[ABSENT] += 1
        else:
            off = np.abs(np.array(table.plain[0][answer[0]]) - table.variants(key)[answer[1]])
            found[int(off[:12].max() > 1)] += 1
    assert min(found.values()) > 20


def test_of_two_variants_of_one_row_the_nearer_wins():
    table = Table(1, ROTATIONS, owners=1)
    stored = np.array([1, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 0], np.int32)
    table.append(0, stored)
    # As it is, it is 2 away; turned once it is the stored key itself.
    key = np.array([1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0], np.int32)
    assert table.variants(key)[1].tolist() == stored.tolist()
    assert table.find(0, key) == (0, 1)


@pytest.mark.parametrize("tolerance", [0, 1])
def test_values_that_share_a_set_are_told_apart(tolerance):
    table = Table(tolerance, IDENTITY, owners=1)
    for multiple in range(5):
        key = np.zeros(12, np.int32)
        key[3] = multiple * LEVELS
        assert table.find(0, key) == (ABSENT, 0)
        table.append(0, key)
    for multiple in range(5):
        key[3] = multiple * LEVELS
        assert table.find(0, key) == (multiple, 0)
        key[3] += 2
        assert table.find(0, key) == (ABSENT, 0)


@pytest.mark.parametrize("tolerance", [0, 1])
def test_owners_are_apart_through_growth_copies_and_clearing(tolerance):
    rng = stream(2, "owners")
    table = Table(tolerance, IDENTITY, owners=3)

    def check():
        for owner in range(len(table.plain)):
            for key in [*map(np.int32, table.plain[owner]), *keys_of(rng, 20, 3)]:
                assert table.find(owner, key) == table.scan(owner, key)

    def fill(owner, count):
        for key in keys_of(rng, count, 4):
            if table.find(owner, key)[0] == ABSENT:
                table.append(owner, key)

    fill(0, 70)
    fill(2, 30)
    check()
    clear(table.rows, 0)
    table.plain[0] = []
    check()
    fill(0, 20)
    fill(1, 70)
    check()
    # The goal had more rows than the source.
    copy_rows(table.rows, 2, 1)
    table.plain[1] = list(table.plain[2])
    fill(1, 40)
    check()
    table.rows = rows_of(table.rows, np.array([1, 1, 0]), int(table.rows.size.max()) + 1)
    table.plain = [list(table.plain[owner]) for owner in (1, 1, 0)]
    check()
    fill(0, 60)
    check()


def test_a_row_stands_in_the_sets_of_just_the_values_near_its_key():
    table = Table(1, IDENTITY, owners=2)
    rng = stream(3, "sets")
    for key in keys_of(rng, 300, 30):
        if table.find(1, key)[0] == ABSENT:
            table.append(1, key)
    near = table.rows.near
    assert not near[0].any()
    bits = np.unpackbits(near[1].view(np.uint8), axis=-1, bitorder="little").astype(bool)
    size = len(table.plain[1])
    assert not bits[..., size:].any()
    for row, key in enumerate(table.plain[1]):
        for place, value in enumerate(key):
            levels = {(value + off) % LEVELS for off in (-1, 0, 1)}
            assert set(np.flatnonzero(bits[place, :, row]).tolist()) == levels


def test_a_hash_table_is_at_most_half_full():
    for capacity in (1, 2, 3, 63, 64, 65, 1000):
        slots = make_rows(1, capacity, 12, 0).slots.shape[1]
        assert slots >= 2 * capacity
        assert slots & (slots - 1) == 0
