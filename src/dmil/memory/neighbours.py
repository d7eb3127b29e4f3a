"""Entries found by their key or by its neighbours: what episodic memories are made of.

A store holds several tables. An entry is a key (a vector of numbers), a value, and the time of its
last use; keys of one table differ. A full table gives the place of its least recently used entry to
the next new one. A key is found by hashing; its nearest neighbours are found by comparing all keys,
64 at a time and place by place, so that the processor compares several at once.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dmil.arrays import FloatArray, IntArray
from dmil.compilation import kernel
from dmil.memory.rows import ABSENT

KeyArray = npt.NDArray[np.float32]
TimeArray = npt.NDArray[np.int64]

BLOCK = 64
"""Keys that are compared at once: their distances stay in the processor's nearest cache."""
UNROLLED = 4
"""Places whose squares are added before the sum is stored."""
HASH_STEPS = 65536.0
HASH_RANGE = 1e9


class Entries(NamedTuple):
    """All tables of a store.

    Attributes
    ----------
    size: (tables,) int32
        Entries in use.
    keys: (tables, blocks, places, BLOCK) float32
        Entry e of a table has its key in block e // BLOCK, column e % BLOCK.
    value: (tables, capacity) float64
    used: (tables, capacity) int64
        When an entry was last used, by the clock.
    clock: (1,) int64
        Uses so far.
    first: (tables, power of two) int32
        First entry of every chain of the hash table, or `ABSENT`.
    following: (tables, capacity) int32
        Next entry in an entry's chain, or `ABSENT`.
    chain: (tables, capacity) int32
        Which chain an entry is in.
    """

    size: IntArray
    keys: KeyArray
    value: FloatArray
    used: TimeArray
    clock: TimeArray
    first: IntArray
    following: IntArray
    chain: IntArray


class Neighbours(NamedTuple):
    """The entries nearest to a key, nearest first, of equally near ones the lower number.

    Attributes
    ----------
    entry: (k,) int32
    distance: (k,) float32
        Squared Euclidean distance to the key.
    block: (BLOCK,) float32
        Working space: distances of one block.
    """

    entry: IntArray
    distance: KeyArray
    block: KeyArray


def make_entries(tables: int, capacity: int, places: int) -> Entries:
    """Return empty tables with room for ``capacity`` entries each (ours)."""
    chains = 1 << max(1, (capacity - 1).bit_length())
    return Entries(
        size=np.zeros(tables, np.int32),
        keys=np.zeros((tables, -(-capacity // BLOCK), places, BLOCK), np.float32),
        value=np.zeros((tables, capacity)),
        used=np.zeros((tables, capacity), np.int64),
        clock=np.zeros(1, np.int64),
        first=np.full((tables, chains), ABSENT, np.int32),
        following=np.zeros((tables, capacity), np.int32),
        chain=np.zeros((tables, capacity), np.int32),
    )


def make_neighbours(count: int) -> Neighbours:
    """Return room for so many neighbours (ours)."""
    return Neighbours(
        entry=np.zeros(count, np.int32),
        distance=np.zeros(count, np.float32),
        block=np.zeros(BLOCK, np.float32),
    )


@kernel
def find_key(entries: Entries, table: int, key: KeyArray) -> int:
    """Return the entry with just this key, or `ABSENT`."""
    entry = entries.first[table, _chain_of(entries, key)]
    while entry != ABSENT and not _has_key(entries, table, entry, key):
        entry = entries.following[table, entry]
    return int(entry)


@kernel
def find_nearest(entries: Entries, table: int, key: KeyArray, nearest: Neighbours) -> int:
    """Find the nearest neighbours of a key, as many as there is room for.

    Sums are added in one fixed order, so the same keys give the same bits on every machine.

    Parameters
    ----------
    key: (places,) float32
    nearest
        Filled in place.

    Returns
    -------
    found: int
        How many, less than asked for where the table has fewer entries.
    """
    wanted, size, found = nearest.entry.shape[0], entries.size[table], 0
    for block in range((size + BLOCK - 1) // BLOCK):
        _distances(entries.keys[table, block], key, nearest.block)
        if found == wanted:
            nearer, farthest = 0, nearest.distance[wanted - 1]
            for column in range(BLOCK):
                nearer += nearest.block[column] < farthest
            if nearer == 0:
                continue
        begin = block * BLOCK
        for column in range(min(BLOCK, size - begin)):
            distance = nearest.block[column]
            if found < wanted:
                found += 1
            elif distance >= nearest.distance[wanted - 1]:
                continue
            place = found - 1
            while place > 0 and nearest.distance[place - 1] > distance:
                nearest.distance[place] = nearest.distance[place - 1]
                nearest.entry[place] = nearest.entry[place - 1]
                place -= 1
            nearest.distance[place] = distance
            nearest.entry[place] = begin + column
    return found


@kernel
def tick(entries: Entries) -> int:
    """Move the clock on; return the new time."""
    entries.clock[0] += 1
    return int(entries.clock[0])


@kernel
def insert(entries: Entries, table: int, key: KeyArray, value: float, time: int) -> int:
    """Add an entry for a key that is not in the table; return its number.

    In a full table it takes the place of the entry that was not used for longest, of several the
    one with the lowest number.
    """
    entry = entries.size[table]
    if entry < entries.value.shape[1]:
        entries.size[table] = entry + 1
    else:
        entry = 0
        for other in range(1, entries.value.shape[1]):
            if entries.used[table, other] < entries.used[table, entry]:
                entry = other
        _unlink(entries, table, entry)
    for place in range(key.shape[0]):
        entries.keys[table, entry // BLOCK, place, entry % BLOCK] = key[place]
    entries.value[table, entry] = value
    entries.used[table, entry] = time
    chain = _chain_of(entries, key)
    entries.chain[table, entry] = chain
    entries.following[table, entry] = entries.first[table, chain]
    entries.first[table, chain] = entry
    return int(entry)


@kernel
def key_of(entries: Entries, table: int, entry: int, key: KeyArray) -> None:
    """Copy an entry's key."""
    for place in range(key.shape[0]):
        key[place] = entries.keys[table, entry // BLOCK, place, entry % BLOCK]


@kernel
def _distances(keys: KeyArray, key: KeyArray, distance: KeyArray) -> None:
    """Write the squared distances of a block of keys, (places, BLOCK), to a key."""
    for column in range(BLOCK):
        distance[column] = 0
    together = key.shape[0] - key.shape[0] % UNROLLED
    for place in range(0, together, UNROLLED):
        first, second, third, fourth = key[place], key[place + 1], key[place + 2], key[place + 3]
        # One plain loop over the columns, so that the compiler does several at once.
        for column in range(BLOCK):
            a, b = keys[place, column] - first, keys[place + 1, column] - second
            c, d = keys[place + 2, column] - third, keys[place + 3, column] - fourth
            distance[column] += (a * a + b * b) + (c * c + d * d)
    for place in range(together, key.shape[0]):
        for column in range(BLOCK):
            off = keys[place, column] - key[place]
            distance[column] += off * off


@kernel
def _has_key(entries: Entries, table: int, entry: int, key: KeyArray) -> bool:
    keys, column, place = entries.keys[table, entry // BLOCK], entry % BLOCK, 0
    while place < key.shape[0] and keys[place, column] == key[place]:
        place += 1
    return bool(place == key.shape[0])


@kernel
def _chain_of(entries: Entries, key: KeyArray) -> int:
    """Return the chain of a key: equal numbers, 0 and −0 too, must give the same one."""
    mixed = np.uint64(0x9E3779B97F4A7C15)
    for place in range(key.shape[0]):
        number = min(max(float(key[place]) * HASH_STEPS, -HASH_RANGE), HASH_RANGE)
        mixed = (mixed ^ np.uint64(np.int64(number))) * np.uint64(0xFF51AFD7ED558CCD)
        mixed ^= mixed >> np.uint64(32)
    return int(mixed & np.uint64(entries.first.shape[1] - 1))


@kernel
def _unlink(entries: Entries, table: int, entry: int) -> None:
    """Take an entry out of its chain."""
    chain, following = entries.chain[table, entry], entries.following[table, entry]
    before = entries.first[table, chain]
    if before == entry:
        entries.first[table, chain] = following
        return
    while entries.following[table, before] != entry:
        before = entries.following[table, before]
    entries.following[table, before] = following
