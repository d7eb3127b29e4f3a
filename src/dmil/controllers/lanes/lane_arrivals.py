"""Who joins lanes: arrival rates, vehicles that wait unseen, detectors that fell silent.

A detector that sees nobody at K = 3 times as many decisions running as ever before, and at 12 at
least, is taken for dead. From then on vehicles join its lanes as they did before at red, λ per
interval, and leave at saturation flow when green,

    Q ← max(0, Q + λ − c·f·T)      Q = 10·λ at first: some came before it was noticed

until the detector sees somebody again; then that silence is the longest so far. Nothing is learned
of such a lane. A detector that never saw anybody is left alone: on real roads that is mostly a
movement that nobody makes (11 % of those in Hangzhou). Ours, after what signal controllers do: no
activity for long is a fault, and the phase of a faulty detector is served from memory.
"""

from __future__ import annotations

import numpy as np

from dmil.compilation import kernel
from dmil.controllers.lanes.lane_groups import LaneGroups
from dmil.controllers.lanes.lane_inputs import (
    HALF,
    ONE,
    PARTLY,
    RED,
    ZERO,
    LaneScratch,
    Real,
    ShortTerm,
    green_part,
)

RATED_ENOUGH = np.float32(1000.0)
"""Intervals after which the moving average forgets at its own pace, whatever the step."""
MOST_UNSEEN_VEH = np.float32(20.0)
"""Vehicles per lane that are believed to wait unseen, at most."""
DEAD = np.uint8(255)
"""Silence of a detector that is taken for dead."""
LEAST_SILENCE, TIMES_LONGEST, LONGEST_KNOWN = 12, 3, 84
"""Decisions without anybody after which a detector may be dead, K, and the longest silence that is
told from longer ones: K times as long stays below `DEAD`."""
UNNOTICED = np.float32(10.0)
"""Intervals for which vehicles have come before a dead detector is noticed."""
RED_STEP = np.float32(1 / 16)
RATE_UNITS = np.float32(1000.0)
"""Step of the moving average of arrivals at red, and how many of its units are a vehicle."""


@kernel
def filled_in(short: ShortTerm, g: int) -> bool:
    """Tell whether the vehicles of a group are from memory, since its detector is dead."""
    return bool(short.silent.shape[0] > 0 and short.silent[g] == DEAD)


@kernel
def count_arrivals(
    groups: LaneGroups,
    use_approaching: bool,
    after_switch: float,
    rate_step: float,
    short: ShortTerm,
    scratch: LaneScratch,
) -> None:
    """Move arrival rates on by the interval that ended, where one can tell who joined.

    One can where all who join were seen before; on red, where nobody leaves; and on green while a
    queue lasts, which discharges at saturation flow.
    """
    own_step, after = np.float32(rate_step), np.float32(after_switch)
    joined_veh, tells, count = scratch.joined_veh, scratch.tells, groups.lanes.shape[0]
    for g in range(count):
        left_veh = green_part(short.treatment[g], after) * groups.lane_veh[g]
        joined_veh[g] = max(ZERO, scratch.queue_veh[g] - short.queue_veh[g] + left_veh)
    for g in range(count):
        treated = short.treatment[g]
        tells[g] = (treated == RED) | ((treated != PARTLY) & (scratch.queue_veh[g] > ZERO))
    if use_approaching:
        for g in range(count):
            joined_veh[g] = short.expected_veh[g] if groups.all_seen[g] else joined_veh[g]
        for g in range(count):
            tells[g] = tells[g] | groups.all_seen[g]
    if short.silent.shape[0] > 0:
        _fill_in(groups, after, short, scratch)
    _count_outside(groups, after, short, scratch)
    for g in range(count):
        rated = np.float32(short.rated[g])
        step = max(own_step, ONE / (ONE + min(rated + ONE, RATED_ENOUGH)))
        step = own_step if rated == RATED_ENOUGH else step
        rate_veh = short.rate_veh[g]
        short.rate_veh[g] = rate_veh + (step * (joined_veh[g] - rate_veh) if tells[g] else ZERO)
    for g in range(count):
        rated = min(short.rated[g] + ONE, RATED_ENOUGH)
        short.rated[g] = rated if tells[g] else short.rated[g]


@kernel
def _fill_in(
    groups: LaneGroups, after_switch: Real, short: ShortTerm, scratch: LaneScratch
) -> None:
    """Notice which detectors fell silent, and count from memory where they did."""
    silent, longest, red_rate = short.silent, short.longest, short.red_rate
    for g in range(silent.shape[0]):
        before_veh = short.queue_veh[g]
        if scratch.queue_veh[g] + scratch.moving_veh[g] > ZERO:
            known = TIMES_LONGEST * longest[g] if silent[g] == DEAD else max(silent[g], 1)
            longest[g] = min(max(longest[g], known), LONGEST_KNOWN)
            silent[g] = 0
        elif silent[g] != DEAD and longest[g] > 0:
            silent[g] += 1
            if silent[g] > max(LEAST_SILENCE, TIMES_LONGEST * longest[g]):
                silent[g] = DEAD
                before_veh = UNNOTICED * red_rate[g] / RATE_UNITS
        if silent[g] != DEAD:
            if short.treatment[g] == RED and longest[g] > 0:
                joined = RATE_UNITS * max(ZERO, scratch.queue_veh[g] - before_veh)
                red_rate[g] += np.int32(RED_STEP * (joined - red_rate[g]))
            continue
        rate_veh = np.float32(red_rate[g]) / RATE_UNITS
        left_veh = green_part(short.treatment[g], after_switch) * groups.lane_veh[g]
        now_veh = min(max(ZERO, before_veh + rate_veh - left_veh), MOST_UNSEEN_VEH)
        scratch.queue_veh[g] = now_veh
        scratch.waiting_veh[g] = HALF * (before_veh + now_veh)
        scratch.tells[g] = False


@kernel
def _count_outside(
    groups: LaneGroups, after_switch: Real, short: ShortTerm, scratch: LaneScratch
) -> None:
    """Count those who wait behind full entries, by the balance of those who come and who join.

    As many come as usual; in the long run that is as many as join.
    """
    outside_veh = short.outside_veh
    for entry in range(groups.entries.shape[0]):
        g = groups.entries[entry]
        full = scratch.queue_veh[g] + scratch.moving_veh[g] >= groups.entry_full_veh[entry]
        before = outside_veh[entry]
        if full or before > ZERO:
            left_veh = green_part(short.treatment[g], after_switch) * groups.lane_veh[g]
            more_veh = scratch.queue_veh[g] - (short.queue_veh[g] - before)
            scratch.joined_veh[g] = max(ZERO, more_veh + left_veh)
            scratch.tells[g] = True
        waiting = before + short.rate_veh[g] - scratch.joined_veh[g]
        outside_veh[entry] = min(max(ZERO, waiting), MOST_UNSEEN_VEH) if full else ZERO
        scratch.queue_veh[g] += outside_veh[entry]
        scratch.waiting_veh[g] += HALF * (before + outside_veh[entry])
