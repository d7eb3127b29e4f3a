"""One intersection in the future: the queue simulator's dynamics, from hypothetical states.

Movements queue in lanes of their own, so that over one decision interval each depends only on
where it stands and whether it has red, goes on at green, or gets green anew. The dynamics are those
of `dmil.simulation.queue.kernel` without storage and priorities.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dmil.arrays import FloatArray, IntArray, LongArray
from dmil.compilation import kernel
from dmil.scenarios import UniformTiming

RED, KEPT, ANEW = range(3)
"""What a movement may meet in an interval: red, green as before, green after a switch."""


class KnownIntersection(NamedTuple):
    """One intersection and all vehicles that will come to it.

    Attributes
    ----------
    served: (phases, movements) bool
        Who may go in a phase, the unsignalled movements left out.
    unsignalled: (movements,) bool
        Who may always go.
    lane_offset: (movements + 1,) int32
        Where the lanes of a movement begin among all lanes.
    arriving_veh: (seconds, movements) int32
        Vehicles that reach the stop line in every second; whole decision intervals.
    headway_s: float
        Time between two vehicles of a lane.
    rules: UniformTiming
        Signal timing; clearance and start-up lost time end within a decision interval.
    """

    served: npt.NDArray[np.bool_]
    unsignalled: npt.NDArray[np.bool_]
    lane_offset: IntArray
    arriving_veh: IntArray
    headway_s: float
    rules: UniformTiming


class States(NamedTuple):
    """Ways in which things may stand at a decision.

    Attributes
    ----------
    queue_veh: (states, lanes) int32
    ready_s: (states, lanes) float64
        When the headway behind the last vehicle that went is over.
    phase, green_from_s: (states,) int32
        Phase shown (−1: none yet), and when it turned green.
    wait_veh_s: (states,) int64
        Vehicle-seconds waited so far.
    """

    queue_veh: IntArray
    ready_s: FloatArray
    phase: IntArray
    green_from_s: IntArray
    wait_veh_s: LongArray


@kernel
def is_allowed(
    crossing: KnownIntersection, kept: States, state: int, phase: int, begin_s: int
) -> bool:
    """Tell whether the signals would grant a phase; see `dmil.simulation.timing.grant`."""
    rules, shown = crossing.rules, kept.phase[state]
    if shown < 0:
        return True
    green_s = begin_s - kept.green_from_s[state]
    if phase == shown:
        too_long = rules.max_green_s > 0 and green_s >= rules.max_green_s
        return not too_long or crossing.served.shape[0] == 1
    return bool(green_s >= rules.min_green_s)


@kernel
def meets_with(
    crossing: KnownIntersection, kept: States, state: int, phase: int, movement: int
) -> int:
    """Tell what a movement meets if a phase is shown."""
    if crossing.unsignalled[movement]:
        return KEPT
    if not crossing.served[phase, movement]:
        return RED
    shown = kept.phase[state]
    if shown < 0 or (crossing.rules.all_stop and shown != phase):
        return ANEW
    return KEPT if crossing.served[shown, movement] else ANEW


@kernel
def run_movement(
    crossing: KnownIntersection,
    queue: IntArray,
    ready_s: FloatArray,
    movement: int,
    begin_s: int,
    end_s: int,
    go_from_s: int,
) -> int:
    """Let the vehicles of a movement come and go; return the vehicle-seconds waited."""
    first, last = crossing.lane_offset[movement], crossing.lane_offset[movement + 1]
    waited = 0
    for time_s in range(begin_s, end_s):
        for _ in range(crossing.arriving_veh[time_s, movement]):
            shortest = first
            for lane in range(first + 1, last):
                if queue[lane] < queue[shortest]:
                    shortest = lane
            queue[shortest] += 1
        for lane in range(first, last):
            while go_from_s <= time_s and queue[lane] > 0 and ready_s[lane] < time_s + 1 - 1e-9:
                queue[lane] -= 1
                ready_s[lane] = max(ready_s[lane], float(time_s)) + crossing.headway_s
            waited += queue[lane]
    return waited
