"""What rules see at a decision, as a tuple for their kernels."""

from __future__ import annotations

from typing import NamedTuple

from dmil.controllers.protocol import IntArray
from dmil.simulation import Observation


class Observed(NamedTuple):
    """The vehicles and signals of an observation.

    Attributes
    ----------
    queue_veh, approaching_veh: (intersections, orientations) int32
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
    return Observed(
        queue_veh=observation.queue_veh,
        approaching_veh=observation.approaching_veh,
        shown=observation.phase,
        elapsed_s=observation.phase_elapsed_s,
    )
