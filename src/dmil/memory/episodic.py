"""Episodic memories: values of states and actions by what followed, one table per action.

MFEC's keeps the best return that ever followed a state; its value is its own entry's, or the mean
of its neighbours' (Blundell et al. 2016). NEC's differentiable neural dictionary has embeddings of
states for keys; a value is a weighted mean, and which neighbours it is of lets a caller take its
gradient (Pritzel et al. 2017).
"""

from __future__ import annotations

from dmil.arrays import IntArray
from dmil.compilation import kernel
from dmil.memory.neighbours import (
    Entries,
    KeyArray,
    Neighbours,
    find_key,
    find_nearest,
    insert,
    key_of,
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
    key: (places,) float32
    """
    time, entry = tick(entries), find_key(entries, table, key)
    if entry == ABSENT:
        insert(entries, table, key, outcome, time)
        return
    entries.value[table, entry] = max(entries.value[table, entry], outcome)
    entries.used[table, entry] = time


@kernel
def recall_mean(
    entries: Entries,
    table: int,
    key: KeyArray,
    softening: float,
    nearest: Neighbours,
    touches: bool,
) -> tuple[float, int]:
    """Return the mean value of a key's neighbours, the nearer the more (Pritzel 2017, eq. 1–5).

    Parameters
    ----------
    entries, table
        Where to look; not empty.
    key: (places,) float32
        An embedding.
    softening: float
        δ of the weights 1/(‖h − h_i‖² + δ).
    nearest
        Filled with the neighbours; its size is how many to take.
    touches
        Whether the entries that were read count as used now.

    Returns
    -------
    value, found: float, int
        The mean, and how many neighbours it is of.
    """
    time = tick(entries) if touches else 0
    found, weights, total = find_nearest(entries, table, key, nearest), 0.0, 0.0
    for place in range(found):
        entry, weight = nearest.entry[place], 1.0 / (nearest.distance[place] + softening)
        weights += weight
        total += weight * entries.value[table, entry]
        if touches:
            entries.used[table, entry] = time
    return total / weights, found


@kernel
def gather(
    entries: Entries,
    table: IntArray,
    key: KeyArray,
    nearest: Neighbours,
    keys: KeyArray,
    value: KeyArray,
    present: KeyArray,
) -> None:
    """Collect the neighbours of a batch of keys, for who takes the gradient of their mean.

    They count as used now.

    Parameters
    ----------
    table: (batch,) int32
    key: (batch, places) float32
        Embeddings.
    nearest
        Working space; its size is how many neighbours to take.
    keys: (batch, k, places) float32
    value, present: (batch, k) float32
        Filled in place: the neighbours' keys and values; 1 where there is one, else 0.
    """
    time = tick(entries)
    for row in range(table.shape[0]):
        found = find_nearest(entries, table[row], key[row], nearest)
        for place in range(nearest.entry.shape[0]):
            present[row, place] = place < found
            value[row, place] = 0
            if place < found:
                entry = nearest.entry[place]
                key_of(entries, table[row], entry, keys[row, place])
                value[row, place] = entries.value[table[row], entry]
                entries.used[table[row], entry] = time


@kernel
def write_towards(
    entries: Entries, table: int, key: KeyArray, outcome: float, learning_rate: float
) -> None:
    """Move the value of a known key towards a return; append an unknown one (Pritzel 2017, eq. 6).

    Parameters
    ----------
    key: (places,) float32
    outcome
        The return Q_N.
    learning_rate: float
        α.
    """
    entry = find_key(entries, table, key)
    if entry == ABSENT:
        insert(entries, table, key, outcome, tick(entries))
    else:
        value = entries.value[table, entry]
        entries.value[table, entry] = value + learning_rate * (outcome - value)
