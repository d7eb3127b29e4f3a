"""Memory growth on every short trajectory, whatever rows are staged.

A twin of the simulation that branches over *every* choice of staged rows stands beside it:
what holds for all choices does not rest on how rows are ranked.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from fractions import Fraction
from itertools import combinations, product

import numpy as np
import pytest

from dmil.theory import (
    StagingRule,
    check_hyperparameters,
    enough_states,
    failing,
    memory_sizes,
    size_bounds,
    worst_case,
)

LENGTH = 7
ACTIONS = (1, 2, 3, 4, 5, 8, 20)
RATIOS = (Fraction(1, 4), Fraction(1, 3), Fraction(1, 2), Fraction(2, 3), Fraction(1))
PERIODS = (1, 2, 3, 4)


def trajectories(length: int) -> Iterator[tuple[int, ...]]:
    """Every sequence of classes up to renaming: each new class gets the next number."""

    def grow(head: tuple[int, ...], used: int) -> Iterator[tuple[int, ...]]:
        if len(head) == length:
            yield head
            return
        for key in range(used + 1):
            yield from grow((*head, key), max(used, key + 1))

    yield from grow((), 0)


def all_sizes(
    classes: tuple[int, ...], ratio: Fraction, period: int
) -> set[tuple[int, int, int, int]]:
    """All (t, m_s, m_L, m_Q) that some choice of staged rows leads to."""
    found = set()
    memories = {(frozenset[int](), frozenset[int]())}
    for t, key in enumerate(classes):
        after = set()
        for short_term, long_term in memories:
            if t and t % period == 0:
                take = math.ceil(ratio * len(short_term))
                for staged in combinations(sorted(short_term), take):
                    after.add((frozenset({key}), long_term | frozenset(staged)))
            else:
                after.add((short_term | {key}, long_term))
        memories = after
        m_q = len(set(classes[: t + 1]))
        found |= {(t, len(short), len(long), m_q) for short, long in memories}
    return found


@pytest.fixture(scope="module")
def reached() -> dict[tuple[Fraction, int], set[tuple[int, int, int, int]]]:
    """All sizes that any trajectory of LENGTH reaches, by κ and T."""
    every = list(trajectories(LENGTH))
    assert len(every) == 877  # the Bell number of 7
    return {
        (ratio, period): set().union(*(all_sizes(c, ratio, period) for c in every))
        for ratio, period in product(RATIOS, PERIODS)
    }


Reached = dict[tuple[Fraction, int], set[tuple[int, int, int, int]]]


def test_no_memory_outgrows_the_distinct_states_or_the_period(reached: Reached) -> None:
    for (ratio, period), sizes in reached.items():
        for t, m_s, m_l, m_q in sizes:
            assert 1 <= m_s <= min(period, m_q, t % period + 1)
            assert m_l <= min(m_q, t // period * math.ceil(ratio * period))
        # The cap is reached for every M that leaves time for the period to end.
        for states in range(1, LENGTH - period + 1):
            rows = {m_s for _, m_s, _, m_q in sizes if m_q == states}
            assert max(rows) == min(period, states)


def test_enough_states_keep_dual_memory_the_smaller_on_every_trajectory(reached: Reached) -> None:
    met = 0
    for (_, period), sizes in reached.items():
        for actions in ACTIONS:
            for _, m_s, m_l, m_q in sizes:
                if m_q >= enough_states(actions, period):
                    met += 1
                    assert actions * m_q >= actions * m_s + 3 * m_l
    assert met > 1000


def test_one_state_fewer_is_not_enough() -> None:
    # κ = 1 stages everything; a cycle of M > T states then has m_s = T and m_L = M at last.
    tried = 0
    for actions, period in product((4, 5, 8, 20), (1, 2, 3, 4)):
        states = math.ceil(enough_states(actions, period)) - 1
        if states < period:
            continue
        tried += 1
        cycle = [t % states for t in range((states // period + 3) * period)]
        sizes = memory_sizes(cycle, actions, 1.0, period)
        assert (sizes.short_term_rows[-1], sizes.long_term_rows[-1]) == (period, states)
        assert sizes.sarsa_entries[-1] < sizes.dual_entries[-1]
    assert tried == 16


@pytest.mark.parametrize("prefer", ["new", "known"])
@pytest.mark.parametrize("period", PERIODS)
def test_the_simulation_is_one_of_the_branches(prefer: str, period: int) -> None:
    for ratio in (Fraction(1, 3), Fraction(1, 2), Fraction(1)):
        for classes in trajectories(6):
            sizes = memory_sizes(classes, 8, float(ratio), period, prefer=prefer)  # type: ignore[arg-type]
            branches = all_sizes(classes, ratio, period)
            rows = zip(sizes.short_term_rows, sizes.long_term_rows, sizes.q_rows, strict=True)
            for t, (m_s, m_l, m_q) in enumerate(rows):
                assert (t, m_s, m_l, m_q) in branches


def test_unique_states_attain_the_worst_case_and_no_trajectory_holds_more(
    reached: Reached,
) -> None:
    for (ratio, period), sizes in reached.items():
        unique = memory_sizes(range(LENGTH), 8, float(ratio), period)
        for t, m_s, m_l, m_q in sizes:
            assert m_s <= unique.short_term_rows[t]
            assert m_l <= unique.long_term_rows[t]
            assert m_q <= unique.q_rows[t]
        if (ratio * period).denominator == 1:
            for stagings in range(1, (LENGTH - 1) // period + 1):
                zeta1, zeta2 = worst_case(8, float(ratio), period, stagings)
                assert unique.ratio[stagings * period] == pytest.approx(float(zeta1))
                assert unique.ratio[stagings * period - 1] == pytest.approx(float(zeta2))


@pytest.mark.parametrize("rule", ["period", "full"])
def test_each_point_of_the_bounds_is_attained_and_none_exceeded(rule: StagingRule) -> None:
    length = 6
    every = list(trajectories(length))
    for ratio, period, actions in product((1 / 3, 0.5, 1.0), PERIODS, (2, 8)):
        dual = np.zeros((length + 1, length), dtype=np.int64)
        sarsa = np.zeros_like(dual)
        for classes in every:
            sizes = memory_sizes(classes, actions, ratio, period, rule=rule)
            states = max(classes) + 1
            dual[states] = np.maximum(dual[states], sizes.dual_entries)
            sarsa[states] = np.maximum(sarsa[states], sizes.sarsa_entries)
        for states in range(1, length + 1):  # at most so many
            bounds = size_bounds(actions, ratio, period, length, distinct_states=states, rule=rule)
            assert np.array_equal(dual[: states + 1].max(axis=0), bounds.dual_best)
            assert np.array_equal(sarsa[: states + 1].max(axis=0), bounds.sarsa_best)
        assert np.array_equal(dual.max(axis=0), bounds.dual_worst)
        assert np.array_equal(sarsa.max(axis=0), bounds.sarsa_worst)


def test_worst_case_holds_for_whole_rows_exactly_if_actions_cover_them() -> None:
    failed = 0
    for actions, ratio, period in product(ACTIONS, RATIOS, PERIODS):
        smaller = memory_sizes(range(20), actions, float(ratio), period).ratio >= 1
        covered = actions * period >= 3 * math.ceil(ratio * period)
        assert bool(smaller.all()) == covered
        failed += not covered
    assert failed > 0


def test_long_term_memory_need_not_hold_every_state_in_the_best_case() -> None:
    # 0, 1, 0, 1, …: both are known from t = 1 on. Staging the same one of them each time keeps
    # long-term memory at one row for ever, where the paper has m_L = M = 2.
    classes = (0, 1) * 4
    last = {m_l for t, _, m_l, _ in all_sizes(classes, Fraction(1, 2), 2) if t == len(classes) - 1}
    assert last == {1, 2}


def test_lemma_3_fails_first_right_after_the_first_staging(reached: Reached) -> None:
    for (ratio, period), sizes in reached.items():
        for actions in ACTIONS:
            larger = [
                (t, m_q) for t, m_s, m_l, m_q in sizes if actions * m_q < actions * m_s + 3 * m_l
            ]
            # Before the first staging both are the same table; then one state met again is enough.
            assert min(larger) == (period, 1), (ratio, period, actions)


def test_lemma_3_needs_the_remarks_condition_on_the_states_met_so_far() -> None:
    # All states of the whole run, the M of the paper's Remark, do not do: those met by then count.
    actions, ratio, period = 8, 0.5, 16
    starts = {8 / 11: [0] * 17, 136 / 152: [*range(17), *range(15)]}
    for zeta, start in starts.items():
        classes = [*start, *range(max(start) + 1, 60)]
        assert not failing(check_hyperparameters(actions, ratio, period, len(set(classes))))
        sizes = memory_sizes(classes, actions, ratio, period)
        assert sizes.q_rows[-1] == 60 > enough_states(actions, period)
        assert sizes.ratio[len(start) - 1] == zeta
        assert (sizes.ratio[sizes.q_rows >= enough_states(actions, period)] >= 1).all()


def test_keys_with_a_tolerance_break_the_bound_on_long_term_memory() -> None:
    """Whole numbers within 1 of a key share it, the first key wins: not an equivalence."""

    def find(key: int, keys: list[int]) -> int | None:
        return next((old for old in keys if abs(old - key) <= 1), None)

    # Windows of T = 2; of each pair the second state is staged (κ = 1/2).
    middles = (1, 11, 21, 31)
    pairs = [(m, 100) for m in middles]
    pairs += [(100, m - 1) for m in middles] + [(100, m + 1) for m in middles]
    table: list[int] = []
    long_term: list[int] = []
    for first, second in pairs:
        for state in (first, second):
            if find(state, table) is None:
                table.append(state)
        if find(second, long_term) is None:
            long_term.append(second)
    assert len(table) == 5 > enough_states(8, 2)
    assert len(long_term) == 9
    assert 8 * len(table) < 8 * 2 + 3 * len(long_term)
