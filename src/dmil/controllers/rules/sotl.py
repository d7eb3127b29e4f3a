"""Self-organising traffic lights (SOTL) with platoons, for any number of phases.

Every signalled movement j with red counts κ_j, the vehicle-seconds before it since it turned red:
at each decision, T seconds apart, κ_j += T·(queued + approaching vehicles); at green κ_j = 0. With
the phase p shown for g seconds, let K(q) be the sum of κ_j over the movements of q, q* the phase
of the greatest K (the first of equal ones), and n the vehicles queued or approaching on p's
movements:

    show q*   if g ≥ min_green_s  and  K(q*) ≥ theta_veh_s  and not 0 < n < mu_veh
    else keep p.

The last condition keeps the end of a platoon together: a few vehicles are let through, a long
column may be cut.

Source: Gershenson (2005), "Self-organizing traffic lights", method SOTL-platoon; Cools, Gershenson
and D'Hooghe (2013), "Self-organizing traffic lights: a realistic simulation". Differs from the
papers: they have two phases and toggle, here the phase with the greatest count follows; they see
vehicles within the distances ρ of a red and ω of a green light in every second, here both are as
far as a vehicle drives in one decision interval, and counts are taken at decisions. Their μ = 3 is
not the default: with an ω this long some vehicle is nearly always near.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from pydantic import Field

from dmil.arrays import BoolArray, FloatArray, IntArray
from dmil.compilation import TypedOnce, kernel
from dmil.controllers.parameters import Settings, parameters_of
from dmil.controllers.protocol import RunContext
from dmil.controllers.rules.phase_choice import Observed, observed, signalled
from dmil.simulation import Observation


class SotlSettings(Settings):
    """Self-organising traffic lights."""

    theta_veh_s: float = Field(
        default=20.0,
        ge=0,
        allow_inf_nan=False,
        description="θ: vehicle-seconds on red from which a phase may request green.",
    )
    min_green_s: int = Field(default=0, ge=0, description="φ_min: minimum green in s.")
    mu_veh: int = Field(
        default=0,
        ge=0,
        description="μ: platoons of fewer vehicles than this are let through; 0 or 1: none "
        "(papers: 3).",
    )


class SotlParams(NamedTuple):
    """Numbers for the kernel: see `SotlSettings`; ``interval_s`` is T."""

    interval_s: int
    theta_veh_s: float
    min_green_s: int
    mu_veh: int


class SotlController:
    """Switches to the phase before which most vehicle-seconds of red have been counted."""

    def __init__(self, settings: SotlSettings | None = None) -> None:
        self.settings = settings or SotlSettings()

    def reset(self, context: RunContext) -> None:
        """Start all counts at 0."""
        self._served = signalled(context.network)
        intersections, _, width = self._served.shape
        self._phase_count = np.array([len(item.phases) for item in context.network.intersections])
        self._kappa_veh_s = np.zeros((intersections, width))
        self._organise = TypedOnce(organise)
        self._params = parameters_of(
            SotlParams, self.settings, interval_s=context.decision_interval_s
        )

    def decide(self, observation: Observation, reward: FloatArray | None) -> IntArray:
        """Count, compare, and switch where the count is high enough."""
        phases = np.empty(observation.phase.size, np.int32)
        self._organise(
            self._served,
            self._phase_count,
            self._params,
            observed(observation),
            self._kappa_veh_s,
            phases,
        )
        return phases


@kernel
def organise(
    served: BoolArray,
    phase_count: npt.NDArray[np.int64],
    params: SotlParams,
    seen: Observed,
    kappa_veh_s: FloatArray,
    phases: IntArray,
) -> None:
    """Count and choose for all intersections; see the top of this file.

    Without a phase shown, at the beginning of a run, the phase of the greatest count is taken.

    Parameters
    ----------
    served: (intersections, phases, movements) bool
        See `signalled`.
    phase_count: (intersections,) int64
    kappa_veh_s: (intersections, movements) float64
        κ; changed in place.
    phases: (intersections,) int32
        Filled with the phases to show.
    """
    for i in range(seen.shown.shape[0]):
        now = seen.shown[i]
        green_veh = 0
        for j in range(kappa_veh_s.shape[1]):
            near_veh = seen.queue_veh[i, j] + seen.approaching_veh[i, j]
            if now >= 0 and served[i, now, j]:
                kappa_veh_s[i, j] = 0.0
                green_veh += near_veh
            else:
                kappa_veh_s[i, j] += params.interval_s * near_veh
        best, most_veh_s = 0, -1.0
        for q in range(phase_count[i]):
            total_veh_s = 0.0
            for j in range(kappa_veh_s.shape[1]):
                if served[i, q, j]:
                    total_veh_s += kappa_veh_s[i, j]
            if total_veh_s > most_veh_s:
                best, most_veh_s = q, total_veh_s
        platoon = 0 < green_veh < params.mu_veh
        if now < 0 or (
            seen.elapsed_s[i] >= params.min_green_s
            and most_veh_s > 0
            and most_veh_s >= params.theta_veh_s
            and not platoon
        ):
            phases[i] = best
        else:
            phases[i] = now
