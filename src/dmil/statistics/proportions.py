"""How sure a share is that was seen in a few runs."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from dmil.statistics.bootstrap import DEFAULT_LEVEL, Estimate


def share_interval(
    successes: npt.ArrayLike, runs: npt.ArrayLike, *, level: float = DEFAULT_LEVEL
) -> Estimate:
    """Return shares of runs with their intervals by Wilson (1927).

    A bootstrap of runs that are all alike would give an interval without width: none of 20 runs
    does not show that none of 1,000 does.

    Parameters
    ----------
    successes, runs: (columns,) whole numbers
    level
        Coverage of the interval.

    Raises
    ------
    ValueError
        If there are more successes than runs, or fewer than none.
    """
    from scipy.special import ndtri  # as long to load as many a command takes

    k, n = np.broadcast_arrays(np.asarray(successes, np.float64), np.asarray(runs, np.float64))
    if ((k < 0) | (k > n)).any():
        raise ValueError(f"{k} successes of {n} runs")
    z = float(ndtri((1 + level) / 2))
    with np.errstate(invalid="ignore", divide="ignore"):
        share = k / n
        middle = (share + z**2 / (2 * n)) / (1 + z**2 / n)
        half = z / (1 + z**2 / n) * np.sqrt(share * (1 - share) / n + z**2 / (4 * n**2))
    low = np.where(k == 0, 0.0, middle - half)
    high = np.where(k == n, 1.0, middle + half)
    none = n == 0
    return Estimate(
        share, np.where(none, np.nan, low), np.where(none, np.nan, high), n.astype(np.int64)
    )
