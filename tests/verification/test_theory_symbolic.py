"""Each statement on memory growth, proved with symbols.

a, k, T, n, M stand for |A|, κ, T_stage, stagings and distinct states. Where a variable has a
least value, it is written as that value plus a non-negative symbol, so that the sign of an
expanded polynomial can be read off its coefficients.
"""

from __future__ import annotations

import pytest
import sympy as sp

from dmil.theory import best_case, memory_sizes, worst_case

a, k, T, n, M = sp.symbols("a k T n M", positive=True)
u, v, w, r = sp.symbols("u v w r", nonnegative=True)

ZETA1 = (n * T + 1) * a / (a + 3 * n * k * T)
ZETA2 = n * T * a / (T * a + 3 * (n - 1) * k * T)
BEST1 = M * a / (a + 3 * M)
BEST2 = M * a / (T * a + 3 * M)


def _zero(expression: sp.Expr) -> bool:
    return sp.simplify(expression) == 0


def _never_negative(expression: sp.Expr) -> bool:
    """Whether all coefficients are non-negative, for non-negative symbols."""
    return all(c >= 0 for c in sp.Poly(sp.expand(expression), *expression.free_symbols).coeffs())


def test_the_package_computes_these_expressions() -> None:
    values = {a: 7, k: sp.Rational(1, 4), T: 12, n: 5, M: 31}
    worst = worst_case(7, 0.25, 12, 5)
    best = best_case(7, 12, 31)
    for got, symbolic in zip((*worst, *best), (ZETA1, ZETA2, BEST1, BEST2), strict=True):
        assert float(got) == pytest.approx(float(symbolic.subs(values)), rel=1e-15)


def test_recurrence_gives_t_modulo_period_plus_one_only_when_corrected() -> None:
    # Between stagings m_s grows by one; at one it restarts at 1: both sides of the step agree.
    assert _zero(1 + (r + 1) - ((r + 1) + 1))
    for period in range(1, 8):
        corrected, printed = 1, 1
        history = [(corrected, printed)]
        for t in range(1, 6 * period):
            staged = t % period == 0
            corrected = 1 + corrected * (not staged)
            printed = (printed + 1) * (not staged)
            assert corrected == t % period + 1
            history.append((corrected, printed))
        assert history[period] == (1, 0)
        assert history[2 * period - 1] == (period, period - 1)


def test_worst_case_after_staging_is_at_least_one_exactly_if_a_is_at_least_3k() -> None:
    top, bottom = (n * T + 1) * a, a + 3 * n * k * T
    assert _zero(ZETA1 - top / bottom)
    assert _zero(top - bottom - n * T * (a - 3 * k))


def test_worst_case_before_staging_equals_one_at_first_and_then_has_the_sign_of_a_minus_3k() -> (
    None
):
    assert _zero(ZETA2.subs(n, 1) - 1)
    top, bottom = n * T * a, T * a + 3 * (n - 1) * k * T
    assert _zero(ZETA2 - top / bottom)
    assert _zero(top - bottom - (n - 1) * T * (a - 3 * k))


def test_worst_case_between_stagings_has_the_sign_of_a_minus_3k() -> None:
    sarsa, dual = a * (n * T + r + 1), a * (r + 1) + 3 * n * k * T
    assert _zero(sarsa - dual - n * T * (a - 3 * k))
    assert _zero((sarsa / dual).subs(r, 0) - ZETA1)
    assert _zero((sarsa / dual).subs(r, T - 1) - ZETA2.subs(n, n + 1))


def test_ratios_are_in_order_exactly_if_a_is_at_least_3k_for_every_period() -> None:
    cross = (n * T + 1) * a * (T * a + 3 * (n - 1) * k * T) - n * T * a * (a + 3 * n * k * T)
    assert _zero(cross - a * T * (a - 3 * k) * (n * (T - 1) + 1))
    # The other factors are positive for T = 1 + u, n = 1 + v.
    assert _never_negative((n * (T - 1) + 1).subs({T: 1 + u, n: 1 + v}) - 1)


def test_the_printed_order_condition_is_enough_but_not_needed_nor_defined_at_2() -> None:
    printed = 3 * k * (T + 2) / (T - 2)
    values = {a: 4, k: sp.Rational(1, 2), T: 4, n: 1}
    assert ZETA1.subs(values) == 2
    assert ZETA2.subs(values) == 1
    assert printed.subs(values) == sp.Rational(9, 2) > 4
    # It is enough where it is defined: for T = 3 + u it asks for at least 3κ.
    top, bottom = sp.fraction(sp.together((printed - 3 * k).subs(T, 3 + u)))
    assert _never_negative(top)
    assert _never_negative(bottom)
    assert printed.subs(T, 2) == sp.zoo
    for period in (1, 2):
        gap = sp.factor((ZETA1 - ZETA2).subs({T: period, a: 3 * k + w, n: 1 + v}))
        top, bottom = sp.fraction(sp.together(gap))
        assert _never_negative(top)
        assert _never_negative(bottom)


def test_both_worst_case_ratios_tend_to_a_over_3k() -> None:
    assert _zero(sp.limit(ZETA1, n, sp.oo) - a / (3 * k))
    assert _zero(sp.limit(ZETA2, n, sp.oo) - a / (3 * k))


def test_ratio_at_the_start_is_one_only_with_an_empty_long_term_memory() -> None:
    assert sp.solve(sp.Eq(a / (a + 3 * u), 1), u) == [0]


def test_best_case_thresholds() -> None:
    more = 3 + w  # |A| > 3
    for ratio, rows in ((BEST1, sp.Integer(1)), (BEST2, T)):
        assert _zero(ratio - M * a / (rows * a + 3 * M))
        threshold = rows * a / (a - 3)
        assert _zero((M * a - (rows * a + 3 * M)) - (a - 3) * (M - threshold))
    # Three actions or fewer: numerator below denominator for every M.
    few = [sp.Poly(rows * c + 3 * M - M * c, M, T) for c in (1, 2, 3) for rows in (1, T)]
    assert all(all(coefficient > 0 for coefficient in p.coeffs()) for p in few)
    # Each threshold exceeds the rows of short-term memory it was computed with.
    assert _zero((T * a / (a - 3) - T).subs(a, more) - 3 * T / w)


def test_capping_short_term_memory_at_the_states_moves_no_threshold() -> None:
    # For M ≤ T the corrected ratio is |A|/(|A|+3), below 1; and M ≤ T is below the threshold.
    capped = M * a / (sp.Min(T, M) * a + 3 * M)
    assert _zero(capped.subs(T, M + u) - a / (a + 3))
    assert _zero(capped.subs(M, T + u) - BEST2.subs(M, T + u))


def test_best_case_ratios_are_in_order_for_every_period() -> None:
    gap = (T * a + 3 * M) - (a + 3 * M)
    assert _never_negative(gap.subs(T, 1 + u))
    assert sp.limit(BEST1, M, sp.oo) == sp.limit(BEST2, M, sp.oo) == a / 3


def test_worst_case_condition_is_not_enough_in_the_best_case() -> None:
    assert BEST2.subs({a: 8, T: 16, M: 25}) == sp.Rational(200, 203)


def test_enough_states_make_the_ratio_at_least_one_on_any_trajectory() -> None:
    # m_s = T − v, m_L = m_Q − u, m_Q = T|A|/(|A|−3) + w: the only facts used are m_s ≤ T and
    # m_L ≤ m_Q.
    m_q = T * a / (a - 3) + w
    difference = a * m_q - a * (T - v) - 3 * (m_q - u)
    assert _zero(difference - ((a - 3) * w + a * v + 3 * u))


def test_the_bound_on_the_staging_ratio_binds_below_three_actions_alone() -> None:
    # κ = 1 − v, |A| = 3 + w: |A|/3 − κ has no negative term.
    assert _never_negative((3 + w) / 3 - (1 - v))
    assert sp.Rational(2, 3) < 1  # with two actions κ = 1 violates it


def test_a_smaller_staging_ratio_raises_the_worst_case() -> None:
    top1 = sp.fraction(sp.together(sp.diff(ZETA1, k)))[0]
    assert _never_negative(-sp.expand(top1))
    top2, bottom2 = sp.fraction(sp.factor(sp.diff(ZETA2, k)))
    assert _zero(top2 / bottom2 + 3 * n * a * (n - 1) / (a + 3 * (n - 1) * k) ** 2)
    assert not (BEST1.free_symbols | BEST2.free_symbols) & {k}


def test_a_longer_period_widens_the_gap_and_needs_more_states() -> None:
    slope = sp.diff(ZETA1 - ZETA2, T)
    expected = (
        n * a * (a - 3 * k) * (a + 3 * (n - 1) * k)
        / ((a + 3 * n * k * T) ** 2 * (a + 3 * (n - 1) * k))
    )  # fmt: skip
    assert _zero(slope - expected)
    assert _zero(sp.diff(T * a / (a - 3), T) - a / (a - 3))


def test_lemma_3_fails_without_a_condition_on_the_states_met() -> None:
    # T + 1 distinct states, then T − 1 revisits of the first ones.
    general = a * (T + 1) / (a * T + 3 * k * T)
    assert general.subs({a: 8, k: sp.Rational(1, 2), T: 16}) == sp.Rational(136, 152)
    assert _zero(a * (T + 1) - (a * T + 3 * k * T) - (a - 3 * k * T))
    sizes = memory_sizes([*range(17), *range(15)], 8, 0.5, 16)
    assert (sizes.sarsa_entries[-1], sizes.dual_entries[-1]) == (136, 152)


def test_whole_rows_replace_the_staging_ratio_by_its_rounding() -> None:
    staged = sp.ceiling(k * T)
    exact = ZETA1.subs(k, staged / T)
    values = {a: 2, k: sp.Rational(2, 3), T: 1, n: 1}
    assert exact.subs(values) == sp.Rational(4, 5)
    assert ZETA1.subs(values) == 1
    # ⌈κT⌉ ≤ T, so |A| ≥ 3 is always enough: |A|T − 3⌈κT⌉ with ⌈κT⌉ = T − v, |A| = 3 + w.
    assert _never_negative((3 + w) * T - 3 * (T - v))
