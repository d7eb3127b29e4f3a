"""What several studies check before anything is run."""

from __future__ import annotations

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
