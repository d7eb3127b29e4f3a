"""Sizes along a trajectory and the curves above them."""

from __future__ import annotations

import numpy as np
import pytest

from dmil.errors import InputError, UnknownNameError
from dmil.theory import counterexample, memory_sizes, size_bounds, worst_case


def test_the_papers_lemma_3_fails_at_136_over_152() -> None:
    classes = counterexample(16)
    assert classes.tolist() == [*range(17), *range(15)]
    sizes = memory_sizes(classes, 8, 0.5, 16)
    assert (sizes.short_term_rows[-1], sizes.long_term_rows[-1], sizes.q_rows[-1]) == (16, 8, 17)
    assert (sizes.sarsa_entries[-1], sizes.dual_entries[-1]) == (136, 152)
    assert sizes.ratio[-1] == pytest.approx(0.895, abs=5e-4)


@pytest.mark.parametrize("period", [1, 2, 3, 16])
def test_one_state_met_again_and_again_is_the_smallest_counterexample(period: int) -> None:
    ratio = memory_sizes([7] * (period + 1), 8, 0.5, period).ratio
    assert (ratio[:-1] == 1.0).all()
    assert ratio[-1] == 8 / 11


@pytest.mark.parametrize(("period", "ratio"), [(1, 1.0), (2, 0.5), (4, 0.25), (16, 0.5)])
def test_new_states_only_give_the_closed_form(period: int, ratio: float) -> None:
    n = np.arange(1, 6)
    sizes = memory_sizes(np.arange(5 * period + 1), 8, ratio, period)
    expected = worst_case(8, ratio, period, n)
    np.testing.assert_allclose(sizes.ratio[n * period], expected.zeta1, rtol=1e-14)
    np.testing.assert_allclose(sizes.ratio[n * period - 1], expected.zeta2, rtol=1e-14)


def test_short_term_rows_follow_the_corrected_recurrence() -> None:
    rows = memory_sizes(np.arange(40), 8, 0.5, 6).short_term_rows
    expected = [1]
    for t in range(1, 40):
        expected.append(1 + expected[-1] * (0 if t % 6 == 0 else 1))
    assert rows.tolist() == expected


def test_a_full_memory_is_staged_at_once() -> None:
    sizes = memory_sizes([0, 1, 0, 2, 3, 3, 4, 5], 8, 0.5, 3, rule="full")
    assert sizes.short_term_rows.tolist() == [1, 2, 2, 0, 1, 1, 2, 0]
    assert sizes.long_term_rows.tolist() == [0, 0, 0, 2, 2, 2, 2, 4]
    assert sizes.q_rows.tolist() == [1, 2, 2, 3, 4, 4, 5, 6]


def test_preference_decides_how_fast_long_term_memory_grows() -> None:
    classes = [0, 1] * 5
    new = memory_sizes(classes, 8, 0.5, 2, prefer="new").long_term_rows
    known = memory_sizes(classes, 8, 0.5, 2, prefer="known").long_term_rows
    assert new.tolist() == [0, 0, 1, 1, 2, 2, 2, 2, 2, 2]
    assert known.tolist() == [0, 0, 1, 1, 1, 1, 1, 1, 1, 1]


def test_bounds_of_the_papers_setting() -> None:
    bounds = size_bounds(8, 0.5, 16, 64, distinct_states=20)
    t = np.arange(64)
    assert bounds.decision.tolist() == t.tolist()
    assert bounds.sarsa_worst.tolist() == (8 * (t + 1)).tolist()
    assert bounds.sarsa_best.tolist() == (8 * np.minimum(t + 1, 20)).tolist()
    unique = memory_sizes(t, 8, 0.5, 16).dual_entries
    assert np.array_equal(bounds.dual_worst, unique)
    cycle = memory_sizes(t % 20, 8, 0.5, 16).dual_entries
    assert np.array_equal(bounds.dual_best, cycle)


def test_imported_rows_lift_the_curves() -> None:
    bounds = size_bounds(8, 0.5, 16, 40, imported=11)
    plain = size_bounds(8, 0.5, 16, 40)
    assert (bounds.sarsa_worst - plain.sarsa_worst == 88).all()
    assert (bounds.dual_worst - plain.dual_worst == 3 * 6).all()
    assert (bounds.sarsa_best == 8 * 12).all()
    # 12 classes in all: short-term memory is capped there, long-term memory too.
    assert bounds.dual_best[15] == 8 * 12 + 3 * 6
    assert bounds.dual_best[-1] == 8 * 8 + 3 * 12


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("rule", ["period", "full"])
@pytest.mark.parametrize("prefer", ["new", "known"])
def test_no_random_trajectory_leaves_the_bounds(seed: int, rule: str, prefer: str) -> None:
    rng = np.random.default_rng(seed)
    states = int(rng.integers(1, 40))
    period = int(rng.integers(1, 12))
    ratio = float(rng.uniform(0.05, 1.0))
    classes = rng.integers(0, states, size=200)
    sizes = memory_sizes(classes, 8, ratio, period, rule=rule, prefer=prefer)  # type: ignore[arg-type]
    bounds = size_bounds(8, ratio, period, 200, distinct_states=states, rule=rule)  # type: ignore[arg-type]
    assert (sizes.dual_entries <= bounds.dual_best).all()
    assert (sizes.sarsa_entries <= bounds.sarsa_best).all()
    assert (bounds.dual_best <= bounds.dual_worst).all()
    assert (bounds.sarsa_best <= bounds.sarsa_worst).all()


def test_bounds_of_a_full_memory_wait_for_the_last_row() -> None:
    # Capacity 3: at t = 3 a revisit may have kept two rows in, which beats staging at t = 2.
    bounds = size_bounds(8, 0.5, 3, 4, distinct_states=9, rule="full")
    assert bounds.dual_worst.tolist() == [8, 16, 16, 16]
    assert memory_sizes([0, 1, 1, 1], 8, 0.5, 3, rule="full").dual_entries[-1] == 16
    never_full = size_bounds(8, 0.5, 3, 6, distinct_states=2, rule="full")
    assert never_full.dual_best.tolist() == [8, 16, 16, 16, 16, 16]


def test_bad_input_is_named() -> None:
    for bad in ([], [[0, 1]], [0.5], [-1], 3):
        with pytest.raises(InputError, match=r"^classes: "):
            memory_sizes(bad, 8, 0.5, 16)
    with pytest.raises(UnknownNameError, match=r"staging rule named 'periodic'.*'period'"):
        memory_sizes([0], 8, 0.5, 16, rule="periodic")  # type: ignore[arg-type]
    with pytest.raises(UnknownNameError, match=r"preference named 'newest'"):
        memory_sizes([0], 8, 0.5, 16, prefer="newest")  # type: ignore[arg-type]
    with pytest.raises(InputError, match=r"^decisions: "):
        size_bounds(8, 0.5, 16, 0)
    with pytest.raises(InputError, match=r"^distinct_states: "):
        size_bounds(8, 0.5, 16, 9, distinct_states=0)
    with pytest.raises(InputError, match=r"^imported: "):
        size_bounds(8, 0.5, 16, 9, imported=-1)
    with pytest.raises(UnknownNameError):
        size_bounds(8, 0.5, 16, 9, rule="")  # type: ignore[arg-type]
    with pytest.raises(InputError, match=r"^stage_period: "):
        counterexample(0)
