"""Closed forms and the check of their parameters."""

from __future__ import annotations

import numpy as np
import pytest

from dmil.errors import InputError
from dmil.theory import best_case, enough_states, staged_rows, worst_case, worst_case_limit


def test_worst_case_of_the_papers_setting() -> None:
    # |A| = 8, κ = 1/2, T = 16: 17·8 / (8 + 24) and 16·8 / (16·8).
    zeta1, zeta2 = worst_case(8, 0.5, 16, 1)
    assert float(zeta1) == 136 / 32
    assert float(zeta2) == 1.0


def test_worst_case_takes_any_shape_of_stagings() -> None:
    n = np.arange(1, 7).reshape(2, 3)
    zeta1, zeta2 = worst_case(5, 0.25, 4, n)
    assert zeta1.shape == zeta2.shape == (2, 3)
    for index in np.ndindex(n.shape):
        alone = worst_case(5, 0.25, 4, int(n[index]))
        assert (zeta1[index], zeta2[index]) == (float(alone.zeta1), float(alone.zeta2))


def test_worst_case_nears_its_limit() -> None:
    limit = worst_case_limit(8, 0.5)
    assert limit == 16 / 3
    ratios = worst_case(8, 0.5, 16, 10**7)
    assert np.allclose(ratios, limit, rtol=1e-6)


def test_best_case_caps_short_term_memory_at_the_distinct_states() -> None:
    zeta1, zeta2 = best_case(8, 16, [4, 16, 40])
    assert zeta1.tolist() == [32 / 20, 128 / 56, 320 / 128]
    assert zeta2.tolist() == [32 / 44, 128 / 176, 320 / 248]
    printed = best_case(8, 16, [4, 16, 40], as_printed=True)
    assert printed.zeta2.tolist() == [32 / 140, 128 / 176, 320 / 248]
    assert np.array_equal(printed.zeta1, zeta1)


def test_enough_states_is_where_the_best_case_passes_one() -> None:
    assert enough_states(8, 15) == 24.0
    assert float(best_case(8, 15, 24).zeta2) == 1.0
    assert float(best_case(8, 15, 23).zeta2) < 1.0
    assert enough_states(3, 1) == enough_states(1, 1) == float("inf")


@pytest.mark.parametrize(
    ("rows", "ratio", "staged"),
    [
        (16, 0.5, 8),
        (15, 0.5, 8),
        (1, 0.01, 1),
        (100, 0.07, 7),
        (3, 1 / 3, 1),
        (5, 1.0, 5),
        (0, 1, 0),
    ],
)
def test_whole_rows_are_staged(rows: int, ratio: float, staged: int) -> None:
    assert staged_rows(rows, ratio) == staged


@pytest.mark.parametrize(
    ("actions", "ratio", "period", "name"),
    [
        (0, 0.5, 16, "actions"),
        (8.0, 0.5, 16, "actions"),
        (True, 0.5, 16, "actions"),
        (8, 0.0, 16, "staged_ratio"),
        (8, 1.01, 16, "staged_ratio"),
        (8, float("nan"), 16, "staged_ratio"),
        (8, "half", 16, "staged_ratio"),
        (8, True, 16, "staged_ratio"),
        (8, 0.5, 0, "stage_period"),
        (8, 0.5, 2.5, "stage_period"),
    ],
)
def test_a_hyperparameter_out_of_range_is_named(
    actions: int, ratio: float, period: int, name: str
) -> None:
    with pytest.raises(InputError, match=f"^{name}: found .*; expected "):
        worst_case(actions, ratio, period, 1)


@pytest.mark.parametrize("bad", [0, [1, 0], 1.5, ["a"], [[1], [1, 2]]])
def test_bad_counts_are_named(bad: object) -> None:
    with pytest.raises(InputError, match=r"^stagings: .*whole numbers of at least 1"):
        worst_case(8, 0.5, 16, bad)  # type: ignore[arg-type]
    with pytest.raises(InputError, match=r"^distinct_states: "):
        best_case(8, 16, bad)  # type: ignore[arg-type]


def test_numpy_numbers_are_numbers() -> None:
    ratios = worst_case(np.int64(8), np.float32(0.5), np.int32(16), np.int16(1))  # type: ignore[arg-type]
    assert float(ratios.zeta1) == 136 / 32
