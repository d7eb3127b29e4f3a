"""Patterns: classes that the first key to come claims, for every later one that it covers.

After the pattern classes of PLMP (Han et al. 2023), as far as they are known.
"""

from __future__ import annotations

from dmil.compilation import kernel
from dmil.memory.rows import ABSENT, Rows, find
from dmil.memory.tables import IntArray

PROBE = 8
"""Keys that are compared in the time in which one is looked up."""


@kernel
def covers(key: IntArray, pattern: IntArray, reach: int) -> bool:
    """Tell whether a pattern is in the class that a key would have were it the first.

    The class holds the key ψ; its multiples v·ψ, v = 2 … reach; and ψ + δ for all δ whose numbers
    are 0 … reach.
    """
    place, places = 0, key.shape[0]
    while place < places and 0 <= pattern[place] - key[place] <= reach:
        place += 1
    if place == places:
        return True
    if reach < 2:  # no multiples: spares nearly every row of a scan a division
        return False
    place = 0
    while place < places and key[place] == 0:
        place += 1
    if place == places or pattern[place] % key[place] != 0:
        return False
    multiple = pattern[place] // key[place]
    if multiple < 2 or multiple > reach:
        return False
    place = 0
    while place < places and pattern[place] == multiple * key[place]:
        place += 1
    return bool(place == places)


@kernel
def find_pattern(rows: Rows, owner: int, pattern: IntArray, reach: int, key: IntArray) -> int:
    """Return the row whose class holds a pattern: the oldest that covers it; else `ABSENT`.

    There are two ways to it: to compare all keys in their order, or to look up every key that can
    cover the pattern. It takes the one that has less to do.

    Parameters
    ----------
    rows
        Keys of all owners, found by hashing (no tolerance).
    owner: int
        Whose keys.
    pattern: (1, places) int32
        Counts.
    reach: int
        v̄.
    key: (1, places) int32
        Working space.
    """
    # A key is no member of an older class, or it would not be one.
    row, _ = find(rows, owner, pattern, 1)
    if row != ABSENT:
        return row
    covering, place = 1, 0
    while place < pattern.shape[1] and covering * PROBE < rows.size[owner]:
        covering *= 1 + min(reach, pattern[0, place])
        place += 1
    if covering * PROBE < rows.size[owner]:
        return _oldest_of_covering(rows, owner, pattern[0], reach, key)
    first = pattern[0, 0]
    for older in range(rows.size[owner]):
        # Most keys differ in their first number already, and without multiples that settles it.
        if reach < 2 and not 0 <= first - rows.keys[owner, older, 0] <= reach:
            continue
        if covers(rows.keys[owner, older], pattern[0], reach):
            return older
    return ABSENT


@kernel
def _oldest_of_covering(
    rows: Rows, owner: int, pattern: IntArray, reach: int, key: IntArray
) -> int:
    """Look up every key that covers a pattern; return the oldest row, or `ABSENT`."""
    places, oldest = pattern.shape[0], ABSENT
    for multiple in range(2, reach + 1):
        divides, place = True, 0
        while divides and place < places:
            divides = pattern[place] % multiple == 0
            key[0, place] = pattern[place] // multiple
            place += 1
        if divides:
            oldest = _older(oldest, find(rows, owner, key, 1)[0])
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
def _older(row: int, other: int) -> int:
    """Return the older of two rows, either of which may be `ABSENT`."""
    if row == ABSENT or other == ABSENT:
        return max(row, other)
    return min(row, other)
