"""Episodic memory: the best return that ever followed a state (Blundell et al. 2016).

One table per action; the value of a state is its own entry's, or the mean of its neighbours'.
"""

from __future__ import annotations

from dmil.compilation import kernel
from dmil.memory.neighbours import (
    Entries,
    KeyArray,
    Neighbours,
    find_key,
    find_nearest,
    insert,
    tick,
)
from dmil.memory.rows import ABSENT


@kernel
def estimate(
    entries: Entries, table: int, key: KeyArray, nearest: Neighbours, touches: bool
) -> tuple[float, bool]:
    """Return the value of a key: its own, else the mean of its nearest (Blundell 2016, eq. 2).

    Parameters
    ----------
    entries, table
        Where to look; not empty.
    key: (places,) float32
    nearest
        Working space; its size is the number of neighbours.
    touches
        Whether the entries that were read count as used now.

    Returns
    -------
    value, exact: float, bool
        The value, and whether it is the key's own.
    """
    time = tick(entries) if touches else 0
    entry = find_key(entries, table, key)
    if entry != ABSENT:
        if touches:
            entries.used[table, entry] = time
        return float(entries.value[table, entry]), True
    found, total = find_nearest(entries, table, key, nearest), 0.0
    for place in range(found):
        entry = nearest.entry[place]
        total += entries.value[table, entry]
        if touches:
            entries.used[table, entry] = time
    return total / found, False


@kernel
def keep_best(entries: Entries, table: int, key: KeyArray, outcome: float) -> None:
    """Remember a return if it is the best that followed a key (Blundell 2016, eq. 1).

    Parameters
    ----------
    entries, table
        Where to write.
    key: (places,) float32
    outcome
        The return.
    """
    time, entry = tick(entries), find_key(entries, table, key)
    if entry == ABSENT:
        insert(entries, table, key, outcome, time)
        return
    entries.value[table, entry] = max(entries.value[table, entry], outcome)
    entries.used[table, entry] = time
