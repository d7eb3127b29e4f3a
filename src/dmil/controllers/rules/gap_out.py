"""Actuated control: a phase keeps green while vehicles come to it, then the next one has its turn.

At every decision, with the phase p of the sequence shown for g seconds, n the vehicles queued or
approaching on p's movements, T the decision interval:

    keep p     if g < min_green_s
               or no other phase of the sequence has a vehicle
               or n ≥ extend_veh and g + T ≤ max_green_s
    else show the next phase of the sequence that has a vehicle queued or approaching.

The first rule that holds decides. "Gap-out" is the end of the second kind of green, by n falling
below ``extend_veh``; "max-out" the other one.

Source: the textbook rules of fully actuated control (minimum green, extension, maximum green,
phases without a call skipped). Differs from a controller on the street: it looks at decisions only,
so the gap is one decision interval, and detectors reach as far as vehicles drive in one.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from pydantic import BaseModel, ConfigDict, Field

from dmil.compilation import kernel
from dmil.controllers.protocol import FloatArray, IntArray, Situation
from dmil.controllers.rules.phase_choice import signalled
from dmil.simulation import Observation
from dmil.simulation.stand_ins import covering_phases

BoolArray = npt.NDArray[np.bool_]


class GapOutSettings(BaseModel):
    """Actuated gap-out control."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    min_green_s: int = Field(
        default=0, ge=0, description="Seconds of green before a phase may end."
    )
    max_green_s: int = Field(
        default=40,
        ge=1,
        description="Seconds of green that are not exceeded while vehicles wait elsewhere.",
    )
    extend_veh: int = Field(
        default=3,
        ge=1,
        description="Vehicles queued or approaching on the movements with green that extend it by "
        "one decision interval.",
    )


class GapOutController:
    """Fully actuated control in a fixed sequence of phases, in the decision grid.

    The sequence holds the phases that serve a movement which no earlier one of it serves, in the
    order of the network (`covering_phases`).

    Parameters
    ----------
    settings
        See `GapOutSettings`.
    """

    def __init__(self, settings: GapOutSettings | None = None) -> None:
        self.settings = settings or GapOutSettings()

    def begin(self, situation: Situation) -> None:
        """Lay out the sequences; every intersection stands before the first of its phases."""
        sequences = [covering_phases(item) for item in situation.network.intersections]
        self._length = np.array([len(sequence) for sequence in sequences], np.int32)
        self._sequence = np.zeros((len(sequences), int(self._length.max())), np.int32)
        for i, sequence in enumerate(sequences):
            self._sequence[i, : len(sequence)] = sequence
        self._served = signalled(situation.network)
        self._place = np.full(len(sequences), -1, np.int32)
        self._interval_s = situation.decision_interval_s

    def decide(self, observation: Observation, reward: FloatArray | None) -> IntArray:
        """Keep the green or go on in the sequence."""
        settings = self.settings
        phases = np.empty(self._place.size, np.int32)
        go_on(
            self._served,
            self._sequence,
            self._length,
            observation.queue_veh,
            observation.approaching_veh,
            observation.phase,
            observation.phase_elapsed_s,
            settings.min_green_s,
            settings.max_green_s - self._interval_s,
            settings.extend_veh,
            self._place,
            phases,
        )
        return phases


@kernel
def go_on(
    served: BoolArray,
    sequence: IntArray,
    length: IntArray,
    queue_veh: IntArray,
    approaching_veh: IntArray,
    shown: IntArray,
    elapsed_s: IntArray,
    min_green_s: int,
    last_extension_s: int,
    extend_veh: int,
    place: IntArray,
    phases: IntArray,
) -> None:
    """Keep the green or go on in the sequence, for all intersections; see the top of this file.

    A phase that was asked for and is not shown yet, because the signals refused it, is asked for
    again.

    Parameters
    ----------
    served: (intersections, phases, orientations) bool
        See `signalled`.
    sequence: (intersections, longest) int32
        Phases in order.
    length: (intersections,) int32
        How many.
    queue_veh, approaching_veh: (intersections, orientations) int32
    shown, elapsed_s: (intersections,) int32
        Phase shown, and for how long it has been green.
    min_green_s, last_extension_s, extend_veh: int
        See `GapOutSettings`; no green that has lasted longer than ``last_extension_s`` is extended.
    place: (intersections,) int32
        Where in its sequence each stands, −1 at the beginning of a run; changed in place.
    phases: (intersections,) int32
        Filled with the phases to show.
    """
    for i in range(place.shape[0]):
        now = place[i]
        if now >= 0:
            phases[i] = sequence[i, now]
            if shown[i] != phases[i] or elapsed_s[i] < min_green_s:
                continue
            coming_veh = _vehicles(served, queue_veh, approaching_veh, i, phases[i])
            if coming_veh >= extend_veh and elapsed_s[i] <= last_extension_s:
                continue
        following = now
        for step in range(1, length[i] + (now < 0)):
            candidate = (now + step) % length[i]
            if _vehicles(served, queue_veh, approaching_veh, i, sequence[i, candidate]) > 0:
                following = candidate
                break
        place[i] = max(following, 0)
        phases[i] = sequence[i, place[i]]


@kernel
def _vehicles(
    served: BoolArray, queue_veh: IntArray, approaching_veh: IntArray, i: int, phase: int
) -> int:
    """Count the vehicles queued or approaching on the movements of a phase."""
    count = 0
    for j in range(queue_veh.shape[1]):
        if served[i, phase, j]:
            count += queue_veh[i, j] + approaching_veh[i, j]
    return count
