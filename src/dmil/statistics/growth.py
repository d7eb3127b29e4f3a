"""Whether a queue grows: the test for stability of a run, and of many."""

from __future__ import annotations

from typing import Literal

import numpy as np
import numpy.typing as npt

Stability = Literal["stable", "grows", "open"]


def queue_growth(waiting_veh: npt.NDArray[np.integer], arrivals_veh_per_s: float) -> float:
    """Return which share of the arriving vehicles a queue grows by (ours).

    It is the slope of the vehicles waiting over the second half of a run, by least squares, over
    the rate at which vehicles come. Where demand is steady and below capacity it is 0 in the mean;
    above capacity it is about 1 - capacity / demand, whatever the size of the network. The first
    half is left out, because an empty network fills. Vehicles that drive are not counted: where
    vehicles pile up they wait, inside or outside, and who drives only adds chance.

    Parameters
    ----------
    waiting_veh: (seconds,)
        Vehicles queued in the network or waiting to enter it, after each second.
    arrivals_veh_per_s
        Vehicles whose time to depart comes, per second.

    Returns
    -------
    Share of the arrivals, dimensionless; 0 if nobody comes.
    """
    half = np.asarray(waiting_veh[len(waiting_veh) // 2 :], np.float64)
    if arrivals_veh_per_s <= 0 or len(half) < 2:
        return 0.0
    time_s = np.arange(len(half)) - (len(half) - 1) / 2
    slope_veh_per_s = float(time_s @ (half - half.mean()) / (time_s @ time_s))
    return slope_veh_per_s / arrivals_veh_per_s


def stability(low: float, high: float, tolerance: float) -> Stability:
    """Judge the growth of many runs by its interval over seeds (ours).

    Parameters
    ----------
    low, high
        Ends of the interval of the mean of `queue_growth`.
    tolerance
        Growth that still counts as none.

    Returns
    -------
    "stable" if the whole interval is at most the tolerance, "grows" if all of it is above, else
    "open".
    """
    if high <= tolerance:
        return "stable"
    return "grows" if low > tolerance else "open"
