"""Check a choice of hyperparameters against the conditions of the analysis."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from dmil.theory.growth import enough_states, hyperparameters, staged_rows, whole_number


@dataclass(frozen=True, slots=True)
class Condition:
    """One condition and whether it holds."""

    name: str
    statement: str
    """The inequality, in the paper's symbols."""
    holds: bool | None
    """None if it cannot be said, because the number of distinct states was not given."""
    found: float | None
    """Left-hand side of the statement."""
    needed: float | None
    """Right-hand side; infinite if no value would do, None if it is not defined."""
    source: str
    note: str
    decisive: bool = True
    """Whether ζ ≥ 1 depends on it; the others are shown because the paper prints them."""


def check_hyperparameters(
    actions: int, staged_ratio: float, stage_period: int, distinct_states: int | None = None
) -> list[Condition]:
    """Say which conditions for ζ ≥ 1 hyperparameters meet (paper, Remark in §V, corrected).

    Parameters
    ----------
    actions
        |A|, number of actions, at least 1.
    staged_ratio
        κ, share of short-term rows that is staged, in (0, 1].
    stage_period
        T, decisions between two stagings, at least 1.
    distinct_states
        M, number of classes met, at least 1; None if it is not known.

    Returns
    -------
    list of Condition
        The decisive ones and, beside each, what the paper prints instead.

    Raises
    ------
    InputError
        A parameter is out of range.
    """
    actions, staged_ratio, stage_period = hyperparameters(actions, staged_ratio, stage_period)
    if distinct_states is not None:
        distinct_states = whole_number("distinct_states", distinct_states, at_least=1)
    return [
        *_worst_case_conditions(actions, staged_ratio, stage_period),
        *_order_conditions(actions, staged_ratio, stage_period),
        *_best_case_conditions(actions, stage_period, distinct_states),
    ]


def failing(conditions: Iterable[Condition]) -> list[Condition]:
    """List the decisive conditions that do not hold (ours)."""
    return [
        condition for condition in conditions if condition.decisive and condition.holds is False
    ]


def _worst_case_conditions(actions: int, staged_ratio: float, stage_period: int) -> list[Condition]:
    whole = 3 * staged_rows(stage_period, staged_ratio)
    return [
        Condition(
            name="worst case",
            statement="|A| ≥ 3κ",
            holds=actions >= 3 * staged_ratio,
            found=actions,
            needed=3 * staged_ratio,
            source="paper, Lemma 1",
            note="ζ ≥ 1 at every decision while all states are new",
        ),
        Condition(
            name="worst case, whole rows",
            statement="|A| ≥ 3⌈κT⌉/T",
            # Compared as whole numbers: the quotient may round.
            holds=actions * stage_period >= whole,
            found=actions,
            needed=whole / stage_period,
            source="ours",
            note="staging takes whole rows, so κ is in effect ⌈κT⌉/T; met by any |A| ≥ 3",
        ),
        Condition(
            name="staging ratio",
            statement="κ ≤ |A|/3",
            holds=staged_ratio <= actions / 3,
            found=staged_ratio,
            needed=actions / 3,
            source="paper, Remark in §V",
            note="the worst-case condition again; it binds only for |A| ≤ 2, as κ ≤ 1",
            decisive=False,
        ),
    ]


def _order_conditions(actions: int, staged_ratio: float, stage_period: int) -> list[Condition]:
    printed = (
        3 * staged_ratio * (stage_period + 2) / (stage_period - 2) if stage_period > 2 else None
    )
    return [
        Condition(
            name="order of the ratios",
            statement="ζ1 ≥ ζ2 ⟺ |A| ≥ 3κ",
            holds=actions >= 3 * staged_ratio,
            found=actions,
            needed=3 * staged_ratio,
            source="paper, proof of Lemma 1, corrected",
            note="for every T ≥ 1",
            decisive=False,
        ),
        Condition(
            name="order of the ratios as printed",
            statement="|A| ≥ 3κ(T+2)/(T−2)",
            holds=printed is not None and actions >= printed,
            found=actions,
            needed=printed,
            source="paper, proof of Lemma 1",
            note="more than is needed; nothing depends on it",
            decisive=False,
        ),
        Condition(
            name="period as printed",
            statement="T > 2",
            holds=stage_period > 2,
            found=stage_period,
            needed=2,
            source="paper, proof of Lemma 1 and Remark in §V",
            note="follows from the line above; T = 1 and T = 2 do as well",
            decisive=False,
        ),
    ]


def _best_case_conditions(
    actions: int, stage_period: int, distinct_states: int | None
) -> list[Condition]:
    before = enough_states(actions, stage_period)

    def enough(needed: float) -> bool | None:
        if actions <= 3:
            return False
        return None if distinct_states is None else distinct_states >= needed

    return [
        Condition(
            name="actions",
            statement="|A| > 3",
            holds=actions > 3,
            found=actions,
            needed=3,
            source="paper, proof of Lemma 2 and Remark in §V",
            note="a long-term row has 3 entries: with |A| ≤ 3 it saves nothing",
        ),
        Condition(
            name="best case after staging",
            statement="M ≥ |A|/(|A|−3)",
            holds=enough(enough_states(actions, 1)),
            found=distinct_states,
            needed=enough_states(actions, 1),
            source="paper, proof of Lemma 2",
            note="ζ1 ≥ 1 once every state met is in long-term memory",
        ),
        Condition(
            name="best case before staging",
            statement="M ≥ T|A|/(|A|−3)",
            holds=enough(before),
            found=distinct_states,
            needed=before,
            source="paper, proof of Lemma 2",
            note="ζ2 ≥ 1 once every state met is in long-term memory",
        ),
        Condition(
            name="any trajectory",
            statement="m_Q[t] ≥ T|A|/(|A|−3)",
            holds=enough(before),
            found=distinct_states,
            needed=before,
            source="paper, Remark in §V, with m_Q[t] for M",
            note="enough for ζ ≥ 1 at decision t (Lemma 3); the states met by then count",
        ),
    ]
