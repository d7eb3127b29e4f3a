"""Patterns: classes that the first key to come claims, for every later one that it covers.

After the pattern classes of PLMP (Han et al. 2023), as far as they are known.
"""

from __future__ import annotations

from dmil.arrays import IntArray
from dmil.compilation import kernel
from dmil.memory.rows import ABSENT, Rows, find

PROBE = 8
"""Keys that are compared in the time in which one is looked up."""


@kernel
def find_pattern(rows: Rows, owner: int, pattern: IntArray, reach: int, key: IntArray) -> int:
    """Return the row whose class holds a pattern: the oldest that covers it; else `ABSENT`.

    The class of a key ψ holds ψ itself; its multiples v·ψ, v = 2 … reach; and ψ + δ for all δ whose
    numbers are 0 … reach. A key is no member of an older class, or it would not be one.

    Parameters
    ----------
    rows
        Keys of all owners, found by hashing (no tolerance).
    pattern: (1, places) int32
        Counts.
    reach: int
        v̄.
    key: (1, places) int32
        Working space.
    """
    row, _ = find(rows, owner, pattern, 1)
    if row != ABSENT:
        return row
    oldest = _oldest_divisor(rows, owner, pattern[0], reach, key)
    below, place = 1, 0
    while place < pattern.shape[1] and below * PROBE < rows.size[owner]:
        below *= 1 + min(reach, pattern[0, place])
        place += 1
    if below * PROBE < rows.size[owner]:
        return _older(oldest, _oldest_below(rows, owner, pattern[0], reach, key))
    for older in range(rows.size[owner] if oldest == ABSENT else oldest):
        if _is_below(rows.keys[owner, older], pattern[0], reach):
            return older
    return oldest


@kernel
def _oldest_divisor(rows: Rows, owner: int, pattern: IntArray, reach: int, key: IntArray) -> int:
    """Look up every key of which the pattern is a multiple; return the oldest row, or `ABSENT`."""
    oldest, largest = ABSENT, 0
    for count in pattern:
        largest = max(largest, count)
    # Greater multiples are of zeros only, which were looked up.
    for multiple in range(2, min(reach, largest) + 1):
        divides, place = True, 0
        while divides and place < pattern.shape[0]:
            divides = pattern[place] % multiple == 0
            key[0, place] = pattern[place] // multiple
            place += 1
        if divides:
            oldest = _older(oldest, find(rows, owner, key, 1)[0])
    return oldest


@kernel
def _oldest_below(rows: Rows, owner: int, pattern: IntArray, reach: int, key: IntArray) -> int:
    """Look up every key up to reach below a pattern; return the oldest row, or `ABSENT`."""
    places, oldest = pattern.shape[0], ABSENT
    for place in range(places):
        key[0, place] = pattern[place]
    while True:
        # Count down like an odometer, from the pattern itself, which is not in the table.
        place = 0
        while place < places and key[0, place] == max(0, pattern[place] - reach):
            key[0, place] = pattern[place]
            place += 1
        if place == places:
            return oldest
        key[0, place] -= 1
        oldest = _older(oldest, find(rows, owner, key, 1)[0])


@kernel
def _is_below(key: IntArray, pattern: IntArray, reach: int) -> bool:
    """Tell whether a pattern is 0 … reach above a key everywhere."""
    place, places = 0, key.shape[0]
    while place < places and 0 <= pattern[place] - key[place] <= reach:
        place += 1
    return bool(place == places)


@kernel
def _older(row: int, other: int) -> int:
    """Return the older of two rows, either of which may be `ABSENT`."""
    if row == ABSENT or other == ABSENT:
        return max(row, other)
    return min(row, other)
