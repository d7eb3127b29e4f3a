"""Memories as flat arrays for a file: only what is stored, without index and spare room."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt

from dmil.compilation import kernel
from dmil.memory.rows import Rows, append
from dmil.memory.tables import (
    BestTable,
    ValueTable,
    best_table_with_room,
    make_best_table,
    make_value_table,
    value_table_with_room,
)

Arrays = Mapping[str, npt.NDArray[np.generic]]


def bytes_used(rows: Rows, columns: Sequence[npt.NDArray[np.generic]]) -> int:
    """Return the memory of the rows stored and of the index over them, in bytes (ours).

    Parameters
    ----------
    rows
        Keyed rows of all owners.
    columns
        What is stored with each row: (owners, capacity, …) arrays.
    """
    row_bytes = sum(
        array.itemsize * int(np.prod(array.shape[2:])) for array in (rows.keys, *columns)
    )
    stored = int(rows.size.sum())
    if rows.tolerance:
        index = int(rows.node_count.sum()) * rows.nodes.shape[2] * rows.nodes.itemsize
    else:
        # A hash table at most half full.
        index = 2 * stored * rows.slots.itemsize
    return stored * row_bytes + index


def pack(table: ValueTable | BestTable) -> dict[str, npt.NDArray[np.generic]]:
    """Return the rows of all owners, one owner after the other (ours).

    Returns
    -------
    arrays
        ``size``: (owners,) int32; and with (rows,) as the first axis ``keys`` and every column of
        the table under its own name.
    """
    size = table.rows.size
    used = np.arange(table.rows.keys.shape[1]) < size[:, None]
    arrays: dict[str, npt.NDArray[np.generic]] = {
        "size": size.copy(),
        "keys": table.rows.keys[used],
    }
    for name, column in table._asdict().items():
        if name != "rows":
            arrays[name] = column[used]
    return arrays


def unpack_values(arrays: Arrays, tolerance: int) -> ValueTable:
    """Rebuild a table of values from its packed form; the index grows as it did at first (ours)."""
    size, keys, value = arrays["size"], arrays["keys"], arrays["value"]
    table = make_value_table(
        size.size, int(size.max(initial=0)) + 1, keys.shape[1], value.shape[1], tolerance
    )
    table = value_table_with_room(table, int(size.max(initial=0)))
    _refill(table, arrays)
    return table


def unpack_bests(arrays: Arrays, tolerance: int) -> BestTable:
    """Rebuild a table of best actions from its packed form (ours)."""
    size, keys = arrays["size"], arrays["keys"]
    table = make_best_table(size.size, int(size.max(initial=0)) + 1, keys.shape[1], tolerance)
    table = best_table_with_room(table, int(size.max(initial=0)))
    _refill(table, arrays)
    return table


def _refill(table: ValueTable | BestTable, arrays: Arrays) -> None:
    _append_all(table.rows, arrays["size"], arrays["keys"])
    used = np.arange(table.rows.keys.shape[1]) < table.rows.size[:, None]
    for name, column in table._asdict().items():
        if name != "rows":
            column[used] = arrays[name]


@kernel
def _append_all(rows: Rows, size: npt.NDArray[np.int32], keys: npt.NDArray[np.int32]) -> None:
    begin = 0
    for owner in range(size.shape[0]):
        for row in range(begin, begin + size[owner]):
            append(rows, owner, keys[row])
        begin += size[owner]
