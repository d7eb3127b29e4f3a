"""Controllers without memory: the ones to beat."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from pydantic import Field

from dmil.arrays import FloatArray, IntArray
from dmil.controllers.parameters import Settings
from dmil.controllers.protocol import RunContext
from dmil.controllers.rules.phase_choice import PhaseChoice
from dmil.controllers.rules.shared_lanes import SharedLaneGuard
from dmil.errors import InputError
from dmil.simulation import Observation
from dmil.simulation.pressure import movement_pressure
from dmil.simulation.stand_ins import covering_phases
from dmil.simulation.timing import ACTUATED, PROGRAM


class FixedCycleSettings(Settings):
    """A fixed cycle."""

    green_s: float | None = Field(
        default=None,
        gt=0,
        allow_inf_nan=False,
        description="Green per phase in s; by default that of the network's program, or else one "
        "decision interval. Rounded up to whole decision intervals.",
    )


class GreedySettings(Settings):
    """What controllers that serve the phase of the highest score share."""

    approaching: bool = Field(
        default=False,
        description="Whether vehicles that arrive within the decision interval count as queued.",
    )
    hysteresis: float = Field(
        default=0.0,
        ge=0,
        allow_inf_nan=False,
        description="Fraction of the lost time that a switch must make up for: 0 none, 1 all; "
        "without lost time it has no effect.",
    )
    guard: bool = Field(
        default=True,
        description="Whether red counts more, the longer it lasts, where shared lanes were "
        "blocked; false: the published rule.",
    )


class LongestQueueFirstSettings(GreedySettings):
    """Longest queue first."""


class MaxPressureSettings(GreedySettings):
    """Max-pressure."""


class Cycles:
    """Tells the phases of a time: cycles that repeat, whatever happens (ours).

    Parameters
    ----------
    phases
        For every intersection its phases, one per decision interval.
    interval_s
        Decision interval.
    """

    def __init__(self, phases: Sequence[Sequence[int]], interval_s: int) -> None:
        self._length = np.array([len(cycle) for cycle in phases])
        self._phase = np.zeros((len(phases), self._length.max()), np.int32)
        for i, cycle in enumerate(phases):
            self._phase[i, : len(cycle)] = cycle
        self._interval_s = interval_s

    def at(self, time_s: int) -> IntArray:
        """Return the phases of this time: (intersections,) int32."""
        step = (time_s // self._interval_s) % self._length
        phases: IntArray = self._phase[np.arange(step.size), step]
        return phases


class RandomController:
    """Chooses phases uniformly at random: the floor under every comparison."""

    def reset(self, context: RunContext) -> None:
        """Take the stream of chance and the number of phases."""
        self._rng = context.rng
        self._phases = np.array([len(item.phases) for item in context.network.intersections])

    def decide(self, observation: Observation, reward: FloatArray | None) -> IntArray:
        """Draw a phase for every intersection."""
        return self._rng.integers(0, self._phases).astype(np.int32)


class FixedCycleController:
    """Shows the same phases in the same order, whatever happens (specification, §8).

    The cycle holds, in the order of the network, the phases that serve a movement no earlier phase
    of the cycle serves: for the paper's intersection its first four.
    """

    def __init__(self, settings: FixedCycleSettings | None = None) -> None:
        self.settings = settings or FixedCycleSettings()

    def reset(self, context: RunContext) -> None:
        """Lay out one cycle of every intersection in decision intervals."""
        interval_s = context.decision_interval_s
        cycles = []
        for item in context.network.intersections:
            planned_s = item.planned_green_s
            cycle: list[int] = []
            for phase in covering_phases(item):
                green_s = self.settings.green_s or planned_s.get(phase, interval_s)
                cycle += [phase] * math.ceil(green_s / interval_s)
            cycles.append(cycle)
        self._cycles = Cycles(cycles, interval_s)

    def decide(self, observation: Observation, reward: FloatArray | None) -> IntArray:
        """Look up the phase for this time."""
        return self._cycles.at(observation.time_s)


class ProgramController:
    """Leaves every intersection to the program that the network's file has for it.

    In SUMO an actuated program adapts to the traffic; the queue simulator shows its greens as long
    as the file says. A control that only SUMO can run, such as NEMA, is SUMO's there; what the
    queue simulator shows instead: see `dmil.simulation.stand_ins`.
    """

    asks_for = PROGRAM

    def reset(self, context: RunContext) -> None:
        """Check that there are programs.

        Raises
        ------
        InputError
            If an intersection has none.
        """
        for item in context.network.intersections:
            if item.program is None and not item.own_control:
                raise InputError(
                    "it has no signal program of its own",
                    where=f"intersection '{item.id}'",
                    mend="choose the controller fixed-cycle, which makes a plan from the phases",
                )
        count = len(context.network.intersections)
        self._phases = np.full(count, self.asks_for, np.int32)

    def decide(self, observation: Observation, reward: FloatArray | None) -> IntArray:
        """Ask for the program, again and again."""
        return self._phases


class ActuatedController(ProgramController):
    """Leaves every intersection to SUMO's actuated control of its program; runs in SUMO only."""

    asks_for = ACTUATED


class _GreedyController:
    """Serves the phase of the highest score, what is owed to shared lanes added."""

    settings: GreedySettings

    def reset(self, context: RunContext) -> None:
        """Note which movements each phase serves, and which share lanes."""
        hysteresis = self.settings.hysteresis
        self._network = context.network
        self._choice = PhaseChoice(context.network, context.timing, hysteresis)
        self._guard = SharedLaneGuard(context, enabled=self.settings.guard)

    def _best(self, weight_veh: npt.NDArray[Any], observation: Observation) -> IntArray:
        if self._guard.needed:
            weight_veh = weight_veh + self._guard.owed_veh(observation)
        return self._choice.best(weight_veh, observation.phase)


class LongestQueueFirstController(_GreedyController):
    """Serves the phase with the most vehicles queued in front of it.

    What a switch costs, and which of equally good phases is taken: see `PhaseChoice`; what keeps
    lanes that movements share from getting stuck: `SharedLaneGuard`.
    """

    def __init__(self, settings: LongestQueueFirstSettings | None = None) -> None:
        self.settings = settings or LongestQueueFirstSettings()

    def decide(self, observation: Observation, reward: FloatArray | None) -> IntArray:
        """Compare the queues of all phases."""
        counted_veh = observation.queue_veh
        if self.settings.approaching:
            counted_veh = counted_veh + observation.approaching_veh
        return self._best(counted_veh, observation)


class MaxPressureController(_GreedyController):
    """Serves the phase with the highest pressure (Varaiya 2013).

    What a switch costs, and which of equally good phases is taken: see `PhaseChoice`; what keeps
    lanes that movements share from getting stuck: `SharedLaneGuard`. With ``approaching`` vehicles
    that arrive within the decision interval count as queued where they come from, since this green
    can serve them; where a movement leads to, only those queued do.
    """

    def __init__(self, settings: MaxPressureSettings | None = None) -> None:
        self.settings = settings or MaxPressureSettings()

    def decide(self, observation: Observation, reward: FloatArray | None) -> IntArray:
        """Compare the pressures of all phases."""
        pressure_veh = movement_pressure(observation.queue_veh, self._network)
        if self.settings.approaching:
            pressure_veh += observation.approaching_veh
        return self._best(pressure_veh, observation)
