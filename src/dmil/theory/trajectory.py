"""Sizes of both memories decision by decision: of one trajectory, and at most of any.

The model, with t = 0, 1, 2, … counting decisions:

- Decision t meets one class. It enters short-term memory (STM) unless it is there, whether or
  not long-term memory (LTM) has it: Algorithm 1 looks into STM only.
- Rule "period": at t = T, 2T, … STM is staged and emptied *before* the class of decision t
  enters, so m_s[t] = 1 + m_s[t−1](1 − I[t]) as long as all classes are new. With a class met
  again since the last staging, m_s[t] = m_s[t−1].
- Rule "full": once STM has T rows it is staged and emptied *after* the class has entered.
- Staging takes ⌈κ·m_s⌉ rows of STM; a row whose class LTM has already adds nothing.
- The Q-table of SARSA keeps a row for every class ever met.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dmil.errors import InputError
from dmil.theory.growth import (
    StagingRule,
    check_name,
    hyperparameters,
    staged_rows,
    whole_number,
    whole_numbers,
)

Counts = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class MemorySizes:
    """Sizes at the end of each decision; every array is (decisions,)."""

    short_term_rows: Counts
    """m_s, rows of short-term memory."""
    long_term_rows: Counts
    """m_L, rows of long-term memory."""
    q_rows: Counts
    """m_Q, rows of SARSA's table."""
    dual_entries: Counts
    """3·m_L + |A|·m_s."""
    sarsa_entries: Counts
    """|A|·m_Q."""

    @property
    def ratio(self) -> NDArray[np.float64]:
        """ζ, SARSA's entries over those of dual memory; below 1 dual memory is the larger."""
        return np.asarray(self.sarsa_entries / self.dual_entries, dtype=np.float64)


@dataclass(frozen=True, slots=True)
class SizeBounds:
    """Most entries each memory can have at each decision; every array is (decisions,) int64."""

    decision: Counts
    """t, from 0."""
    dual_worst: Counts
    """Dual memory, over all trajectories."""
    sarsa_worst: Counts
    """SARSA's table, over all trajectories."""
    dual_best: Counts
    """Dual memory, over trajectories that meet at most M classes."""
    sarsa_best: Counts
    """SARSA's table, over trajectories that meet at most M classes."""


def memory_sizes(
    classes: ArrayLike,
    actions: int,
    staged_ratio: float,
    stage_period: int,
    *,
    rule: StagingRule = "period",
    prefer: Literal["new", "known"] = "new",
) -> MemorySizes:
    """Follow one trajectory and count the rows of both memories (paper, §V, corrected).

    Parameters
    ----------
    classes
        Class met at each decision, (decisions,) whole numbers of at least 0, repeats allowed.
    actions
        |A|, number of actions, at least 1.
    staged_ratio
        κ, share of short-term rows that is staged, in (0, 1].
    stage_period
        T: decisions between two stagings, or the rows at which short-term memory is full.
    rule
        "period" (the paper's analysis) or "full" (its Algorithm 1).
    prefer
        Which rows are staged, since a trajectory has no values to rank them by: those long-term
        memory lacks ("new", memory grows fast) or has ("known", it grows slowly). Ties go to
        the class that entered short-term memory first.

    Returns
    -------
    MemorySizes
        Sizes at the end of each decision.

    Raises
    ------
    InputError
        A parameter is out of range, or there is no decision.

    Notes
    -----
    Differs from the paper: as printed, m_s is 0 right after a staging, which contradicts the
    ratios derived from it; and revisits are left out. A class is the same class wherever it is
    looked up: so for exact states and cells, not for keys with a tolerance (docs/theory.md).
    """
    actions, staged_ratio, stage_period = hyperparameters(actions, staged_ratio, stage_period)
    check_name("staging rule", rule, get_args(StagingRule), where="rule")
    check_name("preference", prefer, ("new", "known"), where="prefer")
    met = whole_numbers("classes", classes, at_least=0)
    if met.ndim != 1 or not met.size:
        raise InputError(
            f"found shape {met.shape}", where="classes", expected="one class for each decision"
        )

    short_term: dict[int, None] = {}  # ordered by first entry
    long_term: set[int] = set()
    table: set[int] = set()
    rows = np.empty((3, met.size), dtype=np.int64)

    def stage() -> None:
        ranked = sorted(short_term, key=lambda key: (key in long_term) == (prefer == "new"))
        long_term.update(ranked[: staged_rows(len(ranked), staged_ratio)])
        short_term.clear()

    for t, key in enumerate(np.asarray(classes).tolist()):
        if rule == "period" and t and t % stage_period == 0:
            stage()
        short_term[key] = None
        table.add(key)
        if rule == "full" and len(short_term) == stage_period:
            stage()
        rows[:, t] = len(short_term), len(long_term), len(table)

    m_s, m_l, m_q = rows
    return MemorySizes(m_s, m_l, m_q, 3 * m_l + actions * m_s, actions * m_q)


def size_bounds(
    actions: int,
    staged_ratio: float,
    stage_period: int,
    decisions: int,
    *,
    distinct_states: int = 1,
    rule: StagingRule = "period",
    imported: int = 0,
) -> SizeBounds:
    """Most entries either memory can have at each decision (paper, Lemmas 1 and 2, corrected).

    Parameters
    ----------
    actions
        |A|, number of actions, at least 1.
    staged_ratio
        κ, share of short-term rows that is staged, in (0, 1].
    stage_period
        T: decisions between two stagings, or the rows at which short-term memory is full.
    decisions
        Length of the curves, at least 1.
    distinct_states
        M of the best case: classes a run meets, beyond those imported.
    rule
        "period" (the paper's analysis) or "full" (its Algorithm 1).
    imported
        Rows of a trained table at the start: SARSA takes all of them, long-term memory ⌈κ·rows⌉.

    Returns
    -------
    SizeBounds
        Curves over the decisions, for one agent that shares memory with no other.

    Raises
    ------
    InputError
        A parameter is out of range.

    Notes
    -----
    The unique trajectory attains the worst case of rule "period". The tests find every point of
    every short curve attained, by different trajectories. Bounds on the sizes do not bound their
    ratio: a trajectory between these curves may have ζ < 1, so the paper's
    Lemma 3 needs a condition on the states met, which its Remark in §V gives (docs/theory.md).
    """
    actions, staged_ratio, stage_period = hyperparameters(actions, staged_ratio, stage_period)
    check_name("staging rule", rule, get_args(StagingRule), where="rule")
    decisions = whole_number("decisions", decisions, at_least=1)
    distinct_states = whole_number("distinct_states", distinct_states, at_least=1)
    imported = whole_number("imported", imported, at_least=0)

    t = np.arange(decisions, dtype=np.int64)
    start = staged_rows(imported, staged_ratio)
    curves = []
    for states in (decisions, distinct_states):
        classes = imported + states
        if rule == "period":
            dual = _entries_by_period(t, actions, staged_ratio, stage_period, classes, start)
        else:
            dual = _entries_by_capacity(t, actions, staged_ratio, stage_period, classes, start)
        curves += [dual, actions * (imported + np.minimum(t + 1, states))]
    return SizeBounds(t, *curves)


def _entries_by_period(
    t: Counts, actions: int, staged_ratio: float, stage_period: int, classes: int, start: int
) -> Counts:
    """Most entries of dual memory if it is staged every `stage_period` decisions."""
    staged = staged_rows(min(stage_period, classes), staged_ratio)
    short_term = np.minimum(t % stage_period + 1, classes)
    long_term = np.minimum(start + t // stage_period * staged, classes)
    return np.asarray(actions * short_term + 3 * long_term, dtype=np.int64)


def _entries_by_capacity(
    t: Counts, actions: int, staged_ratio: float, stage_period: int, classes: int, start: int
) -> Counts:
    """Most entries of dual memory if it is staged when it has `stage_period` rows."""
    if classes < stage_period:  # never full
        return np.asarray(actions * np.minimum(t + 1, classes) + 3 * start, dtype=np.int64)
    staged = staged_rows(stage_period, staged_ratio)
    most = np.zeros_like(t)
    latest = (t + 1) // stage_period
    # Each staging uses up stage_period decisions. One less than possible leaves enough of them
    # to fill short-term memory up to the last row; fewer stagings only lose.
    for stagings in (latest, np.maximum(latest - 1, 0)):
        short_term = np.minimum(t + 1 - stagings * stage_period, stage_period - 1)
        long_term = np.minimum(start + stagings * staged, classes)
        most = np.maximum(most, actions * short_term + 3 * long_term)
    return most


def counterexample(stage_period: int) -> Counts:
    """Build a trajectory on which dual memory is larger than SARSA's table (ours).

    T + 1 distinct classes, then T − 1 revisits of the first ones. At its last decision
    ζ = |A|(T+1) / (|A|T + 3⌈κT⌉), below 1 if |A| < 3⌈κT⌉; for |A| = 8, κ = ½, T = 16 it is
    136/152. The paper's Lemma 3 does not hold at that decision, however many states the trajectory
    goes on to meet: those met by then count (docs/theory.md).

    Parameters
    ----------
    stage_period
        T, decisions between two stagings, at least 1.

    Returns
    -------
    Counts
        Class met at each decision, (2T,).

    Raises
    ------
    InputError
        The parameter is out of range.
    """
    stage_period = whole_number("stage_period", stage_period, at_least=1)
    return np.concatenate([np.arange(stage_period + 1), np.arange(stage_period - 1)])
