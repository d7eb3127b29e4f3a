"""Wilcoxon's signed-rank tests of several controllers against one, corrected for their number."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dmil.statistics.bootstrap import Tasks, all_tasks
from dmil.statistics.summaries import Values


@dataclass(frozen=True, slots=True)
class SignedRankTests:
    """Tests of every column against its reference.

    Attributes
    ----------
    p
        (columns,) two-sided p-values; 1 where no pair differs, NaN where there is no pair.
    p_holm
        (columns,) the same, corrected for the number of tests (Holm, 1979).
    pairs
        (columns,) pairs of runs.
    differing
        (columns,) pairs whose members differ: what the test rests on. With k of them no p is below
        2 / 2^k, so fewer than six cannot show anything at 5 %.
    """

    p: Values
    p_holm: Values
    pairs: NDArray[np.int64]
    differing: NDArray[np.int64]


def signed_rank_tests(values: Tasks, reference: Tasks) -> SignedRankTests:
    """Test whether each column differs from its reference on the same seeds (Wilcoxon, 1945).

    Pairs that are equal are left out. The distribution is exact for up to 50 pairs without ties,
    otherwise as `scipy.stats.wilcoxon` chooses.

    Parameters
    ----------
    values, reference
        (seeds, columns), rows of the same seeds, or one such array for each task (differences then
        are ranked over all tasks, so give them a common scale); the reference may have one column
        for all. NaN marks a missing run. A column that is its own reference is no test: leave it
        out, or it counts for the correction.
    """
    from scipy.stats import wilcoxon  # importing it takes a second, and few commands test

    differences = np.concatenate(
        [
            ours - theirs
            for ours, theirs in zip(all_tasks(values), all_tasks(reference), strict=True)
        ]
    )
    present = ~np.isnan(differences)
    differing = present & (differences != 0.0)
    p = np.full(differences.shape[1], np.nan)
    for column in np.flatnonzero(present.any(axis=0)):
        kept = differences[differing[:, column], column]
        p[column] = wilcoxon(kept).pvalue if len(kept) else 1.0
    return SignedRankTests(p, holm(p), present.sum(axis=0), differing.sum(axis=0))


def holm(p: Values) -> Values:
    """Return p-values corrected for their number (Holm, 1979): they keep the family-wise error.

    Parameters
    ----------
    p
        (tests,) p-values; NaN marks a test that could not be made and does not count.
    """
    corrected = np.full_like(p, np.nan)
    order = np.argsort(p)[: int((~np.isnan(p)).sum())]
    factors = np.arange(len(order), 0, -1)
    corrected[order] = np.minimum(np.maximum.accumulate(p[order] * factors), 1.0)
    return corrected
