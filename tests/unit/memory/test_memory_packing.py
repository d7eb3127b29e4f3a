"""Memories as flat arrays: back and forth without loss, and arrays that do not fit."""

import numpy as np
import pytest

from dmil.errors import PolicyError
from dmil.memory import (
    append,
    bytes_used,
    find,
    make_best_table,
    make_value_table,
    pack,
    unpack_bests,
    unpack_values,
)
from dmil.memory.rows import LEVELS
from dmil.seeding import stream

PLACES, ACTIONS = 6, 4


def filled(kind, tolerance, sizes=(5, 0, 70)):
    rng = stream(1, "packing")
    table = (
        make_value_table(3, 80, PLACES, ACTIONS, tolerance)
        if kind == "values"
        else make_best_table(3, 80, PLACES, tolerance)
    )
    for owner, size in enumerate(sizes):
        for row in range(size):
            # Keys 3 apart in one place: no two are near.
            key = rng.integers(0, 40, PLACES)
            key[0] = 3 * row
            append(table.rows, owner, key.astype(np.int32))
        for name, column in table._asdict().items():
            if name != "rows":
                drawn = 100 * rng.standard_normal((*column.shape[2:], size))
                column[owner, :size] = np.moveaxis(drawn, -1, 0).astype(column.dtype)
    return table


def unpacked(kind, arrays, like):
    return unpack_values(arrays, like) if kind == "values" else unpack_bests(arrays, like)


@pytest.mark.parametrize("kind", ["values", "bests"])
@pytest.mark.parametrize("tolerance", [0, 1])
def test_a_round_trip_loses_nothing(kind, tolerance):
    table = filled(kind, tolerance)
    arrays = pack(table)
    again = unpacked(kind, arrays, filled(kind, tolerance, (0, 0, 0)))
    back = pack(again)
    assert list(back) == list(arrays)
    for name, array in arrays.items():
        assert (back[name].dtype, back[name].shape) == (array.dtype, array.shape)
        assert back[name].tobytes() == array.tobytes()
    for owner in (0, 2):
        for row in range(table.rows.size[owner]):
            key = table.rows.keys[owner, row : row + 1]
            assert find(again.rows, owner, key, 1) == (row, 0)
    assert arrays["keys"].shape == (75, PLACES)


@pytest.mark.parametrize("kind", ["values", "bests"])
def test_packed_arrays_are_copies(kind):
    table = filled(kind, 1)
    arrays = pack(table)
    before = {name: array.copy() for name, array in arrays.items()}
    table.value[:] = 0.0
    table.rows.keys[:] = 0
    table.rows.size[:] = 0
    for name, array in arrays.items():
        np.testing.assert_array_equal(array, before[name])


@pytest.mark.parametrize(
    ("name", "change", "message"),
    [
        ("size", lambda a: a[:2], "array 'size': (2,) int32; expected 3 numbers of rows"),
        ("size", lambda a: a.astype(float), "array 'size'"),
        ("size", lambda a: a - 1, "array 'size'"),
        ("size", lambda a: a + np.array([1, 0, 0], np.int32), "array 'keys'"),
        ("keys", lambda a: a[:, :5], "(75, 5) int32; expected (75, 6) int32"),
        ("keys", lambda a: a.astype(np.int64), "(75, 6) int64; expected (75, 6) int32"),
        ("value", lambda a: a[:, :3], "array 'value'"),
        ("value", lambda a: a[:-1], "array 'value'"),
        ("tried", lambda a: a.astype(int), "array 'tried'"),
        ("visits", lambda a: None, "array 'visits': missing"),
        ("keys", lambda a: None, "array 'keys': missing"),
        ("size", lambda a: None, "array 'size': missing"),
    ],
)
def test_arrays_that_do_not_fit_are_named(name, change, message):
    arrays = pack(filled("values", 1))
    changed = change(arrays.pop(name))
    if changed is not None:
        arrays[name] = changed
    with pytest.raises(PolicyError) as error:
        unpack_values(arrays, filled("values", 1))
    assert message in str(error.value)


def test_long_term_arrays_are_checked_too():
    arrays = pack(filled("bests", 0))
    arrays["action"] = arrays["action"][:-1]
    with pytest.raises(PolicyError, match="action"):
        unpack_bests(arrays, filled("bests", 0))


def test_bytes_count_what_is_stored_and_its_index():
    table = filled("values", 0)
    row = 4 * PLACES + 8 * ACTIONS + ACTIONS + 4
    assert bytes_used(table.rows, table[1:]) == 75 * (row + 2 * 4)
    table = filled("bests", 1)
    row = 4 * PLACES + 4 + 8
    assert bytes_used(table.rows, table[1:]) == 75 * (row + PLACES * LEVELS // 8)
