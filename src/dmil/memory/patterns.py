"""Patterns: classes that the first key to come claims, for every later one that it covers.

After the pattern classes of PLMP (Han et al. 2023), as far as they are known.
"""

from __future__ import annotations

from dmil.compilation import kernel
from dmil.memory.rows import ABSENT, Rows, find
from dmil.memory.tables import IntArray


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
def find_pattern(rows: Rows, owner: int, pattern: IntArray, reach: int) -> int:
    """Return the row whose class holds a pattern: the oldest that covers it; else `ABSENT`.

    Parameters
    ----------
    rows
        Keys of all owners, found by hashing (no tolerance).
    owner: int
        Whose keys.
    pattern: (1, places) int32
    reach: int
        v̄.
    """
    # A key is no member of an older class, or it would not be one.
    row, _ = find(rows, owner, pattern, 1)
    if row != ABSENT:
        return row
    first = pattern[0, 0]
    for older in range(rows.size[owner]):
        # Most keys differ in their first number already, and without multiples that settles it.
        if reach < 2 and not 0 <= first - rows.keys[owner, older, 0] <= reach:
            continue
        if covers(rows.keys[owner, older], pattern[0], reach):
            return older
    return ABSENT
