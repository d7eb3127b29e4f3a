"""What memories of lanes work on: what is seen and expected of groups, how phases treat them.

First the tuples of arrays, then compiled steps. Each step is a short loop over all groups, links or
intersections that works on few arrays, in 32 bits and mostly without branches: such loops a
compiler turns into vector instructions, and a city's arrays outlast the processor's guesses.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from dmil.arrays import ByteArray, FloatArray, IntArray, Single
from dmil.compilation import kernel
from dmil.controllers.lanes.lane_groups import LaneGroups

RowArray = npt.NDArray[np.uint16]
Whole = int | np.integer[Any]
Real = float | np.floating[Any]

RED, KEPT, SWITCHED, PARTLY = range(4)
"""Columns of the table: how a lane is treated in a decision interval."""

ARRIVALS = 4
STATE_BINS = 12 * ARRIVALS
"""Bins of vehicles queued, {0…8, 9–10, 11–14, 15+}, and expected, {0, 1, 2, 3+}."""

ZERO, HALF, ONE = np.float32(0.0), np.float32(0.5), np.float32(1.0)
"""A plain number would lift what it meets to 64 bits."""
SMALLEST_RATE_VEH = np.float32(0.05)
"""Added to the rate of every lane group when inflow is divided: no group gets none for ever."""


class ShortTerm(NamedTuple):
    """What every intersection remembers of the last decision and of arrivals, per lane group.

    Attributes
    ----------
    rate_veh: (groups,) float32
        Arrivals per decision interval and lane, a moving average.
    rated: (groups,) uint16
        How many intervals it comes from.
    queue_veh, expected_veh: (groups,) float32
        Per lane, at the last decision.
    row: (groups,) uint16
        Row of the table, then.
    treatment: (groups,) uint8
        How it was treated since.
    outside_veh: (entries,) float32
        Per lane, those who wait unseen behind a full entry.
    silent, longest: (groups,) uint8, or (0,)
        At how many decisions running nobody has been seen, `DEAD` where the detector is taken for
        dead; most so far, 0 if never anybody. Empty if none is filled in for: see `lane_arrivals`.
    red_rate: (groups,) uint16, or (0,)
        Arrivals per decision interval of red and lane, a moving average, in thousandths.
    """

    rate_veh: Single
    rated: RowArray
    queue_veh: Single
    expected_veh: Single
    row: RowArray
    treatment: ByteArray
    outside_veh: Single
    silent: ByteArray
    longest: ByteArray
    red_rate: RowArray


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
    queue_veh, expected_veh, waiting_veh, moving_veh, joined_veh: float32
        Seen and expected now, moving those who approach; who joined in the interval that ended, as
        far as one can tell.
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
    moving_veh: Single
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


@kernel
def note_shown(groups: LaneGroups, inputs: Inputs, scratch: LaneScratch) -> None:
    """Note how the phases that are shown treat all groups."""
    shown = scratch.shown
    for g in range(shown.shape[0]):
        shown[g] = RED
    for i in range(inputs.shown.shape[0]):
        if inputs.shown[i] >= 0:
            phase = groups.phase_offset[i] + inputs.shown[i]
            for place in range(groups.served_offset[phase], groups.served_offset[phase + 1]):
                shown[groups.served[place]] = PARTLY if groups.partly[place] else KEPT


@kernel
def forget_rejected(groups: LaneGroups, inputs: Inputs, short: ShortTerm) -> None:
    """Take lanes as partly served that were not treated as asked for: who joined is not known."""
    for i in range(inputs.shown.shape[0]):
        if inputs.shown[i] != inputs.asked[i]:
            for g in range(groups.group_offset[i], groups.group_offset[i + 1]):
                short.treatment[g] = PARTLY


@kernel
def aggregate(
    groups: LaneGroups, use_approaching: bool, inputs: Inputs, scratch: LaneScratch
) -> None:
    """Add up what is seen of every group, per lane."""
    for g in range(groups.lanes.shape[0]):
        queue, approaching, waiting = 0, 0, 0.0
        for place in range(groups.movement_offset[g], groups.movement_offset[g + 1]):
            movement = groups.movements[place]
            queue += inputs.queue_veh[movement]
            approaching += inputs.approaching_veh[movement]
            waiting += inputs.waiting_veh[movement]
        per_lane = ONE / groups.lanes[g]
        scratch.queue_veh[g] = np.float32(queue) * per_lane
        scratch.moving_veh[g] = np.float32(approaching * use_approaching) * per_lane
        scratch.expected_veh[g] = scratch.moving_veh[g]
        scratch.waiting_veh[g] = np.float32(waiting) * per_lane


@kernel
def state_bin(queue_veh: Real, expected_veh: Real) -> Whole:
    """Return the bin of a lane's state: see `STATE_BINS`."""
    queue = np.int32(queue_veh + HALF)
    queue = min(queue, np.int32(8)) + (queue > 8) + (queue > 10) + (queue > 14)
    return queue * ARRIVALS + min(np.int32(expected_veh + HALF), np.int32(ARRIVALS - 1))


@kernel
def expect_by_rate(
    groups: LaneGroups, expected: float, short: ShortTerm, scratch: LaneScratch
) -> None:
    """Expect unseen vehicles where no intersection announces them; add up rates by link."""
    weight, link_rate_veh = np.float32(expected), scratch.link_rate_veh
    for link in range(link_rate_veh.shape[0]):
        link_rate_veh[link] = ZERO
    for g in range(groups.lanes.shape[0]):
        rate_veh = groups.lanes[g] * (short.rate_veh[g] + SMALLEST_RATE_VEH)
        link_rate_veh[groups.link[g]] += rate_veh
    for g in range(groups.lanes.shape[0]):
        scratch.expected_veh[g] += weight * groups.unannounced[g] * short.rate_veh[g]


@kernel
def announce(
    groups: LaneGroups,
    use_approaching: bool,
    inputs: Inputs,
    scratch: LaneScratch,
    phases: IntArray,
) -> None:
    """Note on every link how much of its end will be green and who will come in time."""
    green, inflow_veh = scratch.green, scratch.inflow_veh
    for link in range(green.shape[0]):
        green[link] = ZERO
        inflow_veh[link] = ZERO
    for i in range(phases.shape[0]):
        phase = groups.phase_offset[i] + phases[i]
        for place in range(groups.served_offset[phase], groups.served_offset[phase + 1]):
            g = groups.served[place]
            part = HALF if groups.partly[place] else ONE
            green[groups.link[g]] += part * groups.link_share[g]
        for place in range(groups.flow_offset[phase], groups.flow_offset[phase + 1]):
            movement = groups.flows[place]
            ready = inputs.queue_veh[movement] + use_approaching * inputs.approaching_veh[movement]
            inflow_veh[groups.ahead[movement]] += min(
                np.float32(ready), groups.in_time_veh[movement]
            )


@kernel
def expect_announced(
    groups: LaneGroups, expected: float, short: ShortTerm, scratch: LaneScratch
) -> None:
    """Give every group its share of the inflow of its link, as arrivals have been so far."""
    weight, per_rate = np.float32(expected), scratch.per_rate
    for link in range(per_rate.shape[0]):
        # No rate is smaller; links without groups have none.
        rate_veh = max(scratch.link_rate_veh[link], SMALLEST_RATE_VEH)
        per_rate[link] = weight * scratch.inflow_veh[link] / rate_veh
    for g in range(groups.lanes.shape[0]):
        rate_veh = short.rate_veh[g] + SMALLEST_RATE_VEH
        scratch.expected_veh[g] += per_rate[groups.link[g]] * rate_veh


@kernel
def find_waves(groups: LaneGroups, weight: float, scratch: LaneScratch) -> None:
    """Note how much more green is worth, because those who leave find green when they get there."""
    for g in range(groups.lanes.shape[0]):
        first, last = groups.movement_offset[g], groups.movement_offset[g + 1]
        ahead = ZERO
        for place in range(first, last):
            link = groups.movement_ahead[place]
            ahead += scratch.green[link] * groups.waves[link]
        waits = scratch.queue_veh[g] + scratch.expected_veh[g] > ZERO
        wave = np.float32(weight) * ahead / np.float32(last - first)
        scratch.wave[g] = wave if waits else ZERO


@kernel
def note_treatment(
    groups: LaneGroups, after_switch: float, inputs: Inputs, scratch: LaneScratch, phases: IntArray
) -> None:
    """Note how the phases that were chosen treat all groups."""
    treatment = scratch.treatment
    for g in range(treatment.shape[0]):
        treatment[g] = RED
    for i in range(phases.shape[0]):
        phase = groups.phase_offset[i] + phases[i]
        stops = groups.all_stop[i] and phases[i] != inputs.shown[i]
        for place in range(groups.served_offset[phase], groups.served_offset[phase + 1]):
            g = groups.served[place]
            shown = RED if stops else scratch.shown[g]
            wholly = served_wholly(shown, after_switch)
            treatment[g] = PARTLY if groups.partly[place] else wholly


@kernel
def served_wholly(shown: int, after_switch: float) -> int:
    """Return how a group is treated by a phase that serves it wholly."""
    return KEPT if shown == KEPT or after_switch == 1.0 else SWITCHED


@kernel
def green_part(treatment: int, after_switch: Real) -> Real:
    """Return the part of an interval of green that a treatment is worth by the prior."""
    part = after_switch if treatment == SWITCHED else ZERO
    part = HALF * after_switch if treatment == PARTLY else part
    return ONE if treatment == KEPT else part
