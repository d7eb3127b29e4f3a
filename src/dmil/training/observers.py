"""How a run is watched: whoever wants to know something of it is told by the one loop."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from dmil.controllers import NO_MEMORY, Controller, MemoryController, MemoryUse
from dmil.simulation import Observation, Simulator

if TYPE_CHECKING:
    from dmil.training.loop import Run

Phases = npt.NDArray[np.integer]


class Observer:
    """Watches runs and changes nothing; subclasses take what they want to know (ours).

    One observer may watch several runs, one after the other.
    """

    def begin(self, simulator: Simulator, controller: Controller, seen: Observation) -> None:
        """Hear that a run begins.

        Parameters
        ----------
        simulator, controller
            Who takes part; read, do not call what moves them.
        seen
            The empty network, before the first decision.
        """

    def decided(self, seen: Observation, phases: Phases) -> None:
        """Hear what was decided.

        Parameters
        ----------
        seen
            What the controller saw.
        phases: (intersections,) int32
            What it asked for.
        """

    def advanced(self, phases: Phases, seen: Observation) -> None:
        """Hear what an interval came to.

        Parameters
        ----------
        phases: (intersections,) int32
            What was asked for.
        seen
            How things stand at its end.
        """

    def rewarded(self, reward: npt.NDArray[np.float64]) -> None:
        """Hear the reward of an interval; the last one of a run has none.

        Parameters
        ----------
        reward: (intersections,) float64
        """

    def episode_ended(self, episode: int, result: Run) -> None:
        """Hear that an episode of a training is over.

        Parameters
        ----------
        episode
            Its number, from 0.
        result
            What happened in it.
        """


class MemoryRecorder(Observer):
    """Notes the memory in use at every decision (ours).

    Attributes
    ----------
    time_s: list of int
        Times of the decisions of the last run.
    memory: list of MemoryUse
        Memory in use after each.
    """

    def __init__(self) -> None:
        self.time_s: list[int] = []
        self.memory: list[MemoryUse] = []

    def begin(self, simulator: Simulator, controller: Controller, seen: Observation) -> None:
        """Forget the run before."""
        self.time_s, self.memory = [], []
        self._memory_use = memory_use_of(controller)

    def decided(self, seen: Observation, phases: Phases) -> None:
        """Note how much is remembered now."""
        self.time_s.append(seen.time_s)
        self.memory.append(self._memory_use())


def memory_use_of(controller: Controller) -> Callable[[], MemoryUse]:
    """Return what tells a controller's memory in use, none if it has none (ours).

    To be asked for once a run: whether an object follows a protocol takes longer to find out than
    many a decision.
    """
    return controller.memory_use if isinstance(controller, MemoryController) else lambda: NO_MEMORY
