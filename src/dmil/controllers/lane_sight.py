"""What is seen and expected of every lane group, and how phases treat it; compiled.

What all memories of lanes share. Each step is a loop over all groups or intersections.
"""

from __future__ import annotations

import numpy as np

from dmil.compilation import kernel
from dmil.controllers.lane_groups import NOWHERE, LaneGroups
from dmil.controllers.lane_state import (
    KEPT,
    PARTLY,
    RED,
    SWITCHED,
    IntArray,
    Scratch,
    Seen,
    ShortTerm,
)

SMALLEST_RATE_VEH = 0.05
"""Added to the rate of every lane group when inflow is divided: no group gets none for ever."""
RATED_ENOUGH = 1000.0
"""Intervals after which the moving average forgets at its own pace, whatever the step."""


@kernel
def note_shown(groups: LaneGroups, seen: Seen, scratch: Scratch) -> None:
    """Note how the phases that are shown treat all groups."""
    shown = scratch.shown
    for g in range(shown.shape[0]):
        shown[g] = RED
    for i in range(seen.shown.shape[0]):
        if seen.shown[i] >= 0:
            phase = groups.phase_offset[i] + seen.shown[i]
            for place in range(groups.served_offset[phase], groups.served_offset[phase + 1]):
                shown[groups.served[place]] = PARTLY if groups.partly[place] else KEPT


@kernel
def forget_overruled(groups: LaneGroups, seen: Seen, short: ShortTerm) -> None:
    """Take lanes as partly served that were not treated as asked for: who joined is not known."""
    for i in range(seen.shown.shape[0]):
        if seen.shown[i] != seen.asked[i]:
            for g in range(groups.group_offset[i], groups.group_offset[i + 1]):
                short.treatment[g] = PARTLY


@kernel
def look(groups: LaneGroups, use_approaching: bool, seen: Seen, scratch: Scratch) -> None:
    """Add up what is seen of every group, per lane."""
    for g in range(groups.lanes.shape[0]):
        queue, approaching, waiting = 0.0, 0.0, 0.0
        for place in range(groups.slot_offset[g], groups.slot_offset[g + 1]):
            slot = groups.slots[place]
            queue += seen.queue_veh[slot]
            approaching += seen.approaching_veh[slot]
            waiting += seen.waiting_veh[slot]
        lanes = groups.lanes[g]
        scratch.queue_veh[g] = queue / lanes
        scratch.expected_veh[g] = approaching / lanes if use_approaching else 0.0
        scratch.waiting_veh[g] = waiting / lanes


@kernel
def count_arrivals(
    groups: LaneGroups,
    use_approaching: bool,
    after_switch: float,
    rate_step: float,
    short: ShortTerm,
    scratch: Scratch,
) -> None:
    """Move arrival rates on by the interval that ended, where one can tell who joined.

    One can where all who join were seen before; on red, where nobody leaves; and on green while a
    queue lasts, which discharges at saturation flow.
    """
    for g in range(groups.lanes.shape[0]):
        treated, queue_veh = short.treatment[g], scratch.queue_veh[g]
        if use_approaching and groups.unseen[groups.link[g]] == 0.0:
            joined_veh = float(short.expected_veh[g])
        elif treated == RED:
            joined_veh = max(0.0, queue_veh - short.queue_veh[g])
        elif treated != PARTLY and queue_veh > 0.0:
            left_veh = green_part(treated, after_switch) * groups.lane_veh[g]
            joined_veh = max(0.0, queue_veh - short.queue_veh[g] + left_veh)
        else:
            continue
        step = rate_step
        if short.rated[g] < RATED_ENOUGH:
            short.rated[g] += np.float32(1.0)
            step = max(step, 1.0 / (1.0 + short.rated[g]))
        short.rate_veh[g] += np.float32(step * (joined_veh - short.rate_veh[g]))


@kernel
def expect_by_rate(groups: LaneGroups, expected: float, short: ShortTerm, scratch: Scratch) -> None:
    """Expect unseen vehicles where no intersection announces them; add up rates by link."""
    for link in range(groups.unseen.shape[0]):
        scratch.link_rate_veh[link] = 0.0
    for g in range(groups.lanes.shape[0]):
        link, rate_veh = groups.link[g], short.rate_veh[g]
        scratch.link_rate_veh[link] += np.float32(groups.lanes[g] * (rate_veh + SMALLEST_RATE_VEH))
        if not groups.is_fed[link]:
            scratch.expected_veh[g] += np.float32(expected * groups.unseen[link] * rate_veh)


@kernel
def announce(
    groups: LaneGroups, use_approaching: bool, seen: Seen, scratch: Scratch, phases: IntArray
) -> None:
    """Note on every link how much of its end will be green and who will come in time."""
    for link in range(groups.unseen.shape[0]):
        scratch.inflow_veh[link] = 0.0
        scratch.green[link] = 0.0
    for i in range(phases.shape[0]):
        phase = groups.phase_offset[i] + phases[i]
        for place in range(groups.served_offset[phase], groups.served_offset[phase + 1]):
            link = groups.link[groups.served[place]]
            part = 0.5 if groups.partly[place] else 1.0
            scratch.green[link] += np.float32(part / groups.links_groups[link])
        for place in range(groups.flow_offset[phase], groups.flow_offset[phase + 1]):
            slot = groups.flows[place]
            link = groups.ahead[slot]
            if link != NOWHERE and groups.unseen[link] > 0.0:
                ready_veh = float(seen.queue_veh[slot])
                if use_approaching:
                    ready_veh += seen.approaching_veh[slot]
                in_time_veh = groups.capacity_veh[slot] * groups.unseen[link]
                scratch.inflow_veh[link] += np.float32(min(ready_veh, in_time_veh))


@kernel
def expect_announced(
    groups: LaneGroups, expected: float, short: ShortTerm, scratch: Scratch
) -> None:
    """Give every group its share of the inflow of its link, as arrivals have been so far."""
    for g in range(groups.lanes.shape[0]):
        link = groups.link[g]
        share = (short.rate_veh[g] + SMALLEST_RATE_VEH) / scratch.link_rate_veh[link]
        scratch.expected_veh[g] += np.float32(expected * scratch.inflow_veh[link] * share)


@kernel
def note_treatment(
    groups: LaneGroups, after_switch: float, scratch: Scratch, phases: IntArray
) -> None:
    """Note how the phases that were chosen treat all groups."""
    treatment = scratch.treatment
    for g in range(treatment.shape[0]):
        treatment[g] = RED
    for i in range(phases.shape[0]):
        phase = groups.phase_offset[i] + phases[i]
        for place in range(groups.served_offset[phase], groups.served_offset[phase + 1]):
            g = groups.served[place]
            wholly = served_wholly(scratch.shown[g], after_switch)
            treatment[g] = PARTLY if groups.partly[place] else wholly


@kernel
def served_wholly(shown: int, after_switch: float) -> int:
    """Return how a group is treated by a phase that serves it wholly."""
    return KEPT if shown == KEPT or after_switch == 1.0 else SWITCHED


@kernel
def green_part(treatment: int, after_switch: float) -> float:
    """Return the part of an interval of green that a treatment is worth by the prior."""
    if treatment == KEPT:
        return 1.0
    if treatment == RED:
        return 0.0
    return after_switch if treatment == SWITCHED else 0.5 * after_switch
