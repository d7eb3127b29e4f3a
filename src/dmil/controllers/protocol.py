"""What a controller is: few verbs, all intersections at once."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

import numpy as np

from dmil.arrays import Arrays, FloatArray, IntArray
from dmil.demand import Vehicles
from dmil.network import RoadNetwork
from dmil.scenarios import QueueDynamics, SignalTiming
from dmil.simulation import Observation


@dataclass(frozen=True, slots=True)
class RunContext:
    """What a controller is told before a run begins.

    Attributes
    ----------
    network: RoadNetwork
        The roads and signals it controls.
    timing: SignalTiming
        When it decides, and what a change of phase costs.
    rng: numpy.random.Generator
        The only source of chance it may use.
    vehicles: Vehicles or None
        All journeys of the run, for those who are meant to know the future: a plan made from
        counts, the limit of what is possible. Who competes does not look.
    dynamics: QueueDynamics
        How queues discharge, as an engineer would have measured it.
    """

    network: RoadNetwork
    timing: SignalTiming
    rng: np.random.Generator
    vehicles: Vehicles | None = None
    dynamics: QueueDynamics = field(default_factory=QueueDynamics)

    @property
    def decision_interval_s(self) -> int:
        """Time between two decisions."""
        return self.timing.decision_interval_s


@runtime_checkable
class Controller(Protocol):
    """Chooses the phase of every intersection, every decision interval."""

    def reset(self, context: RunContext) -> None:
        """Get ready for a run; what was learned in an earlier run on the same network stays."""

    def decide(self, observation: Observation, reward: FloatArray | None) -> IntArray:
        """Choose phases, learning from the reward of the last choice.

        Parameters
        ----------
        observation
            What is seen now.
        reward: (intersections,) float64 or None
            Reward of the interval that ended now; None at the first decision of a run.

        Returns
        -------
        phases: (intersections,) int32
        """


@dataclass(frozen=True, slots=True)
class MemoryUse:
    """How much a controller remembers, after the paper's §V and in bytes.

    Attributes
    ----------
    short_term_entries, long_term_entries, table_entries: float
        States stored, m_s, m_L and m_Q: mean over the agents.
    msize: float
        The paper's size: 3·m_L + |A|·m_s, or |A|·m_Q: mean over the agents.
    entries_total: int
        States stored by all agents together; what all share counts once: one table, or the rows
        that all have since they last met the central unit.
    bytes_total: int
        Memory of these entries and the index over them, all agents together.
    messages: int
        Messages between agents and the central unit since the run began, both ways, with those
        that were lost.
    exchanged_bytes: int
        Bytes of the rows in these messages.
    """

    short_term_entries: float = 0.0
    long_term_entries: float = 0.0
    table_entries: float = 0.0
    msize: float = 0.0
    entries_total: int = 0
    bytes_total: int = 0
    messages: int = 0
    exchanged_bytes: int = 0

    @property
    def entries(self) -> float:
        """States stored per agent, in whichever memory."""
        return self.short_term_entries + self.long_term_entries + self.table_entries


NO_MEMORY = MemoryUse()
"""What a controller without memory uses."""


@runtime_checkable
class MemoryController(Controller, Protocol):
    """A controller that remembers, and whose memory can be measured, saved and loaded."""

    def memory_use(self) -> MemoryUse:
        """Return how much is remembered now."""

    def arrays(self) -> Arrays:
        """Return all that was learned as flat arrays, as `restore` takes them."""

    def restore(self, arrays: Arrays) -> None:
        """Replace all that was learned; call after `reset`."""
