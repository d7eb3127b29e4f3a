"""Rules between what a controller asks for and what the signals show.

Minimum green and clearance time are enforced here and nowhere else, whatever the simulator.
"""

from __future__ import annotations

import numpy as np

from dmil.compilation import kernel


@kernel
def grant(  # type: ignore[no-untyped-def]
    requested, phase, previous_phase, green_s, clearance_left_s, min_green_s, clearance_s
):
    """Turn requested phases into the phases shown; return how many requests were refused (ours).

    A change is refused while a clearance runs or the green is younger than ``min_green_s``. A
    granted change starts ``clearance_s`` during which only movements that are green in both phases
    (and unsignalled ones) may go. The first phase of a run needs no clearance.

    Parameters
    ----------
    requested: (intersections,) int
    phase, previous_phase, green_s, clearance_left_s: (intersections,) int32
        Signal state, changed in place.
    min_green_s, clearance_s: int
    """
    refused = 0
    for i in range(phase.shape[0]):
        if requested[i] == phase[i]:
            continue
        if phase[i] < 0:
            phase[i] = requested[i]
            previous_phase[i] = requested[i]
        elif clearance_left_s[i] > 0 or green_s[i] < min_green_s:
            refused += 1
            continue
        else:
            previous_phase[i] = phase[i]
            phase[i] = requested[i]
            clearance_left_s[i] = clearance_s
        green_s[i] = 0
    return refused


@kernel
def may_go(served, phase, previous_phase, clearance_left_s, orientation):  # type: ignore[no-untyped-def]
    """Tell whether a movement has green at one intersection in this second (ours).

    Parameters
    ----------
    served: (phases, orientations) bool
        Unsignalled movements are served in every phase.
    phase, previous_phase, clearance_left_s, orientation: int
    """
    if phase < 0:
        return np.bool_(False)
    if clearance_left_s > 0 and not served[previous_phase, orientation]:
        return np.bool_(False)
    return served[phase, orientation]
