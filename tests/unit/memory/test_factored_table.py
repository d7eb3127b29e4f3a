"""The table of parts: how its entries learn, count and are loaded."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dmil.errors import PolicyError
from dmil.memory.residuals import MOST, learn_part, make_residuals, restored_residuals

ERRORS = st.lists(st.floats(-100.0, 100.0, width=32), max_size=40)


def table_of(first, second=()):
    """One row of three columns: what the first two learned."""
    table = make_residuals(1, 3)
    for column, errors in enumerate((first, second)):
        for error in errors:
            learn_part(table, 0, column, error)
    return table


def step(number):
    return max(0.01, 0.1 / (1 + number / 5) ** 0.6)


def test_steps_get_smaller_down_to_a_hundredth():
    table, moved = make_residuals(1, 1), []
    for _ in range(400):
        before = float(table.residual[0, 0])
        learn_part(table, 0, 0, 1.0)
        moved.append(float(table.residual[0, 0]) - before)
    assert moved == pytest.approx([step(n) for n in range(400)], rel=1e-4)
    assert moved[0] == pytest.approx(0.1)
    assert moved[300:] == pytest.approx([0.01] * 100, rel=1e-3)


def test_a_residual_comes_to_what_is_always_missing():
    table = make_residuals(1, 1)
    for _ in range(2000):
        learn_part(table, 0, 0, 7.0 - float(table.residual[0, 0]))
    assert float(table.residual[0, 0]) == pytest.approx(7.0, abs=1e-3)


@given(ERRORS)
def test_other_entries_stay(errors):
    table = make_residuals(3, 2)
    for error in errors:
        learn_part(table, 1, 1, error)
    for array in table:
        assert not np.delete(array.ravel(), 3).any()
    assert table.times[1, 1] == len(errors)
    assert table.entries == bool(errors)


def test_counts_stop_at_the_most():
    table = make_residuals(1, 1)
    table.times[0, 0] = MOST - 1
    for _ in range(3):
        learn_part(table, 0, 0, 1.0)
        assert table.times[0, 0] == MOST
    assert float(table.residual[0, 0]) == pytest.approx(3 * 0.01)


def test_bytes_and_entries_are_the_arrays():
    table = make_residuals(288, 3)
    assert table.bytes_total == 288 * 3 * (4 + 2)
    assert table.entries == 0
    learn_part(table, 5, 2, 0.0)
    assert table.entries == 1


def test_loading_copies_and_checks():
    saved, like = table_of([1.0, 2.0]), make_residuals(1, 3)
    loaded = restored_residuals(saved._asdict(), like)
    for array, other in zip(saved, loaded, strict=True):
        assert array.tobytes() == other.tobytes()
        assert not np.shares_memory(array, other)
    narrow = make_residuals(1, 2)
    assert restored_residuals(saved._asdict(), narrow).residual.shape == (1, 3)
    with pytest.raises(PolicyError, match="array 'residual' holds"):
        restored_residuals(narrow._asdict(), like)
    with pytest.raises(PolicyError, match="array 'times' is missing"):
        restored_residuals({"residual": saved.residual}, like)
    saved.residual[0, 0] = np.inf
    with pytest.raises(PolicyError, match="holds numbers that cannot be"):
        restored_residuals(saved._asdict(), like)
