"""What an interval shows of a claim."""

from __future__ import annotations

from typing import Literal

import numpy as np

#: With fewer seeds a 95 % interval covers the truth in far fewer than 92 % of studies (three seeds:
#: 75 %, two: 50 %), so no verdict is given.
FEWEST_SEEDS = 5

Relation = Literal["below", "above", "within", "not below", "not above"]
Outcome = Literal["shown", "opposite", "open"]


def judge(relation: Relation, threshold: float, low: float, high: float) -> Outcome:
    """Say whether an interval shows a relation to a threshold, its opposite, or leaves it open.

    "below": the whole interval lies below the threshold; "above": above it; "within": inside
    ±threshold; "not below": its upper end is not below the threshold; "not above": its lower end is
    not above it. Without an interval (one seed) the question is open.
    """
    if np.isnan(low) or np.isnan(high):
        return "open"
    if relation == "within":
        if -threshold <= low and high <= threshold:
            return "shown"
        return "opposite" if low > threshold or high < -threshold else "open"
    if relation == "not below":
        return "opposite" if high < threshold else "shown"
    if relation == "not above":
        return "opposite" if low > threshold else "shown"
    below, above = high < threshold, low > threshold
    if relation == "above":
        below, above = above, below
    return "shown" if below else "opposite" if above else "open"
