"""What is stored in keyed rows: values of all actions, or the best action alone."""

from __future__ import annotations

from typing import Any, NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt

from dmil.arrays import Array, BoolArray, FloatArray, IntArray
from dmil.compilation import inlined_kernel, kernel
from dmil.memory.rows import (
    ABSENT,
    Rows,
    append,
    clear,
    copy_rows,
    find,
    find_nearest,
    is_short_of_room,
    larger_capacity,
    make_rows,
    rows_of,
)
from dmil.symmetry import Classes, vary


class ValueTable(NamedTuple):
    """Q-values per class and action: the Q-table, and the short-term memory (Algorithm 1).

    Attributes
    ----------
    rows: Rows
    value: (owners, capacity, actions) float64
        Q, 0 where an action was never tried.
    tried: (owners, capacity, actions) bool
    visits: (owners, capacity) int32
        How often a row was written.
    """

    rows: Rows
    value: FloatArray
    tried: BoolArray
    visits: IntArray


class BestTable(NamedTuple):
    """The best action per class and its Q: the long-term memory (Algorithm 2).

    Attributes
    ----------
    rows: Rows
    action: (owners, capacity) int32
    value: (owners, capacity) float64
    """

    rows: Rows
    action: IntArray
    value: FloatArray


Table = TypeVar("Table", ValueTable, BestTable)


def make_value_table(
    owners: int, capacity: int, places: int, actions: int, tolerance: int, parts: int = 1
) -> ValueTable:
    """Return an empty table of values (ours)."""
    return ValueTable(
        rows=make_rows(owners, capacity, places, tolerance, parts),
        value=np.zeros((owners, capacity, actions)),
        tried=np.zeros((owners, capacity, actions), np.bool_),
        visits=np.zeros((owners, capacity), np.int32),
    )


def make_best_table(
    owners: int, capacity: int, places: int, tolerance: int, parts: int = 1
) -> BestTable:
    """Return an empty table of best actions (ours)."""
    return BestTable(
        rows=make_rows(owners, capacity, places, tolerance, parts),
        action=np.zeros((owners, capacity), np.int32),
        value=np.zeros((owners, capacity)),
    )


def columns_of(table: ValueTable | BestTable) -> dict[str, Array]:
    """Return what is stored with each row, by name: (owners, capacity, …) arrays (ours)."""
    return {name: column for name, column in table._asdict().items() if name != "rows"}


def table_over(rows: Rows, like: Table) -> Table:
    """Return a table of such columns, all zeros, over keyed rows (ours)."""
    return like._replace(rows=rows, **_zeros_over(rows, like))


def _zeros_over(rows: Rows, like: ValueTable | BestTable) -> dict[str, Any]:
    return {
        name: np.zeros((*rows.keys.shape[:2], *column.shape[2:]), column.dtype)
        for name, column in columns_of(like).items()
    }


def table_of(table: Table, owners: npt.NDArray[np.integer], capacity: int) -> Table:
    """Give each new owner a copy of the table of the old owner that is named for it (ours).

    Parameters
    ----------
    owners: (new owners,) int
    capacity: int
        Room for rows in the copies, at least what the table uses.
    """
    used = int(table.rows.size.max())
    copies = table_over(rows_of(table.rows, owners, capacity), table)
    for name, column in columns_of(table).items():
        getattr(copies, name)[:, :used] = column[owners, :used]
    return copies


def table_with_room(table: Table, more: int) -> Table:
    """Return the table with room for ``more`` rows per owner, the same one if it has it (ours)."""
    if not is_short_of_room(table.rows, more):
        return table
    owners = np.arange(table.rows.size.size)
    return table_of(table, owners, larger_capacity(table.rows, more))


values_of = bests_of = table_of
value_table_with_room = best_table_with_room = table_with_room


class Scratch(NamedTuple):
    """Working space of the kernels, so that they allocate nothing.

    Attributes
    ----------
    variants: (symmetries, places) int32
    key: (places,) int32
    """

    variants: IntArray
    key: IntArray


def make_scratch(classes: Classes) -> Scratch:
    """Return working space for the keys of some classes (ours)."""
    _, variants, places = classes.movement_image.shape
    return Scratch(
        variants=np.zeros((variants, places), np.int32),
        key=np.zeros(places, np.int32),
    )


@kernel
def look_up(
    rows: Rows, classes: Classes, owner: int, shape: int, key: IntArray, scratch: Scratch
) -> tuple[int, int]:
    """Find the row of a key's class.

    Returns
    -------
    row, variant: int
        The row (−1 if there is none) and the symmetry that carries the key to it.
    """
    count = vary(classes, shape, key, scratch.variants)
    return find(rows, owner, scratch.variants, count)


@kernel
def look_up_nearest(
    rows: Rows, classes: Classes, owner: int, shape: int, key: IntArray, scratch: Scratch
) -> tuple[int, int]:
    """Find the row nearest to a key, however far it is; see `look_up`."""
    count = vary(classes, shape, key, scratch.variants)
    return find_nearest(rows, owner, scratch.variants, count)


@kernel
def look_up_or_append(
    rows: Rows, classes: Classes, owner: int, shape: int, key: IntArray, scratch: Scratch
) -> tuple[int, int]:
    """Find the row of a key's class; a key without one becomes the key of a new class."""
    row, variant = look_up(rows, classes, owner, shape, key, scratch)
    if row == ABSENT:
        return append(rows, owner, key), 0
    return row, variant


@kernel
def write(
    table: ValueTable,
    classes: Classes,
    owner: int,
    shape: int,
    key: IntArray,
    action: int,
    value: float,
    scratch: Scratch,
) -> None:
    """Store Q for a key's class and the equivalent action (Algorithm 1 up to its update rule)."""
    row, variant = look_up(table.rows, classes, owner, shape, key, scratch)
    write_found(table, classes, owner, shape, key, row, variant, action, value)


@inlined_kernel
def write_found(
    table: ValueTable,
    classes: Classes,
    owner: int,
    shape: int,
    key: IntArray,
    row: int,
    variant: int,
    action: int,
    value: float,
) -> None:
    """Store Q where a look-up of the key has just found its class, or found none (`ABSENT`)."""
    if row == ABSENT:
        row, variant = append(table.rows, owner, key), 0
    equivalent = classes.phase_image[shape, variant, action]
    table.value[owner, row, equivalent] = value
    table.tried[owner, row, equivalent] = True
    table.visits[owner, row] += 1


@kernel
def best_tried(table: ValueTable, owner: int, row: int, count: int) -> int:
    """Return the tried action with the highest Q, the first of equals; −1 if none was tried."""
    best = ABSENT
    for action in range(count):
        if table.tried[owner, row, action] and (
            best == ABSENT or table.value[owner, row, action] > table.value[owner, row, best]
        ):
            best = action
    return best


@kernel
def clear_values(table: ValueTable, owner: int) -> None:
    """Empty a table of values."""
    for row in range(table.rows.size[owner]):
        forget_values(table, owner, row)
        table.visits[owner, row] = 0
    clear(table.rows, owner)


@kernel
def forget_values(table: ValueTable, owner: int, row: int) -> None:
    """Make all actions of a row untried."""
    for action in range(table.value.shape[2]):
        table.value[owner, row, action] = 0.0
        table.tried[owner, row, action] = False


@kernel
def copy_values(table: ValueTable, source: int, goal: int) -> None:
    """Make one owner's table equal to another's, the counts of visits excepted."""
    copy_rows(table.rows, source, goal)
    for row in range(table.rows.size[source]):
        for action in range(table.value.shape[2]):
            table.value[goal, row, action] = table.value[source, row, action]
            table.tried[goal, row, action] = table.tried[source, row, action]


@kernel
def copy_best(table: BestTable, source: int, goal: int) -> None:
    """Make one owner's table equal to another's."""
    copy_rows(table.rows, source, goal)
    for row in range(table.rows.size[source]):
        table.action[goal, row] = table.action[source, row]
        table.value[goal, row] = table.value[source, row]
