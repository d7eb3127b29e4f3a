"""What is stored in keyed rows: values of all actions, or the best action alone."""

from __future__ import annotations

from typing import NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt

from dmil.compilation import kernel
from dmil.memory.rows import (
    ABSENT,
    Rows,
    append,
    clear,
    copy_rows,
    find,
    is_short_of_room,
    make_rows,
    rows_of,
    with_room,
)
from dmil.symmetry import Classes, vary

IntArray = npt.NDArray[np.int32]
FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]
Scalar = TypeVar("Scalar", bound=np.generic)


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


def make_value_table(
    owners: int, capacity: int, places: int, actions: int, tolerance: int
) -> ValueTable:
    """Return an empty table of values (ours)."""
    return ValueTable(
        rows=make_rows(owners, capacity, places, tolerance),
        value=np.zeros((owners, capacity, actions)),
        tried=np.zeros((owners, capacity, actions), np.bool_),
        visits=np.zeros((owners, capacity), np.int32),
    )


def make_best_table(owners: int, capacity: int, places: int, tolerance: int) -> BestTable:
    """Return an empty table of best actions (ours)."""
    return BestTable(
        rows=make_rows(owners, capacity, places, tolerance),
        action=np.zeros((owners, capacity), np.int32),
        value=np.zeros((owners, capacity)),
    )


def value_table_with_room(table: ValueTable, more: int) -> ValueTable:
    """Return the table with room for ``more`` rows per owner, the same one if it has it (ours)."""
    if not is_short_of_room(table.rows, more):
        return table
    rows = with_room(table.rows, more)
    capacity = rows.keys.shape[1]
    return ValueTable(
        rows,
        _longer(table.value, capacity),
        _longer(table.tried, capacity),
        _longer(table.visits, capacity),
    )


def best_table_with_room(table: BestTable, more: int) -> BestTable:
    """Return the table with room for ``more`` rows per owner, the same one if it has it (ours)."""
    if not is_short_of_room(table.rows, more):
        return table
    rows = with_room(table.rows, more)
    capacity = rows.keys.shape[1]
    return BestTable(rows, _longer(table.action, capacity), _longer(table.value, capacity))


def values_of(table: ValueTable, owners: IntArray) -> ValueTable:
    """Give each new owner a copy of the table of the old owner that is named for it (ours)."""
    rows = rows_of(table.rows, owners)
    capacity = rows.keys.shape[1]
    value, tried, visits = (_for_owners(array, owners, capacity) for array in table[1:])
    return ValueTable(rows, value, tried, visits)


def bests_of(table: BestTable, owners: IntArray) -> BestTable:
    """Give each new owner a copy of the table of the old owner that is named for it (ours)."""
    rows = rows_of(table.rows, owners)
    capacity = rows.keys.shape[1]
    action, value = (_for_owners(array, owners, capacity) for array in table[1:])
    return BestTable(rows, action, value)


def _for_owners(array: npt.NDArray[Scalar], owners: IntArray, capacity: int) -> npt.NDArray[Scalar]:
    if capacity > array.shape[1]:
        array = _longer(array, capacity)
    return array[owners, :capacity]


def _longer(array: npt.NDArray[Scalar], capacity: int) -> npt.NDArray[Scalar]:
    longer = np.zeros((array.shape[0], capacity, *array.shape[2:]), array.dtype)
    longer[:, : array.shape[1]] = array
    return longer


class Scratch(NamedTuple):
    """Working space of the kernels, so that they allocate nothing.

    Attributes
    ----------
    variants: (symmetries, places) int32
    walk: (2, places + 1) int32
    key: (places,) int32
    """

    variants: IntArray
    walk: IntArray
    key: IntArray


def make_scratch(classes: Classes) -> Scratch:
    """Return working space for the keys of some classes (ours)."""
    _, variants, places = classes.orientation_image.shape
    return Scratch(
        variants=np.zeros((variants, places), np.int32),
        walk=np.zeros((2, places + 1), np.int32),
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
    return find(rows, owner, scratch.variants, count, scratch.walk)


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
) -> int:
    """Store Q for a key's class and the equivalent action (Algorithm 1, lines 5–11).

    Returns
    -------
    row: int
        The row written.
    """
    row, variant = look_up_or_append(table.rows, classes, owner, shape, key, scratch)
    equivalent = classes.phase_image[shape, variant, action]
    table.value[owner, row, equivalent] = value
    table.tried[owner, row, equivalent] = True
    table.visits[owner, row] += 1
    return row


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
