"""What rules see, and the phase of the highest score: who is served, what a switch costs."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dmil.arrays import BoolArray, FloatArray, IntArray
from dmil.compilation import kernel
from dmil.network import RoadNetwork
from dmil.scenarios import SignalTiming, lost_s
from dmil.simulation import Observation

ROUNDING = 1e-9
"""Pressures are sums of thirds and the like: equal ones may differ in the last bit."""


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


class PhaseChoice:
    r"""Chooses for every intersection the phase with the highest score (ours).

    The score M(q) of a phase is the sum of the weights of the movements it serves. With the phase
    p shown, a switch to q costs L, the mean clearance of the intersection's changes and
    ``startup_lost_s``, of the T seconds until the next decision, in which the movements of q that
    have red now do not go yet; those green in both phases go on. p therefore stays unless some q
    has

        M(q) − h·L / (T − L) · max(0, M(p \ q)) > M(p),

    and the q with the greatest left side is taken. For h = 1 and phases that share nothing this
    says M(q)·(T − L) > M(p)·T: a switch must serve more in what is left of the interval than
    staying serves in all of it. h = 0 compares the scores alone, and so does any h without lost
    time; a great h serves a phase until its queues are empty. Of equally good phases the one shown
    stays, else the first is taken.

    Parameters
    ----------
    network
        The roads and signals.
    timing
        T and L.
    hysteresis
        h.
    """

    def __init__(self, network: RoadNetwork, timing: SignalTiming, hysteresis: float) -> None:
        self._served = signalled(network)
        self._phase_count = np.array([len(item.phases) for item in network.intersections])
        self._score = np.zeros(self._served.shape[1])
        lost = lost_s(timing, network)
        # Signals move in steps of 1 s: less than one is never left to go.
        self._cost = hysteresis * lost / np.maximum(timing.decision_interval_s - lost, 1)

    def best(self, weight: npt.NDArray[np.generic], shown: IntArray) -> IntArray:
        """Return the best phase of every intersection.

        Parameters
        ----------
        weight: (intersections, movements) float or int
        shown: (intersections,) int32
            Phase that goes on for free; −1 for none.

        Returns
        -------
        phases: (intersections,) int32
        """
        phases = np.empty(shown.size, np.int32)
        choose_best(
            self._served,
            self._phase_count,
            weight.astype(np.float64),
            shown,
            self._cost,
            self._score,
            phases,
        )
        return phases


def signalled(network: RoadNetwork) -> BoolArray:
    """Return where a phase serves a movement that needs one (ours).

    Returns
    -------
    served: (intersections, phases, movements) bool
    """
    intersections = network.intersections
    phases = max(len(item.phases) for item in intersections)
    width = max(len(item.movements) for item in intersections)
    served = np.zeros((len(intersections), phases, width), np.bool_)
    for i, item in enumerate(intersections):
        for p, phase in enumerate(item.phases):
            served[i, p, sorted(phase)] = True
    return served


@kernel
def choose_best(
    served: BoolArray,
    phase_count: npt.NDArray[np.int64],
    weight: FloatArray,
    shown: IntArray,
    cost: FloatArray,
    score: FloatArray,
    phases: IntArray,
) -> None:
    """Choose the best phase of every intersection; see `PhaseChoice`.

    Parameters
    ----------
    served: (intersections, phases, movements) bool
        See `signalled`.
    phase_count: (intersections,) int64
    weight: (intersections, movements) float64
    shown: (intersections,) int32
    cost: (intersections,) float64
        h·L / (T − L).
    score: (phases,) float64
        Working space.
    phases: (intersections,) int32
        Filled with the choice.
    """
    for i in range(shown.shape[0]):
        kept = shown[i]
        highest = -np.inf
        for q in range(phase_count[i]):
            total, lost = 0.0, 0.0
            for j in range(weight.shape[1]):
                if served[i, q, j]:
                    total += weight[i, j]
                elif kept >= 0 and served[i, kept, j]:
                    lost += weight[i, j]
            if q != kept and lost > 0.0:
                total -= cost[i] * lost
            score[q] = total
            highest = max(highest, total)
        best = 0
        while score[best] < highest - ROUNDING:
            best += 1
        if kept >= 0 and score[kept] >= highest - ROUNDING:
            best = kept
        phases[i] = best
