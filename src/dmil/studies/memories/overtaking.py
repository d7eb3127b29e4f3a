"""When a learner has become better than a rule that knows everything from the start."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

WINDOW_S = 900
"""Queues are compared over a quarter of an hour: shorter, and chance alone turns the sign."""


def decisions_until_better(
    queued_veh: Sequence[npt.NDArray[np.integer]],
    reference_veh: Sequence[npt.NDArray[np.integer]],
    decision_interval_s: int,
    *,
    window_s: int = WINDOW_S,
) -> int | None:
    """Return the decisions after which a queue stays below another on the same vehicles (ours).

    All runs of a learner's life follow each other: its training, then its test. From the decision
    returned on, the mean queue over every window is below the reference's over that window.

    Parameters
    ----------
    queued_veh
        For every run, (seconds,) vehicles waiting, in order.
    reference_veh
        The same of the reference, which met the same vehicles.
    decision_interval_s
        Time between two decisions.
    window_s
        Length of the windows; a life shorter than that is one window.

    Returns
    -------
    Decisions, counted from the first of all; None if the last window is not better.
    """
    difference = np.concatenate(
        [
            np.subtract(own, other, dtype=np.int64)
            for own, other in zip(queued_veh, reference_veh, strict=True)
        ]
    )
    window = min(window_s, len(difference))
    total = np.concatenate([[0], np.cumsum(difference)])
    worse = np.flatnonzero(total[window:] - total[:-window] >= 0)
    if not worse.size:
        return 0
    begin = int(worse[-1]) + 1
    if begin > len(difference) - window:
        return None
    return -(-begin // decision_interval_s)
