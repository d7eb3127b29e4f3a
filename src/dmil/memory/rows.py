"""Keyed rows: the one compiled table under every memory.

A table holds, for each owner, rows found by a key (a vector of whole numbers), without a tolerance
by hashing. With one, every place and value has a set of the rows within the tolerance there, one
bit a row: the rows near a key are the intersection of one set per place, 64 rows at a time. A key
may consist of parts that are looked up one after the other: a row is found if it is near in one of
them. Rows are appended, given another key, or emptied as a whole: their numbers never change.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dmil.arrays import IntArray
from dmil.compilation import inlined_kernel, kernel

BitArray = npt.NDArray[np.uint64]

ABSENT = -1
"""Row number of a key that is not in the table."""

LEVELS = 16
"""Sets per place, a power of two. Values equal modulo this share a set: what the sets let pass is
compared key by key, so sharing costs time and nothing else."""

WORD_BITS = 64


class Rows(NamedTuple):
    """Keys of all owners and the index over them.

    Attributes
    ----------
    size: (owners,) int32
        Rows in use.
    changes: (owners,) int64
        How often the keys of an owner have changed; until the next time a look-up finds the same.
    keys: (owners, capacity, places) int32
    slots: (owners, power of two) int32
        Hash table of row numbers (tolerance 0), else unused.
    near: (owners, places, LEVELS, words) uint64
        Sets of rows (tolerance above 0), else unused: bit r is set if row r may be within the
        tolerance of that value at that place.
    matches: (words,) uint64
        Working space of look-ups.
    tolerance: int
    parts: int
        Parts of a key, of equal length; more than one only with a tolerance.
    """

    size: IntArray
    changes: npt.NDArray[np.int64]
    keys: IntArray
    slots: IntArray
    near: BitArray
    matches: BitArray
    tolerance: int
    parts: int


def make_rows(owners: int, capacity: int, places: int, tolerance: int, parts: int = 1) -> Rows:
    """Return empty rows with room for ``capacity`` of them per owner (ours)."""
    slots = 1 if tolerance else 1 << max(1, (2 * capacity - 1).bit_length())
    words = -(-capacity // WORD_BITS) if tolerance else 0
    return Rows(
        size=np.zeros(owners, np.int32),
        changes=np.zeros(owners, np.int64),
        keys=np.zeros((owners, capacity, places), np.int32),
        slots=np.full((owners, slots), ABSENT, np.int32),
        near=np.zeros((owners, places, LEVELS, words), np.uint64),
        matches=np.zeros(words, np.uint64),
        tolerance=tolerance,
        parts=parts,
    )


def is_short_of_room(rows: Rows, more: int) -> bool:
    """Tell whether ``more`` rows do not fit for some owner (ours)."""
    return bool(rows.size.max() + more > rows.keys.shape[1])


def larger_capacity(rows: Rows, more: int) -> int:
    """Return at least twice the room, and enough for ``more`` rows (ours)."""
    capacity: int = rows.keys.shape[1]
    return max(2 * capacity, int(rows.size.max()) + more)


def rows_of(rows: Rows, owners: npt.NDArray[np.integer], capacity: int) -> Rows:
    """Give each new owner a copy of the rows of the old owner that is named for it (ours)."""
    used = int(rows.size.max())
    copies = make_rows(owners.size, capacity, rows.keys.shape[2], rows.tolerance, rows.parts)
    copies.size[:] = rows.size[owners]
    copies.changes[:] = rows.changes[owners]
    copies.keys[:, :used] = rows.keys[owners, :used]
    if rows.tolerance:
        words = -(-used // WORD_BITS)
        copies.near[..., :words] = rows.near[owners, :, :, :words]
    else:
        _rehash(copies)
    return copies


@kernel
def find(rows: Rows, owner: int, variants: IntArray, count: int) -> tuple[int, int]:
    """Find the row of a class: the nearest key by L1, of equally near ones the oldest (§5).

    The oldest is the one with the lowest number; `replace` gives a row another key in its place.
    Of keys with several parts the first part decides, the next only if no row is near in it.

    Parameters
    ----------
    variants: (at least count, places) int32
        The key looked for under each symmetry.
    count: int
        How many variants to try.

    Returns
    -------
    row, variant: int
        The row, or `ABSENT`; and the first variant under which it is nearest.
    """
    best_row, best_variant = ABSENT, 0
    best_distance = rows.tolerance * rows.keys.shape[2] + 1
    length = rows.keys.shape[2] // rows.parts
    for part in range(rows.parts):
        for variant in range(count):
            if rows.tolerance == 0:
                row, distance = _find_exact(rows, owner, variants[variant]), 0
            else:
                row, distance = _find_near(rows, owner, variants[variant], part * length, length)
            if row != ABSENT and (
                distance < best_distance or (distance == best_distance and row < best_row)
            ):
                best_row, best_variant, best_distance = row, variant, distance
        if best_row != ABSENT:
            break
    return best_row, best_variant


@kernel
def find_nearest(rows: Rows, owner: int, variants: IntArray, count: int) -> tuple[int, int]:
    """Find the nearest key by L1 however far it is: for the few keys that have no class.

    Of keys with several parts the last is compared, in which most states match.
    """
    first = rows.keys.shape[2] - rows.keys.shape[2] // rows.parts
    best_row, best_variant, best_distance = ABSENT, 0, np.iinfo(np.int64).max
    for row in range(rows.size[owner]):
        for variant in range(count):
            distance, place = 0, first
            while place < variants.shape[1] and distance < best_distance:
                distance += abs(rows.keys[owner, row, place] - variants[variant, place])
                place += 1
            if distance < best_distance:
                best_row, best_variant, best_distance = row, variant, distance
    return best_row, best_variant


@kernel
def append(rows: Rows, owner: int, key: IntArray) -> int:
    """Add a row for a key that is not in the table; return its number.

    The caller has made room (`is_short_of_room`, `rows_of`).
    """
    row = rows.size[owner]
    rows.size[owner] = row + 1
    _enter(rows, owner, row, key)
    return int(row)


@kernel
def replace(rows: Rows, owner: int, row: int, key: IntArray) -> None:
    """Give a row a key that is not in the table; the key it had is found no more."""
    if rows.tolerance == 0:
        _hash_out(rows, owner, row)
    else:
        _unmark(rows, owner, row)
    _enter(rows, owner, row, key)


@kernel
def _enter(rows: Rows, owner: int, row: int, key: IntArray) -> None:
    rows.changes[owner] += 1
    for place in range(key.shape[0]):
        rows.keys[owner, row, place] = key[place]
    if rows.tolerance == 0:
        _hash_in(rows, owner, row)
    else:
        _mark(rows, owner, row)


@kernel
def clear(rows: Rows, owner: int) -> None:
    """Remove every row of an owner."""
    rows.size[owner] = 0
    rows.changes[owner] += 1
    rows.slots[owner, :] = ABSENT
    rows.near[owner, :, :, :] = 0


@kernel
def copy_rows(rows: Rows, source: int, goal: int) -> None:
    """Make the rows of one owner equal to those of another."""
    rows.size[goal] = rows.size[source]
    rows.changes[goal] += 1
    for row in range(rows.size[source]):
        for place in range(rows.keys.shape[2]):
            rows.keys[goal, row, place] = rows.keys[source, row, place]
    for slot in range(rows.slots.shape[1]):
        rows.slots[goal, slot] = rows.slots[source, slot]
    for place in range(rows.near.shape[1]):
        for level in range(LEVELS):
            for word in range(rows.near.shape[3]):
                rows.near[goal, place, level, word] = rows.near[source, place, level, word]


@kernel
def _hash(key: IntArray) -> int:
    # Two numbers that do not wait for each other: multiplications overlap.
    even, odd = np.uint64(0x9E3779B97F4A7C15), np.uint64(0xC2B2AE3D27D4EB4F)
    factor = np.uint64(0xFF51AFD7ED558CCD)
    for j in range(0, key.shape[0] - 1, 2):
        even = (even ^ np.uint64(key[j])) * factor
        odd = (odd ^ np.uint64(key[j + 1])) * factor
        even ^= even >> np.uint64(32)
        odd ^= odd >> np.uint64(32)
    if key.shape[0] % 2 == 1:
        even = (even ^ np.uint64(key[key.shape[0] - 1])) * factor
    mixed = (even ^ (odd << np.uint64(1))) * factor
    return int((mixed ^ (mixed >> np.uint64(32))) >> np.uint64(1))


@inlined_kernel
def _find_exact(rows: Rows, owner: int, key: IntArray) -> int:
    slots = rows.slots[owner]
    mask = slots.shape[0] - 1
    place = _hash(key) & mask
    while slots[place] != ABSENT:
        row, same = slots[place], 0
        while same < key.shape[0] and rows.keys[owner, row, same] == key[same]:
            same += 1
        if same == key.shape[0]:
            return int(row)
        place = (place + 1) & mask
    return ABSENT


@kernel
def _hash_in(rows: Rows, owner: int, row: int) -> None:
    slots = rows.slots[owner]
    mask = slots.shape[0] - 1
    place = _hash(rows.keys[owner, row]) & mask
    while slots[place] != ABSENT:
        place = (place + 1) & mask
    slots[place] = row


@kernel
def _hash_out(rows: Rows, owner: int, row: int) -> None:
    """Take a row out of the hash table, and move up those that had to make way for others."""
    slots = rows.slots[owner]
    mask = slots.shape[0] - 1
    gap = _hash(rows.keys[owner, row]) & mask
    while slots[gap] != row:
        gap = (gap + 1) & mask
    place = (gap + 1) & mask
    while slots[place] != ABSENT:
        home = _hash(rows.keys[owner, slots[place]]) & mask
        # It is looked for from its home on: it may stand at the gap unless that lies before.
        if (place - home) & mask >= (place - gap) & mask:
            slots[gap] = slots[place]
            gap = place
        place = (place + 1) & mask
    slots[gap] = ABSENT


@kernel
def _rehash(rows: Rows) -> None:
    for owner in range(rows.size.shape[0]):
        for slot in range(rows.slots.shape[1]):
            rows.slots[owner, slot] = ABSENT
        for row in range(rows.size[owner]):
            _hash_in(rows, owner, row)


@inlined_kernel
def _find_near(rows: Rows, owner: int, key: IntArray, first: int, length: int) -> tuple[int, int]:
    """Return the row nearest to one part of a key, the oldest of equals; its distance."""
    near, matches = rows.near[owner], rows.matches
    words = (rows.size[owner] + WORD_BITS - 1) // WORD_BITS
    best_row, best_distance = ABSENT, 0
    for word in range(words):
        matches[word] = ~np.uint64(0)
    for place in range(first, first + length):
        rows_near, left = near[place, key[place] & (LEVELS - 1)], np.uint64(0)
        # One plain loop over the words per place, so that the compiler does several at once.
        for word in range(words):
            matches[word] &= rows_near[word]
            left |= matches[word]
        if left == 0:
            return ABSENT, 0
    for word in range(words):
        left, row = matches[word], word * WORD_BITS
        while left != 0:
            while left & np.uint64(0xFF) == 0:
                left, row = left >> np.uint64(8), row + 8
            if left & np.uint64(1):
                distance = _distance(rows, owner, row, key, first, length)
                if distance != ABSENT and (best_row == ABSENT or distance < best_distance):
                    best_row, best_distance = row, distance
            left, row = left >> np.uint64(1), row + 1
    return best_row, best_distance


@inlined_kernel
def _distance(rows: Rows, owner: int, row: int, key: IntArray, first: int, length: int) -> int:
    """Return how far a row's key is away by L1, `ABSENT` if beyond the tolerance somewhere."""
    distance = 0
    for place in range(first, first + length):
        off = abs(rows.keys[owner, row, place] - key[place])
        if off > rows.tolerance:
            return ABSENT
        distance += off
    return distance


@kernel
def _mark(rows: Rows, owner: int, row: int) -> None:
    """Enter a row in the sets of all values within the tolerance of its key."""
    bit = np.uint64(1) << np.uint64(row % WORD_BITS)
    for place in range(rows.keys.shape[2]):
        value = rows.keys[owner, row, place]
        for near_value in range(value - rows.tolerance, value + rows.tolerance + 1):
            rows.near[owner, place, near_value & (LEVELS - 1), row // WORD_BITS] |= bit


@kernel
def _unmark(rows: Rows, owner: int, row: int) -> None:
    """Take a row out of all sets: no other row has its bit."""
    others = ~(np.uint64(1) << np.uint64(row % WORD_BITS))
    for place in range(rows.keys.shape[2]):
        for level in range(LEVELS):
            rows.near[owner, place, level, row // WORD_BITS] &= others
