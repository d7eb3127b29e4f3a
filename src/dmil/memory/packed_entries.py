"""Entries as flat arrays for a file: only what is stored, without index and spare room."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from dmil.compilation import kernel
from dmil.errors import PolicyError
from dmil.memory.neighbours import (
    BLOCK,
    Entries,
    FloatArray,
    IntArray,
    KeyArray,
    TimeArray,
    insert,
    make_entries,
)


def pack_entries(entries: Entries) -> dict[str, npt.NDArray[Any]]:
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


def unpack_entries(arrays: Mapping[str, npt.NDArray[Any]], like: Entries) -> Entries:
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
    _expect(arrays, "size", (tables,), np.int32)
    size = arrays["size"]
    if size.min() < 0 or size.max() > capacity:
        raise _misfit("size", f"up to {size.max()} entries", f"at most {capacity} in a table")
    total = int(size.sum())
    _expect(arrays, "clock", (1,), np.int64)
    _expect(arrays, "keys", (total, places), np.float32)
    _expect(arrays, "value", (total,), np.float64)
    _expect(arrays, "used", (total,), np.int64)
    entries = make_entries(tables, capacity, places)
    _refill(entries, size, arrays["keys"], arrays["value"], arrays["used"])
    entries.clock[:] = arrays["clock"]
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


def _expect(
    arrays: Mapping[str, npt.NDArray[Any]], name: str, shape: tuple[int, ...], dtype: type
) -> None:
    found = arrays.get(name)
    if found is None or found.shape != shape or found.dtype != dtype:
        problem = "missing" if found is None else f"{found.shape} {found.dtype}"
        raise _misfit(name, problem, f"{shape} {np.dtype(dtype)}")


def _misfit(name: str, found: str, expected: str) -> PolicyError:
    return PolicyError(
        found,
        where=f"saved memory, array '{name}'",
        expected=expected,
        mend="use it with the network and the settings that it was saved with",
    )
