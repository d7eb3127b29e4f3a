"""What memories of lanes work on: treatments, bins, short-term memory, observation, scratch."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

IntArray = npt.NDArray[np.int32]
ByteArray = npt.NDArray[np.uint8]
RowArray = npt.NDArray[np.uint16]
FloatArray = npt.NDArray[np.float64]
Single = npt.NDArray[np.float32]
Whole = int | np.integer[Any]
Real = float | np.floating[Any]

RED, KEPT, SWITCHED, PARTLY = range(4)
"""Columns of the table: how a lane is treated in a decision interval."""

ARRIVALS = 4
STATE_BINS = 12 * ARRIVALS
"""Bins of vehicles queued, {0…8, 9–10, 11–14, 15+}, and expected, {0, 1, 2, 3+}."""


class ShortTerm(NamedTuple):
    """What every intersection remembers of the last decision and of arrivals, per lane group.

    Attributes
    ----------
    rate_veh: (groups,) float32
        Arrivals per decision interval and lane, a moving average.
    rated: (groups,) float32
        How many intervals it comes from.
    queue_veh, expected_veh: (groups,) float32
        Per lane, at the last decision.
    row: (groups,) uint16
        Row of the table, then.
    treatment: (groups,) uint8
        How it was treated since.
    """

    rate_veh: Single
    rated: Single
    queue_veh: Single
    expected_veh: Single
    row: RowArray
    treatment: ByteArray


class Inputs(NamedTuple):
    """The observation, and what was asked for last.

    Attributes
    ----------
    queue_veh, approaching_veh: (movements,) int32
    waiting_veh: (movements,) float64
    owed_veh: (movements,) float64, or (0,)
        Vehicles that green counts more, because shared lanes got stuck; empty where none can.
    shown, asked: (intersections,) int32
        Phase shown now; phase asked for at the last decision.
    first: bool
        Whether there was none.
    """

    queue_veh: IntArray
    approaching_veh: IntArray
    waiting_veh: FloatArray
    owed_veh: FloatArray
    shown: IntArray
    asked: IntArray
    first: bool


class LaneScratch(NamedTuple):
    """Working space: (groups,) but where it says otherwise; vehicles are per lane.

    Attributes
    ----------
    queue_veh, expected_veh, waiting_veh, joined_veh: float32
        Seen and expected now; who joined in the interval that ended, as far as one can tell.
    tells: uint8
        Whether one can.
    row: uint16
    shown, treatment: uint8
        Treatment by the phase that is shown now: red, kept or partly; by the one that is chosen.
    wave: float32
        What green is worth besides, for green ahead.
    link_rate_veh, inflow_veh, green: (links + 1,) float32
        What was announced of a link: arrivals so far, vehicles that come, how much of it is green.
    per_rate: (links + 1,) float32
        Of vehicles that were announced, those that are expected for each of a group's own rate.
    lookups: (2,) int64
        Entries asked for that had been learned, and that had not.
    """

    queue_veh: Single
    expected_veh: Single
    waiting_veh: Single
    joined_veh: Single
    tells: ByteArray
    row: RowArray
    shown: ByteArray
    treatment: ByteArray
    wave: Single
    link_rate_veh: Single
    inflow_veh: Single
    green: Single
    per_rate: Single
    lookups: npt.NDArray[np.int64]
