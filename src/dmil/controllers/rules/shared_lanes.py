"""The guard for shared lanes: who is stuck behind a movement that has red is owed green.

Where movements that have green in different phases share a lane, its first vehicle may want the one
that has red. Then nobody moves though the signal is green; the counts of a controller still speak
for that green, and it may stay for ever. The guard sees this and lets red count more the longer it
lasts, at that intersection and for such movements alone:

    E_i ← 1                if some movement was green for the whole interval that ended, has not
                           fewer vehicles queued than before, and one that shares its lanes, has
                           red and has a queue
    E_i ← E_i·exp(−T/τ)    else, T the decision interval, τ = 1000 s
    A_j ← A_j + T          on red with a queue, else A_j ← 0
    b_j = E_i · β · A_j    vehicles that green for j counts more, β = 0.2 vehicles per s

Rules and memories of lanes, whose scores are in vehicles, add b to them. Learners, whose values are
not, are overruled: the phase q that is owed most replaces their choice p where what is owed to q is
more than all that p could serve, queues and what is owed,

    Σ_{j∈q} b_j > Σ_{j∈p} (queue_j + b_j).

Ours. A term of age for all lanes costs up to 5.6 % near saturation; without the evidence, one for
shared lanes costs up to 5 % where they do not get stuck. With it, what never gets stuck is
controlled as without a guard, to the digit.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from dmil.arrays import BoolArray, FloatArray, IntArray
from dmil.compilation import kernel
from dmil.controllers.protocol import RunContext
from dmil.controllers.rules.phase_choice import signalled
from dmil.network import Intersection
from dmil.simulation import Observation

EVIDENCE_LASTS_S = 1000.0
"""τ: time in which what was seen of a stuck lane loses its weight."""
OWED_VEH_PER_S = 0.2
"""β: what a second of red counts where lanes get stuck, in vehicles."""


class SharedLanes(NamedTuple):
    """The movements that share a lane with one that has not always the same light (ours).

    Attributes
    ----------
    intersection, movement: (shared,) int32
        Where each is.
    rival_offset: (shared + 1,) int32
        Where those begin that share its lanes and have another light, in ``rival``.
    rival: (rivals of all,) int32
        Movements of the same intersection.
    """

    intersection: IntArray
    movement: IntArray
    rival_offset: IntArray
    rival: IntArray


class Waits(NamedTuple):
    """What the guard remembers between decisions.

    Attributes
    ----------
    evidence: (intersections,) float64
        E: 1 when a lane has just been seen stuck, less the longer ago.
    red_s: (shared,) float64
        A: time for which a movement with a queue has had red.
    queue_veh: (shared,) int32
        Vehicles queued at the last decision.
    green: (shared,) bool
        Whether it had green then.
    """

    evidence: FloatArray
    red_s: FloatArray
    queue_veh: IntArray
    green: BoolArray


class SharedLaneGuard:
    """Sees which lanes are stuck, and what green their movements are owed for it.

    Parameters
    ----------
    enabled
        Whether there is a guard; without one no movement counts more.
    """

    def __init__(self, context: RunContext, *, enabled: bool = True) -> None:
        intersections = context.network.intersections
        self._served = signalled(context.network)
        rivals = [
            (i, j, found)
            for i, item in enumerate(intersections if enabled else ())
            for j, found in enumerate(rivals_of_lanes(item))
            if found
        ]
        self._shared = SharedLanes(
            intersection=np.array([i for i, _, _ in rivals], np.int32),
            movement=np.array([j for _, j, _ in rivals], np.int32),
            rival_offset=np.cumsum([0, *(len(found) for _, _, found in rivals)], dtype=np.int32),
            rival=np.array([k for _, _, found in rivals for k in found], np.int32),
        )
        count = len(rivals)
        self._waits = Waits(
            evidence=np.zeros(len(intersections)),
            red_s=np.zeros(count),
            queue_veh=np.zeros(count, np.int32),
            green=np.zeros(count, np.bool_),
        )
        self._interval_s = context.decision_interval_s
        self._owed_veh = np.zeros((len(intersections), self._served.shape[2]))

    @property
    def needed(self) -> bool:
        """Whether any lane could get stuck."""
        return self._waits.red_s.size > 0

    @property
    def bytes_total(self) -> int:
        """Memory of what is remembered between decisions, where it is needed."""
        return sum(array.nbytes for array in self._waits) if self.needed else 0

    def owed_veh(self, observation: Observation) -> FloatArray:
        """Look at the interval that ended; call once per decision.

        Parameters
        ----------
        observation
            What is seen now.

        Returns
        -------
        owed_veh: (intersections, movements) float64
            Vehicles that green for a movement counts more; the same array every time.
        """
        if self.needed:
            watch(
                self._shared,
                self._served,
                self._interval_s,
                observation.queue_veh,
                observation.phase,
                self._waits,
                self._owed_veh,
            )
        return self._owed_veh

    def overrule(self, observation: Observation, phases: IntArray) -> None:
        """Replace the choice of a learner where a stuck lane is owed more; once per decision.

        Parameters
        ----------
        observation
            What is seen now.
        phases: (intersections,) int32
            What was chosen; changed in place.
        """
        if self.needed:
            owed_veh = self.owed_veh(observation)
            replace_phases(
                self._served, observation.queue_veh, owed_veh, self._waits.evidence, phases
            )


def rivals_of_lanes(item: Intersection) -> list[list[int]]:
    """Return for every movement those that share a lane with it and have another light (ours).

    Parameters
    ----------
    item
        An intersection; its movements without a signal have none and are nobody's.
    """
    lanes = [{(each.from_link, lane) for lane in each.lanes} for each in item.movements]
    lights = [tuple(j in phase for phase in item.phases) for j in range(len(lanes))]
    signalled_ones = [j for j in range(len(lanes)) if j not in item.unsignalled]
    rivals: list[list[int]] = [[] for _ in lanes]
    for j in signalled_ones:
        rivals[j] = [k for k in signalled_ones if lanes[j] & lanes[k] and lights[j] != lights[k]]
    return rivals


def lanes_never_free(item: Intersection) -> list[str]:
    """Return the lanes whose movements no phase serves together, as ``LINK_LANE`` (ours).

    Parameters
    ----------
    item
        An intersection; movements without a signal always go.
    """
    using: dict[tuple[str, int], set[int]] = {}
    for j, each in enumerate(item.movements):
        if j not in item.unsignalled:
            for lane in each.lanes:
                using.setdefault((each.from_link, lane), set()).add(j)
    return [
        f"{link}_{lane}"
        for (link, lane), movements in sorted(using.items())
        if not any(movements <= phase for phase in item.phases)
    ]


@kernel
def watch(
    shared: SharedLanes,
    served: BoolArray,
    interval_s: int,
    queue_veh: IntArray,
    shown: IntArray,
    waits: Waits,
    owed_veh: FloatArray,
) -> None:
    """Move the guard on by the interval that ended; see the top of this file.

    Parameters
    ----------
    served: (intersections, phases, movements) bool
        See `dmil.controllers.rules.phase_choice.signalled`.
    interval_s: int
        T.
    queue_veh: (intersections, movements) int32
    shown: (intersections,) int32
        Phase shown, −1 for none.
    waits
        Changed in place.
    owed_veh: (intersections, movements) float64
        b; filled where lanes are shared.
    """
    fades = math.exp(-interval_s / EVIDENCE_LASTS_S)
    for i in range(waits.evidence.shape[0]):
        waits.evidence[i] *= fades
    for place in range(shared.movement.shape[0]):
        i, j = shared.intersection[place], shared.movement[place]
        phase, queue = shown[i], queue_veh[i, j]
        green = phase >= 0 and served[i, phase, j]
        if green and waits.green[place] and queue >= waits.queue_veh[place] > 0:
            for at in range(shared.rival_offset[place], shared.rival_offset[place + 1]):
                rival = shared.rival[at]
                if queue_veh[i, rival] > 0 and not served[i, phase, rival]:
                    waits.evidence[i] = 1.0
        waits.red_s[place] = 0.0 if green or queue == 0 else waits.red_s[place] + interval_s
        waits.queue_veh[place] = queue
        waits.green[place] = green
    for place in range(shared.movement.shape[0]):
        i, j = shared.intersection[place], shared.movement[place]
        owed_veh[i, j] = waits.evidence[i] * OWED_VEH_PER_S * waits.red_s[place]


@kernel
def replace_phases(
    served: BoolArray,
    queue_veh: IntArray,
    owed_veh: FloatArray,
    evidence: FloatArray,
    phases: IntArray,
) -> None:
    """Replace phases where another one is owed more than they could serve; see the top of the file.

    Parameters
    ----------
    served: (intersections, phases, movements) bool
        See `dmil.controllers.rules.phase_choice.signalled`.
    queue_veh: (intersections, movements) int32
    owed_veh: (intersections, movements) float64
        b.
    evidence: (intersections,) float64
        E: where it is 0 nothing is owed.
    phases: (intersections,) int32
        Changed in place.
    """
    for i in range(phases.shape[0]):
        if evidence[i] == 0.0:
            continue
        chosen = phases[i]
        most = 0.0
        for j in range(queue_veh.shape[1]):
            if served[i, chosen, j]:
                most += queue_veh[i, j] + owed_veh[i, j]
        for q in range(served.shape[1]):
            owed = 0.0
            for j in range(queue_veh.shape[1]):
                if served[i, q, j]:
                    owed += owed_veh[i, j]
            if owed > most:
                most = owed
                phases[i] = q
