"""What rules see at a decision, as a tuple for their kernels."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from dmil.arrays import IntArray
from dmil.simulation import Observation


class Observed(NamedTuple):
    """The vehicles and signals of an observation.

    Attributes
    ----------
    queue_veh, approaching_veh: (intersections, movements) int32
    shown: (intersections,) int32
        Phase shown, −1 for none.
    elapsed_s: (intersections,) int32
        For how long it has been green.
    """

    queue_veh: IntArray
    approaching_veh: IntArray
    shown: IntArray
    elapsed_s: IntArray


def observed(observation: Observation) -> Observed:
    """Return what rules see of an observation (ours)."""
    # As a kernel that is typed once reads them, whatever the simulator's arrays are.
    return Observed(
        queue_veh=np.ascontiguousarray(observation.queue_veh, np.int32),
        approaching_veh=np.ascontiguousarray(observation.approaching_veh, np.int32),
        shown=np.ascontiguousarray(observation.phase, np.int32),
        elapsed_s=np.ascontiguousarray(observation.phase_elapsed_s, np.int32),
    )
