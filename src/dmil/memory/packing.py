"""Memories as flat arrays for a file: only what is stored, without index and spare room."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from dmil.arrays import Array, Arrays, FloatArray, IntArray
from dmil.compilation import kernel
from dmil.errors import PolicyError
from dmil.memory.admission import NO_CAP, Admission, make_admission
from dmil.memory.neighbours import BLOCK, Entries, KeyArray, TimeArray, insert, make_entries
from dmil.memory.rows import Rows, append, make_rows
from dmil.memory.saved import saved_array
from dmil.memory.tables import BestTable, Table, ValueTable, columns_of, table_over

COUNTED = ("counts", "recorded", "hand")
"""What of an admission does not follow from the keys."""


def bytes_used(rows: Rows, columns: Sequence[npt.NDArray[Any]]) -> int:
    """Return the memory of the rows stored and of the index over them, in bytes (ours).

    Parameters
    ----------
    rows
        Keyed rows of all owners.
    columns
        What is stored with each row: (owners, capacity, …) arrays, one row after the other.
    """
    stored = int(rows.size.sum())
    if not stored:
        return 0
    row_bytes = sum(array.strides[1] for array in (rows.keys, *columns))
    if rows.tolerance:
        # One bit per row, place and level.
        index = stored * rows.near.shape[1] * rows.near.shape[2] // 8
    else:
        # A hash table at most half full.
        index = 2 * stored * rows.slots.itemsize
    return int(stored * row_bytes + index)


def pack(table: ValueTable | BestTable) -> dict[str, Array]:
    """Return the rows of all owners, one owner after the other (ours).

    Returns
    -------
    arrays
        ``size``: (owners,) int32; and with (rows,) as the first axis ``keys`` and every column of
        the table under its own name.
    """
    size = table.rows.size
    used = np.arange(table.rows.keys.shape[1]) < size[:, None]
    columns = {"keys": table.rows.keys, **columns_of(table)}
    return {"size": size.copy(), **{name: column[used] for name, column in columns.items()}}


def unpack_table(arrays: Arrays, like: Table) -> Table:
    """Rebuild a table from its packed form (ours).

    Parameters
    ----------
    arrays
        What `pack` returned.
    like
        A table of the same owners, places, columns and tolerance.

    Raises
    ------
    PolicyError
        If the arrays are not those of such a table.
    """
    most = _most_rows(arrays, like)
    owners, _, places = like.rows.keys.shape
    table = table_over(make_rows(owners, most, places, like.rows.tolerance, like.rows.parts), like)
    _append_all(table.rows, arrays["size"], arrays["keys"])
    used = np.arange(table.rows.keys.shape[1]) < table.rows.size[:, None]
    for name, column in columns_of(table).items():
        column[used] = arrays[name]
    return table


unpack_values = unpack_bests = unpack_table


def pack_admission(admission: Admission) -> dict[str, Array]:
    """Return what an admission counted, empty without a cap; the rest follows from the keys."""
    return {name: getattr(admission, name).copy() for name in COUNTED if admission.capacity}


def unpack_admission(arrays: Arrays, capacity: int, size: npt.NDArray[np.int32]) -> Admission:
    """Rebuild an admission from its packed form; its marks follow from the keys (ours).

    Parameters
    ----------
    arrays
        What `pack_admission` returned.
    capacity: int
        See `make_admission`.
    size: (owners,) int32
        Rows stored under it.

    Raises
    ------
    PolicyError
        If the arrays are not those of such an admission, or there are more rows.
    """
    if not capacity:
        return NO_CAP
    if size.max() > capacity:
        raise PolicyError(
            f"{size.max()} rows in the long-term memory of one agent",
            where="saved memory",
            expected=f"at most long_capacity = {capacity}",
            mend="use it with the long_capacity that it was saved with, or train it again",
        )
    admission = make_admission(size.size, capacity)
    for name in COUNTED:
        found, wanted = arrays.get(name), getattr(admission, name)
        if found is None or found.shape != wanted.shape or found.dtype != wanted.dtype:
            raise _misfit(name, found, f"{wanted.shape} {wanted.dtype}")
        wanted[:] = found
    return admission


def _most_rows(arrays: Arrays, like: ValueTable | BestTable) -> int:
    """Check packed arrays against a table; return the most rows that an owner has."""
    size = arrays.get("size")
    owners, _, places = like.rows.keys.shape
    if size is None or size.shape != (owners,) or size.dtype != np.int32 or size.min() < 0:
        raise _misfit("size", size, f"{owners} numbers of rows")
    expected: dict[str, tuple[tuple[int, ...], object]] = {
        "keys": ((places,), like.rows.keys.dtype)
    }
    expected |= {name: (each.shape[2:], each.dtype) for name, each in columns_of(like).items()}
    for name, (shape, dtype) in expected.items():
        found, wanted = arrays.get(name), (int(size.sum()), *shape)
        if found is None or found.shape != wanted or found.dtype != dtype:
            raise _misfit(name, found, f"{wanted} {dtype}")
    return int(size.max())


def _misfit(name: str, found: npt.NDArray[Any] | None, expected: str) -> PolicyError:
    return PolicyError(
        "missing" if found is None else f"{found.shape} {found.dtype}",
        where=f"saved memory, array '{name}'",
        expected=expected,
        mend="use it with the network and the settings that it was saved with",
    )


@kernel
def _append_all(rows: Rows, size: npt.NDArray[np.int32], keys: npt.NDArray[np.int32]) -> None:
    begin = 0
    for owner in range(size.shape[0]):
        for row in range(begin, begin + size[owner]):
            append(rows, owner, keys[row])
        begin += size[owner]


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
    _insert_all(entries, size, keys, value, used)
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
def _insert_all(
    entries: Entries, size: IntArray, keys: KeyArray, value: FloatArray, used: TimeArray
) -> None:
    row = 0
    for table in range(size.shape[0]):
        for _ in range(size[table]):
            insert(entries, table, keys[row], value[row], used[row])
            row += 1
