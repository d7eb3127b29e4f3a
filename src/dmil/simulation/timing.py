"""Rules between what a controller asks for and what the signals show.

Minimum green, clearance time and start-up lost time are worked out here and nowhere else, once per
decision; a simulator only compares the time with ``go_from_s``.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dmil.compilation import kernel

IntArray = npt.NDArray[np.int32]

NEVER_S = np.iinfo(np.int32).max
"""``go_from_s`` of a movement that has red."""


class Rules(NamedTuple):
    """The times of `dmil.scenarios.SignalTiming` for kernels, in whole seconds."""

    decision_interval_s: int
    clearance_s: int
    min_green_s: int
    startup_lost_s: int


@kernel
def grant(
    served: npt.NDArray[np.bool_],
    unsignalled: npt.NDArray[np.bool_],
    requested: IntArray,
    phase: IntArray,
    green_from_s: IntArray,
    go_from_s: IntArray,
    time_s: int,
    rules: Rules,
) -> int:
    """Turn requested phases into the phases shown; return how many requests were refused (ours).

    A change is refused while a clearance runs or the green is younger than ``min_green_s``. A
    granted change begins with ``clearance_s`` in which only movements go that are green in both
    phases, and unsignalled ones; a movement that had red loses ``startup_lost_s`` more. The first
    phase of a run needs no clearance.

    Parameters
    ----------
    served: (intersections, phases, orientations) bool
        Who may go in a phase.
    unsignalled: (intersections, orientations) bool
        Who may always go.
    requested, phase: (intersections,) int
        Phases wanted and shown (changed in place; −1 before the first decision).
    green_from_s: (intersections,) int32
        When the phase shown turned or turns green, changed in place.
    go_from_s: (intersections, orientations) int32
        From when on vehicles of a movement go; `NEVER_S` for red. Changed in place.
    time_s: int
    rules
        Signal timing.
    """
    refused = 0
    for i in range(phase.shape[0]):
        if requested[i] == phase[i]:
            continue
        if phase[i] >= 0 and time_s < green_from_s[i] + rules.min_green_s:
            refused += 1
            continue
        green_from_s[i] = time_s if phase[i] < 0 else time_s + rules.clearance_s
        phase[i] = requested[i]
        for j in range(served.shape[2]):
            if unsignalled[i, j]:
                go_from_s[i, j] = 0
            elif not served[i, requested[i], j]:
                go_from_s[i, j] = NEVER_S
            elif go_from_s[i, j] == NEVER_S:
                go_from_s[i, j] = green_from_s[i] + rules.startup_lost_s
    return refused
