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

from typing import NamedTuple

import numpy as np
from pydantic import Field

from dmil.arrays import BoolArray, FloatArray, IntArray
from dmil.compilation import TypedOnce, kernel
from dmil.controllers.parameters import Settings, parameters_of
from dmil.controllers.protocol import RunContext
from dmil.controllers.rules.phase_choice import Observed, observed, signalled
from dmil.simulation import Observation
from dmil.simulation.stand_ins import covering_phases


class GapOutSettings(Settings):
    """Actuated gap-out control."""

    min_green_s: int = Field(default=0, ge=0, description="Minimum green in s.")
    max_green_s: int = Field(
        default=40,
        ge=1,
        description="Maximum green in s while vehicles wait elsewhere.",
    )
    extend_veh: int = Field(
        default=3,
        ge=1,
        description="Vehicles queued or approaching with green that extend it by one decision "
        "interval.",
    )


class GapOutParams(NamedTuple):
    """Numbers for the kernel: see `GapOutSettings`.

    No green that has lasted longer than ``last_extension_s`` is extended.
    """

    min_green_s: int
    extend_veh: int
    last_extension_s: int


class Sequences(NamedTuple):
    """The phases of every intersection in the order in which they have their turns (ours).

    Attributes
    ----------
    phase: (intersections, longest) int32
    length: (intersections,) int32
        How many.
    """

    phase: IntArray
    length: IntArray


class GapOutController:
    """Fully actuated control in a fixed sequence of phases, in the decision grid.

    The sequence holds the phases that serve a movement which no earlier one of it serves, in the
    order of the network (`covering_phases`).
    """

    def __init__(self, settings: GapOutSettings | None = None) -> None:
        self.settings = settings or GapOutSettings()

    def reset(self, context: RunContext) -> None:
        """Lay out the sequences; every intersection stands before the first of its phases."""
        sequences = [covering_phases(item) for item in context.network.intersections]
        length = np.array([len(sequence) for sequence in sequences], np.int32)
        self._sequences = Sequences(np.zeros((length.size, int(length.max())), np.int32), length)
        for i, sequence in enumerate(sequences):
            self._sequences.phase[i, : len(sequence)] = sequence
        self._served = signalled(context.network)
        self._place = np.full(len(sequences), -1, np.int32)
        self._go_on = TypedOnce(go_on)
        self._params = parameters_of(
            GapOutParams,
            self.settings,
            last_extension_s=self.settings.max_green_s - context.decision_interval_s,
        )

    def decide(self, observation: Observation, reward: FloatArray | None) -> IntArray:
        """Keep the green or go on in the sequence."""
        phases = np.empty(self._place.size, np.int32)
        self._go_on(
            self._served,
            self._sequences,
            self._params,
            observed(observation),
            self._place,
            phases,
        )
        return phases


@kernel
def go_on(
    served: BoolArray,
    sequences: Sequences,
    params: GapOutParams,
    seen: Observed,
    place: IntArray,
    phases: IntArray,
) -> None:
    """Keep the green or go on in the sequence, for all intersections; see the top of this file.

    A phase that was asked for and is not shown yet, because the signals refused it, is asked for
    again.

    Parameters
    ----------
    served: (intersections, phases, movements) bool
        See `signalled`.
    place: (intersections,) int32
        Where in its sequence each stands, −1 at the beginning of a run; changed in place.
    phases: (intersections,) int32
        Filled with the phases to show.
    """
    for i in range(place.shape[0]):
        now, length = place[i], sequences.length[i]
        if now >= 0:
            phases[i] = sequences.phase[i, now]
            if seen.shown[i] != phases[i] or seen.elapsed_s[i] < params.min_green_s:
                continue
            coming_veh = _vehicles(served, seen, i, phases[i])
            if coming_veh >= params.extend_veh and seen.elapsed_s[i] <= params.last_extension_s:
                continue
        following = now
        for step in range(1, length + (now < 0)):
            candidate = (now + step) % length
            if _vehicles(served, seen, i, sequences.phase[i, candidate]) > 0:
                following = candidate
                break
        place[i] = max(following, 0)
        phases[i] = sequences.phase[i, place[i]]


@kernel
def _vehicles(served: BoolArray, seen: Observed, i: int, phase: int) -> int:
    """Count the vehicles queued or approaching on the movements of a phase."""
    count = 0
    for j in range(seen.queue_veh.shape[1]):
        if served[i, phase, j]:
            count += seen.queue_veh[i, j] + seen.approaching_veh[i, j]
    return count
