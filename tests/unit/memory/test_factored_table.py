"""The table of parts: how its entries learn, count, doubt and are loaded."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dmil.errors import PolicyError
from dmil.memory.factored import MOST, learn_part, make_factored_table, restored_table, surely

ERRORS = st.lists(st.floats(-100.0, 100.0, width=32), max_size=40)


def table_of(first, second=(), *, with_errors=True):
    """One row of three columns: what the first two learned."""
    table = make_factored_table(1, 3, with_errors=with_errors)
    for column, errors in enumerate((first, second)):
        for error in errors:
            learn_part(table, 0, column, error)
    return table


def step(number):
    return max(0.01, 0.1 / (1 + number / 5) ** 0.6)


def test_steps_get_smaller_down_to_a_hundredth():
    table, moved = make_factored_table(1, 1), []
    for _ in range(400):
        before = float(table.residual[0, 0])
        learn_part(table, 0, 0, 1.0)
        moved.append(float(table.residual[0, 0]) - before)
    assert moved == pytest.approx([step(n) for n in range(400)], rel=1e-4)
    assert moved[0] == pytest.approx(0.1)
    assert moved[300:] == pytest.approx([0.01] * 100, rel=1e-3)


def test_a_residual_comes_to_what_is_always_missing():
    table = make_factored_table(1, 1)
    for _ in range(2000):
        learn_part(table, 0, 0, 7.0 - float(table.residual[0, 0]))
    assert float(table.residual[0, 0]) == pytest.approx(7.0, abs=1e-3)


@given(ERRORS)
def test_other_entries_stay(errors):
    table = make_factored_table(3, 2, with_errors=True)
    for error in errors:
        learn_part(table, 1, 1, error)
    for array in table:
        assert not np.delete(array.ravel(), 3).any()
    assert table.times[1, 1] == len(errors)
    assert table.entries == bool(errors)


@given(ERRORS)
def test_the_running_square_is_a_mean_of_squares(errors):
    """The mean at first; then steps that are no smaller than those of the residual."""
    square = 0.0
    for number, error in enumerate(errors):
        weight = max(step(number), 1 / (1 + number))
        square = (1 - weight) * square + weight * error**2
    found = float(table_of(errors).square[0, 0])
    assert found == pytest.approx(square, rel=1e-4, abs=1e-4)
    if errors:
        squares = [error**2 for error in errors]
        assert min(squares) - 1e-3 <= found <= max(squares) * (1 + 1e-5)
    if 0 < len(errors) <= 15:
        assert found == pytest.approx(np.mean(squares), rel=1e-4, abs=1e-4)


def test_counts_stop_at_the_most():
    table = make_factored_table(1, 1, with_errors=True)
    table.times[0, 0] = MOST - 1
    for _ in range(3):
        learn_part(table, 0, 0, 1.0)
        assert table.times[0, 0] == MOST
    assert float(table.residual[0, 0]) == pytest.approx(3 * 0.01)


@given(ERRORS, ERRORS, st.floats(0.0, 5.0))
def test_surely_by_the_definition(first, second, errors):
    table = table_of(first, second)
    difference = float(table.residual[0, 0]) - float(table.residual[0, 1])
    doubt = errors * math.sqrt(
        sum(float(table.square[0, k]) / max(1, int(table.times[0, k])) for k in (0, 1))
    )
    found = surely(table, 0, 0, 1, errors)
    assert abs(found) == pytest.approx(max(0.0, abs(difference) - doubt), rel=1e-5, abs=1e-4)
    assert found * difference >= 0
    assert found == -surely(table, 0, 1, 0, errors)


@given(ERRORS, ERRORS, st.floats(0.0, 5.0), st.floats(0.0, 5.0))
def test_who_asks_for_more_evidence_believes_less(first, second, some, more):
    table = table_of(first, second)
    some, more = sorted((some, more))
    assert abs(surely(table, 0, 0, 1, more)) <= abs(surely(table, 0, 0, 1, some))


@given(ERRORS, ERRORS)
def test_without_errors_it_is_the_plain_difference(first, second):
    table = table_of(first, second, with_errors=False)
    expected = float(table.residual[0, 0]) - float(table.residual[0, 1])
    expected = pytest.approx(expected, abs=1e-5)
    assert surely(table, 0, 0, 1, 2.0) == expected
    assert surely(table_of(first, second), 0, 0, 1, 0.0) == expected
    assert table.square.size == 0


def test_one_look_is_no_evidence():
    """Of a single error e a residual moves by e/10; its standard error is e."""
    assert surely(table_of([10.0]), 0, 0, 2, 0.5) == 0.0
    assert surely(table_of([10.0]), 0, 0, 2, 0.0) == pytest.approx(1.0)
    assert surely(table_of([10.0] * 50), 0, 0, 2, 0.5) > 10.0


def test_bytes_and_entries_are_the_arrays():
    plain, careful = make_factored_table(288, 3), make_factored_table(288, 3, with_errors=True)
    assert plain.bytes_total == 288 * 3 * (4 + 2)
    assert careful.bytes_total == 288 * 3 * (4 + 2 + 4)
    assert plain.entries == careful.entries == 0
    learn_part(careful, 5, 2, 0.0)
    assert careful.entries == 1


def test_loading_copies_and_checks():
    saved, like = table_of([1.0, 2.0]), make_factored_table(1, 3, with_errors=True)
    loaded = restored_table(saved._asdict(), like)
    for array, other in zip(saved, loaded, strict=True):
        assert array.tobytes() == other.tobytes()
        assert not np.shares_memory(array, other)
    narrow = make_factored_table(1, 2, with_errors=True)
    assert restored_table(saved._asdict(), narrow).residual.shape == (1, 3)
    with pytest.raises(PolicyError, match="array 'residual' holds"):
        restored_table(narrow._asdict(), like)
    with pytest.raises(PolicyError, match="array 'square' holds"):
        restored_table(saved._asdict(), make_factored_table(1, 3))
    with pytest.raises(PolicyError, match="array 'times' is missing"):
        restored_table({"residual": saved.residual}, like)
    saved.residual[0, 0] = np.inf
    with pytest.raises(PolicyError, match="holds numbers that cannot be"):
        restored_table(saved._asdict(), like)
