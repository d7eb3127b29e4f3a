"""Entries as flat arrays for a file: only what is stored, without index and spare room."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from dmil.arrays import Array, Arrays, FloatArray, IntArray
from dmil.compilation import kernel
from dmil.errors import PolicyError
from dmil.memory.neighbours import BLOCK, Entries, KeyArray, TimeArray, insert, make_entries
from dmil.memory.saved import saved_array


def pack_entries(entries: Entries) -> dict[str, Array]:
    """Return the entries of all tables, one table after the other, and the clock (ours).

    Returns
    -------
    arrays
        ``size``: (tables,) int32; ``clock``: (1,) int64; and with (entries,) as the first axis
        ``keys``, float32, ``value``, float64, and ``used``, int64.
    """
    used = _in_use(entries)
    return {
        "size": entries.size.copy(),
        "clock": entries.clock.copy(),
        "keys": _by_entry(entries)[used],
        "value": entries.value[used],
        "used": entries.used[used],
    }


def unpack_entries(arrays: Arrays, like: Entries) -> Entries:
    """Rebuild a store from its packed form (ours).

    Parameters
    ----------
    arrays
        What `pack_entries` returned.
    like
        A store of the same tables, capacity and places.

    Raises
    ------
    PolicyError
        If the arrays are not those of such a store.
    """
    tables, capacity = like.value.shape
    places = like.keys.shape[2]
    size = saved_array(arrays, "size", (tables,), np.int32, least=0)
    if size.max() > capacity:
        raise PolicyError(
            f"array 'size' says up to {size.max()} entries",
            where="saved memory",
            expected=f"at most {capacity} in a table",
            mend="use it with the capacity that it was saved with",
        )
    total = int(size.sum())
    clock = saved_array(arrays, "clock", (1,), np.int64, least=0)
    keys = saved_array(arrays, "keys", (total, places), np.float32)
    value = saved_array(arrays, "value", (total,), np.float64)
    used = saved_array(arrays, "used", (total,), np.int64, least=0)
    entries = make_entries(tables, capacity, places)
    _refill(entries, size, keys, value, used)
    entries.clock[:] = clock
    return entries


def bytes_of_entries(entries: Entries) -> int:
    """Return the memory of the entries in use and of the index over them, in bytes (ours)."""
    places = entries.keys.shape[2]
    columns = entries.value, entries.used, entries.following, entries.chain
    # A hash table has about one chain per entry.
    one = places * entries.keys.itemsize + sum(array.itemsize for array in columns)
    return int(entries.size.sum()) * int(one + entries.first.itemsize)


def _in_use(entries: Entries) -> npt.NDArray[np.bool_]:
    used: npt.NDArray[np.bool_] = np.arange(entries.value.shape[1]) < entries.size[:, None]
    return used


def _by_entry(entries: Entries) -> KeyArray:
    """Return the keys as (tables, capacity, places)."""
    tables, blocks, places, _ = entries.keys.shape
    rows = entries.keys.transpose(0, 1, 3, 2).reshape(tables, blocks * BLOCK, places)
    return rows[:, : entries.value.shape[1]]


@kernel
def _refill(
    entries: Entries, size: IntArray, keys: KeyArray, value: FloatArray, used: TimeArray
) -> None:
    row = 0
    for table in range(size.shape[0]):
        for _ in range(size[table]):
            insert(entries, table, keys[row], value[row], used[row])
            row += 1
