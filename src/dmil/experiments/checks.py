"""What several studies check before anything is run."""

from __future__ import annotations

from collections.abc import Collection

from pydantic import BaseModel

from dmil.errors import InputError

SET_BY_THE_STUDY = {"embedding", "communication", "epsilon_decay", "learning", "shared"}
"""Fields of the agents' settings that differ between a study's runs, or that it depends on."""


def check_horizon(horizon_s: int, decision_interval_s: int) -> None:
    """Check that a run has at least two decisions, so that something can be learned.

    Raises
    ------
    InputError
        If it has not.
    """
    if horizon_s < 2 * decision_interval_s:
        raise InputError(
            f"a run of {horizon_s} s",
            where="horizon_s",
            expected=f"at least two decision intervals of {decision_interval_s} s",
        )


def distinct(names: tuple[str, ...]) -> tuple[str, ...]:
    """Return names that differ from each other, for a validator of settings.

    Raises
    ------
    ValueError
        Two are the same.
    """
    if len(set(names)) < len(names):
        raise ValueError("names must differ from each other")
    return names


def check_left_open(
    fixed: Collection[str] = frozenset(SET_BY_THE_STUDY), **agents: BaseModel
) -> None:
    """Check that settings of agents, named as in the study's, leave alone what it sets itself.

    Raises
    ------
    ValueError
        One of the fields has not its usual value.
    """
    for name, chosen in agents.items():
        usual = type(chosen)()
        for field in set(fixed) & set(type(chosen).model_fields):
            if getattr(chosen, field) != getattr(usual, field):
                raise ValueError(f"{name}.{field} is set by the study itself: leave it out")
