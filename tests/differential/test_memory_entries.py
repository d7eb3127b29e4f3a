"""Entries, episodic memory and neural dictionary against lists of keys and against scipy."""

from functools import reduce
from operator import add

import numpy as np
import pytest
from scipy.spatial import cKDTree

from dmil.errors import PolicyError
from dmil.memory.episodic import estimate, gather, keep_best, recall_mean, write_towards
from dmil.memory.neighbours import (
    find_key,
    find_nearest,
    insert,
    key_of,
    make_entries,
    make_neighbours,
    tick,
)
from dmil.memory.packing import pack_entries, unpack_entries
from dmil.memory.rows import ABSENT
from dmil.seeding import stream

TABLES = 3
KINDS = ["counts", "embeddings"]


class PlainEntries:
    """One table: a list of entries, changed in place when the oldest use makes room."""

    def __init__(self, capacity):
        self.capacity = capacity
        self.entries = []

    def index(self, key):
        found = [i for i, each in enumerate(self.entries) if (each["key"] == key).all()]
        return found[0] if found else None

    def nearest(self, key, count):
        return sorted((distance(each["key"], key), i) for i, each in enumerate(self.entries))[
            :count
        ]

    def insert(self, key, value, time):
        new = {"key": key, "value": value, "used": time}
        if len(self.entries) < self.capacity:
            self.entries.append(new)
        else:
            times = [each["used"] for each in self.entries]
            self.entries[times.index(min(times))] = new


def distance(one, other):
    """Add squares in single precision: four at a time, each pair by itself, then one by one."""
    squares = [(a - b) * (a - b) for a, b in zip(one, other, strict=True)]
    total, place = np.float32(0), 0
    while place + 4 <= len(squares):
        a, b, c, d = squares[place : place + 4]
        total, place = total + ((a + b) + (c + d)), place + 4
    for square in squares[place:]:
        total = total + square
    return total


def in_order(numbers):
    """Add numbers one after the other: from Python 3.12 on ``sum`` would correct the rounding."""
    return reduce(add, numbers)


class Twins:
    """Compiled tables and plain ones under one clock, told the same."""

    def __init__(self, places, capacity, neighbours):
        self.compiled = make_entries(TABLES, capacity, places)
        self.plain = [PlainEntries(capacity) for _ in range(TABLES)]
        self.nearest = make_neighbours(neighbours)
        self.time = 0

    def estimate(self, table, key, touches):
        plain = self.plain[table]
        self.time += touches
        index = plain.index(key)
        read = [index] if index is not None else [i for _, i in self.around(table, key)]
        for i in read if touches else []:
            plain.entries[i]["used"] = self.time
        expected = in_order(plain.entries[i]["value"] for i in read) / len(read)
        found = estimate(self.compiled, table, key, self.nearest, touches)
        assert found == (expected, index is not None)

    def keep_best(self, table, key, outcome):
        plain = self.plain[table]
        self.time += 1
        index = plain.index(key)
        if index is None:
            plain.insert(key, outcome, self.time)
        else:
            best = max(plain.entries[index]["value"], outcome)
            plain.entries[index].update(value=best, used=self.time)
        keep_best(self.compiled, table, key, outcome)

    def recall(self, table, key, touches):
        plain = self.plain[table]
        self.time += touches
        around = self.around(table, key)
        weights = [1.0 / (float(d) + 1e-3) for d, _ in around]
        total = in_order(
            w * plain.entries[i]["value"] for w, (_, i) in zip(weights, around, strict=True)
        )
        for _, i in around if touches else []:
            plain.entries[i]["used"] = self.time
        value, found = recall_mean(self.compiled, table, key, 1e-3, self.nearest, touches)
        assert found == len(around)
        assert self.nearest.entry[:found].tolist() == [i for _, i in around]
        assert value == total / in_order(weights)

    def write(self, table, key, outcome):
        plain = self.plain[table]
        index = plain.index(key)
        if index is None:
            self.time += 1
            plain.insert(key, outcome, self.time)
        else:
            value = plain.entries[index]["value"]
            plain.entries[index]["value"] = value + 0.1 * (outcome - value)
        write_towards(self.compiled, table, key, outcome, 0.1)

    def around(self, table, key):
        return self.plain[table].nearest(key, len(self.nearest.entry))

    def check(self):
        key = np.zeros(self.compiled.keys.shape[2], np.float32)
        assert self.compiled.clock[0] == self.time
        for table, plain in enumerate(self.plain):
            assert self.compiled.size[table] == len(plain.entries)
            for i, each in enumerate(plain.entries):
                key_of(self.compiled, table, i, key)
                assert key.tolist() == each["key"].tolist()
                assert self.compiled.value[table, i] == each["value"]
                assert self.compiled.used[table, i] == each["used"]
                assert find_key(self.compiled, table, each["key"]) == i


def keys_of(kind, rng, count, places):
    """Draw keys: counts recur and are often equally far; embeddings never are."""
    if kind == "counts":
        return rng.poisson(0.7, (count, places)).astype(np.float32)
    return rng.standard_normal((count, places)).astype(np.float32)


@pytest.mark.parametrize("capacity", [1, 5, 64, 100])
@pytest.mark.parametrize("places", [1, 4, 6, 11])
@pytest.mark.parametrize("kind", KINDS)
def test_episodic_memory_is_its_plain_twin(kind, places, capacity):
    rng = stream(capacity, "episodic", kind, places)
    twins = Twins(places, capacity, neighbours=7)
    for key in keys_of(kind, rng, 200, places):
        table = int(rng.integers(TABLES))
        if twins.plain[table].entries:
            twins.estimate(table, key, bool(rng.integers(2)))
        if rng.random() < 0.7:
            twins.keep_best(table, key, float(rng.standard_normal()))
    twins.check()


@pytest.mark.parametrize("capacity", [3, 64, 90])
@pytest.mark.parametrize("kind", KINDS)
def test_a_dictionary_is_its_plain_twin(kind, capacity):
    rng = stream(capacity, "dictionary", kind)
    twins = Twins(6, capacity, neighbours=20)
    known = []
    for key in keys_of(kind, rng, 250, 6):
        table = int(rng.integers(TABLES))
        if known and rng.random() < 0.3:
            key = known[int(rng.integers(len(known)))]
        if twins.plain[table].entries:
            twins.recall(table, key, bool(rng.integers(2)))
        if rng.random() < 0.7:
            twins.write(table, key, float(rng.standard_normal()))
            known.append(key)
    twins.check()


def test_what_is_gathered_are_the_neighbours():
    rng = stream(3, "gathered")
    twins = Twins(6, 100, neighbours=8)
    for table, count in ((0, 30), (2, 5)):
        for key in keys_of("embeddings", rng, count, 6):
            twins.write(table, key, float(rng.standard_normal()))
    tables = np.array([0, 2, 0, 2], np.int32)
    asked = keys_of("embeddings", rng, 4, 6)
    keys = np.zeros((4, 8, 6), np.float32)
    value, present = np.full((2, 4, 8), np.nan, np.float32)
    gather(twins.compiled, tables, asked, twins.nearest, keys, value, present)
    twins.time += 1
    for row, table in enumerate(tables.tolist()):
        entries = twins.plain[table].entries
        around = [entries[i] for _, i in twins.around(table, asked[row])]
        found = len(around)
        assert present[row].tolist() == [1.0] * found + [0.0] * (8 - found)
        assert keys[row, :found].tolist() == [each["key"].tolist() for each in around]
        assert value[row, :found].tolist() == [np.float32(each["value"]) for each in around]
        assert not value[row, found:].any()
        for each in around:
            each["used"] = twins.time
    assert present.sum(axis=1).tolist() == [8, 5, 8, 5]
    twins.check()


@pytest.mark.parametrize("kind", KINDS)
def test_neighbours_are_those_of_a_tree(kind):
    rng = stream(1, "tree", kind)
    entries, nearest = make_entries(1, 700, 8), make_neighbours(11)
    for key in keys_of(kind, rng, 700, 8) * np.float32(3):
        if find_key(entries, 0, key) == ABSENT:
            insert(entries, 0, key, 0.0, tick(entries))
    keys = pack_entries(entries)["keys"].astype(float)
    tree = cKDTree(keys)
    for key in keys_of(kind, rng, 50, 8) * np.float32(3):
        assert find_nearest(entries, 0, key, nearest) == 11
        expected, _ = tree.query(key.astype(float), 11)
        # Of equally far ones the tree may take others, so distances are compared.
        assert np.sqrt(nearest.distance.astype(float)) == pytest.approx(expected, rel=1e-6)
        off = keys[nearest.entry] - key.astype(float)
        assert np.linalg.norm(off, axis=1) == pytest.approx(expected, rel=1e-6)


def test_of_equally_near_entries_the_older_are_taken():
    entries, nearest = make_entries(1, 200, 2), make_neighbours(3)
    for place in range(150):
        insert(entries, 0, np.array([place % 2, place], np.float32), 0.0, 0)
    key = np.array([0, 100], np.float32)
    # Itself, then 98 and 102 at distance 4 behind 99 and 101 at distance 2.
    assert find_nearest(entries, 0, key, nearest) == 3
    assert nearest.entry.tolist() == [100, 99, 101]


def test_zero_and_its_negative_are_one_key():
    entries = make_entries(1, 10, 3)
    insert(entries, 0, np.array([0.0, 1.0, -0.0], np.float32), 0.0, 0)
    assert find_key(entries, 0, np.array([-0.0, 1.0, 0.0], np.float32)) == 0


def test_numbers_too_large_for_the_hash_are_found():
    entries = make_entries(1, 10, 2)
    for number in (1e30, -1e30, 3e38):
        key = np.array([number, 1.0], np.float32)
        assert find_key(entries, 0, key) == ABSENT
        entry = insert(entries, 0, key, 0.0, tick(entries))
        assert find_key(entries, 0, key) == entry


@pytest.mark.parametrize("kind", KINDS)
def test_a_restored_store_goes_on_as_the_saved_one(kind):
    rng = stream(2, "restored", kind)
    twins = Twins(5, 40, neighbours=4)

    def practise(count):
        for key in keys_of(kind, rng, count, 5):
            table = int(rng.integers(TABLES))
            twins.keep_best(table, key, float(rng.standard_normal()))
            twins.estimate(table, keys_of(kind, rng, 1, 5)[0], True)

    practise(200)
    arrays = pack_entries(twins.compiled)
    twins.compiled = unpack_entries(arrays, make_entries(TABLES, 40, 5))
    twins.check()
    assert all((pack_entries(twins.compiled)[name] == arrays[name]).all() for name in arrays)
    practise(200)
    twins.check()


def test_arrays_that_do_not_fit_are_refused():
    entries = make_entries(2, 10, 3)
    insert(entries, 1, np.ones(3, np.float32), 2.0, tick(entries))
    arrays = pack_entries(entries)
    with pytest.raises(PolicyError, match="at most 0"):
        unpack_entries(arrays, make_entries(2, 0, 3))
    with pytest.raises(PolicyError, match="'keys'"):
        unpack_entries(arrays, make_entries(2, 10, 4))
    with pytest.raises(PolicyError, match="'size'"):
        unpack_entries(arrays, make_entries(3, 10, 3))
    for name in arrays:
        with pytest.raises(PolicyError, match="missing"):
            unpack_entries({k: v for k, v in arrays.items() if k != name}, entries)
