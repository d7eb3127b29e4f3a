"""The check of a hyperparameter choice says which condition fails."""

from __future__ import annotations

import math

import numpy as np
import pytest

from dmil.errors import InputError
from dmil.theory import Condition, best_case, check_hyperparameters, failing, worst_case


def _named(
    actions: int, ratio: float, period: int, states: int | None = None
) -> dict[str, Condition]:
    conditions = check_hyperparameters(actions, ratio, period, states)
    named = {condition.name: condition for condition in conditions}
    assert len(named) == len(conditions)
    return named


def test_the_papers_setting_with_enough_states_meets_all() -> None:
    assert failing(check_hyperparameters(8, 0.5, 16, 26)) == []


def test_too_few_states_fail_before_staging_only() -> None:
    names = [condition.name for condition in failing(check_hyperparameters(8, 0.5, 16, 25))]
    assert names == ["best case before staging", "any trajectory"]
    needed = _named(8, 0.5, 16, 25)["any trajectory"].needed
    assert needed == 16 * 8 / 5


def test_without_the_number_of_states_nothing_is_said_about_it() -> None:
    named = _named(8, 0.5, 16)
    for name in ("best case after staging", "best case before staging", "any trajectory"):
        assert named[name].holds is None
        assert named[name].found is None
    assert failing(named.values()) == []


def test_three_actions_are_never_enough() -> None:
    named = _named(3, 0.5, 16)
    assert named["actions"].holds is False
    for name in ("best case after staging", "best case before staging", "any trajectory"):
        assert named[name].holds is False
        assert named[name].needed == math.inf


def test_the_printed_order_is_shown_beside_the_corrected_one() -> None:
    named = _named(4, 1.0, 3)
    assert named["order of the ratios"].holds is True
    assert named["order of the ratios as printed"].holds is False
    assert named["order of the ratios as printed"].needed == 15
    for period in (1, 2):
        named = _named(8, 0.5, period)
        assert named["order of the ratios"].holds is True
        assert named["order of the ratios as printed"].needed is None
        assert named["period as printed"].holds is False
        assert failing(named.values()) == []


def test_whole_rows_can_break_the_worst_case() -> None:
    named = _named(2, 2 / 3, 1)
    assert named["worst case"].holds is True
    assert named["worst case, whole rows"].holds is False
    assert named["worst case, whole rows"].needed == 3


@pytest.mark.parametrize("actions", range(1, 10))
@pytest.mark.parametrize("ratio", [0.1, 0.25, 0.5, 0.75, 1.0])
@pytest.mark.parametrize("period", [1, 2, 3, 7])
def test_verdicts_agree_with_the_ratios_themselves(actions: int, ratio: float, period: int) -> None:
    above = 1 - 1e-12
    named = _named(actions, ratio, period, 9)
    zeta1, zeta2 = worst_case(actions, ratio, period, np.arange(1, 50))
    assert named["worst case"].holds == bool((zeta1 >= above).all() and (zeta2 >= above).all())
    assert named["order of the ratios"].holds == bool((zeta1 >= zeta2 * above).all())
    assert named["staging ratio"].holds == named["worst case"].holds
    best = best_case(actions, period, 9)
    assert named["best case after staging"].holds == bool(best.zeta1 >= above)
    assert named["best case before staging"].holds == bool(best.zeta2 >= above)
    assert named["any trajectory"].holds == named["best case before staging"].holds


def test_bad_input_is_named() -> None:
    with pytest.raises(InputError, match=r"^distinct_states: found 0"):
        check_hyperparameters(8, 0.5, 16, 0)
    with pytest.raises(InputError, match=r"^staged_ratio: found 2"):
        check_hyperparameters(8, 2, 16)


def test_equality_is_enough() -> None:
    assert failing(check_hyperparameters(8, 0.5, 15, 24)) == []
    named = _named(3, 1.0, 4)
    assert named["worst case"].holds is True
    assert named["worst case, whole rows"].holds is True
