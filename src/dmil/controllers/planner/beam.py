"""Beam search over the phases of one intersection whose arrivals are all known.

Over one decision interval every movement goes its own way: what it comes to at red, at green and at
green anew is tried once per state, and what a phase leads to is the sum of that.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dmil.arrays import FloatArray, IntArray, LongArray
from dmil.compilation import allocating_kernel, kernel
from dmil.controllers.planner.crossing import (
    KEPT,
    RED,
    KnownIntersection,
    States,
    is_allowed,
    meets_with,
    run_movement,
)
from dmil.simulation.timing import NEVER_S


class Trials(NamedTuple):
    """What every movement of every state comes to, for red, green kept and green anew.

    Attributes
    ----------
    queue_veh: (states, 3, lanes) int32
    ready_s: (states, 3, lanes) float64
        See `States`.
    wait_veh_s: (states, 3, movements) int64
        Vehicle-seconds waited in the interval.
    rank_veh_s: (states, 3, movements) int64
        The same plus the guess of what the queue costs from then on.
    digest: (states, 3, movements) uint64
        Number that tells how its lanes stand.
    """

    queue_veh: IntArray
    ready_s: FloatArray
    wait_veh_s: LongArray
    rank_veh_s: LongArray
    digest: npt.NDArray[np.uint64]


AHEAD_INTERVALS = 4
"""What a queued vehicle is thought to wait yet, in decision intervals: found by trials (ours)."""


@allocating_kernel
def search(crossing: KnownIntersection, width: int) -> tuple[IntArray, LongArray]:
    """Find phases with little waiting, the fewer vehicle-seconds the wider the beam (ours).

    Of all states that follow from those kept, the ``width`` best are kept at every decision: by
    what was waited so far plus `AHEAD_INTERVALS` for every vehicle queued. Of equal states the one
    that waited less is kept. With a width that is never reached the result is the optimum.

    Parameters
    ----------
    crossing
        See `KnownIntersection`.
    width
        States kept.

    Returns
    -------
    phases: (decisions,) int32
    wait_veh_s: (decisions,) int64
        Vehicle-seconds waited in each interval.
    """
    interval_s = crossing.rules.decision_interval_s
    decisions = crossing.arriving_veh.shape[0] // interval_s
    phase_count, movements = crossing.served.shape
    lanes = int(crossing.lane_offset[movements])
    kept, following = _make_states(width, lanes), _make_states(width, lanes)
    kept.phase[0] = -1
    count = 1
    trials = Trials(
        np.zeros((width, 3, lanes), np.int32),
        np.zeros((width, 3, lanes)),
        np.zeros((width, 3, movements), np.int64),
        np.zeros((width, 3, movements), np.int64),
        np.zeros((width, 3, movements), np.uint64),
    )
    rank = np.zeros(width * phase_count, np.int64)
    choice = np.zeros(width * phase_count, np.int64)
    digest = np.zeros(width * phase_count, np.uint64)
    table_size = 2
    while table_size < 4 * width:
        table_size *= 2
    table = np.zeros(table_size, np.uint64)
    origin = np.zeros((decisions, width), np.int64)
    wait_at = np.zeros((decisions, width), np.int64)
    for decision in range(decisions):
        begin_s = decision * interval_s
        ahead_s = 0 if decision == decisions - 1 else AHEAD_INTERVALS * interval_s
        found = 0
        for state in range(count):
            _try_movements(crossing, kept, trials, state, begin_s, ahead_s)
            for phase in range(phase_count):
                if is_allowed(crossing, kept, state, phase, begin_s):
                    rank[found] = _ranked(crossing, kept, trials, state, phase)
                    digest[found] = _stands(crossing, kept, trials, state, phase, begin_s)
                    choice[found] = state * phase_count + phase
                    found += 1
        table[:] = np.uint64(0)
        count = 0
        for place in np.argsort(rank[:found], kind="mergesort"):
            if count == width:
                break
            if not _is_new(table, digest[place]):
                continue
            state, phase = choice[place] // phase_count, choice[place] % phase_count
            _take(crossing, kept, trials, state, phase, begin_s, following, count)
            origin[decision, count] = choice[place]
            wait_at[decision, count] = following.wait_veh_s[count]
            count += 1
        kept, following = following, kept
    phases = np.zeros(decisions, np.int32)
    wait_veh_s = np.zeros(decisions, np.int64)
    state = 0
    for decision in range(decisions - 1, -1, -1):
        wait_veh_s[decision] = wait_at[decision, state]
        phases[decision] = origin[decision, state] % phase_count
        state = origin[decision, state] // phase_count
        if decision > 0:
            wait_veh_s[decision] -= wait_at[decision - 1, state]
    return phases, wait_veh_s


@allocating_kernel
def _make_states(width: int, lanes: int) -> States:
    return States(
        np.zeros((width, lanes), np.int32),
        np.zeros((width, lanes)),
        np.zeros(width, np.int32),
        np.zeros(width, np.int32),
        np.zeros(width, np.int64),
    )


@kernel
def _try_movements(
    crossing: KnownIntersection,
    kept: States,
    trials: Trials,
    state: int,
    begin_s: int,
    ahead_s: int,
) -> None:
    """Run every movement of a state over one interval, for all that it may meet."""
    rules = crossing.rules
    end_s = begin_s + rules.decision_interval_s
    clearance_s = rules.clearance_s if kept.phase[state] >= 0 else 0
    anew_s = begin_s + clearance_s + rules.startup_lost_s
    for movement in range(crossing.unsignalled.shape[0]):
        first, last = crossing.lane_offset[movement], crossing.lane_offset[movement + 1]
        for meets in range(3):
            queue, ready_s = trials.queue_veh[state, meets], trials.ready_s[state, meets]
            for lane in range(first, last):
                queue[lane] = kept.queue_veh[state, lane]
                ready_s[lane] = kept.ready_s[state, lane]
            go_from_s = NEVER_S if meets == RED else begin_s if meets == KEPT else anew_s
            waited = run_movement(crossing, queue, ready_s, movement, begin_s, end_s, go_from_s)
            trials.wait_veh_s[state, meets, movement] = waited
            left, digest = 0, np.uint64(0)
            for lane in range(first, last):
                left += queue[lane]
                late_s = max(ready_s[lane] - end_s, 0.0)
                stands = np.uint64(queue[lane]) + (np.uint64(late_s * 65536) << np.uint64(32))
                digest += _mixed(stands + _mixed(np.uint64(lane + 1)))
            trials.digest[state, meets, movement] = digest
            trials.rank_veh_s[state, meets, movement] = waited + left * ahead_s


@kernel
def _ranked(
    crossing: KnownIntersection, kept: States, trials: Trials, state: int, phase: int
) -> int:
    """Return what was waited so far, with this phase in the interval, and the guess of the rest."""
    total = kept.wait_veh_s[state]
    for movement in range(crossing.unsignalled.shape[0]):
        meets = meets_with(crossing, kept, state, phase, movement)
        total += trials.rank_veh_s[state, meets, movement]
    return int(total)


@kernel
def _stands(
    crossing: KnownIntersection, kept: States, trials: Trials, state: int, phase: int, begin_s: int
) -> np.uint64:
    """Return the digest of the state that a phase leads to; never 0."""
    digest = np.uint64(1)
    for movement in range(crossing.unsignalled.shape[0]):
        meets = meets_with(crossing, kept, state, phase, movement)
        digest += trials.digest[state, meets, movement]
    rules = crossing.rules
    longest_s = max(rules.min_green_s, rules.max_green_s)
    if longest_s + rules.clearance_s + rules.startup_lost_s > 0:
        # Else it makes no difference which phase was shown.
        green_s = rules.decision_interval_s
        if phase == kept.phase[state]:
            green_s += begin_s - kept.green_from_s[state]
        elif kept.phase[state] >= 0:
            green_s -= rules.clearance_s
        shown = np.uint64(phase + 1) + (np.uint64(min(green_s, longest_s)) << np.uint64(32))
        digest += _mixed(shown)
    return max(digest, np.uint64(1))


@kernel
def _mixed(number: np.uint64) -> np.uint64:
    """Scatter 64 bits (the finaliser of Steele, Lea and Flood's splittable generator, 2014)."""
    number += np.uint64(0x9E3779B97F4A7C15)
    number = (number ^ (number >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    number = (number ^ (number >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return number ^ (number >> np.uint64(31))


@kernel
def _is_new(table: npt.NDArray[np.uint64], digest: np.uint64) -> bool:
    """Put a digest into a hash table; tell whether it was not there yet."""
    mask = np.uint64(table.shape[0] - 1)
    place = digest & mask
    while table[place] != np.uint64(0):
        if table[place] == digest:
            return False
        place = (place + np.uint64(1)) & mask
    table[place] = digest
    return True


@kernel
def _take(
    crossing: KnownIntersection,
    kept: States,
    trials: Trials,
    state: int,
    phase: int,
    begin_s: int,
    following: States,
    place: int,
) -> None:
    """Write down the state that a phase leads to."""
    shown = kept.phase[state]
    following.phase[place] = phase
    if phase == shown:
        following.green_from_s[place] = kept.green_from_s[state]
    else:
        clearance_s = crossing.rules.clearance_s if shown >= 0 else 0
        following.green_from_s[place] = begin_s + clearance_s
    following.wait_veh_s[place] = kept.wait_veh_s[state]
    for movement in range(crossing.unsignalled.shape[0]):
        meets = meets_with(crossing, kept, state, phase, movement)
        following.wait_veh_s[place] += trials.wait_veh_s[state, meets, movement]
        for lane in range(crossing.lane_offset[movement], crossing.lane_offset[movement + 1]):
            following.queue_veh[place, lane] = trials.queue_veh[state, meets, lane]
            following.ready_s[place, lane] = trials.ready_s[state, meets, lane]
