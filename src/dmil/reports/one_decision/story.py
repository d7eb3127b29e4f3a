"""What the sections of the page share: one decision of a trace, and how its parts are called."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dmil.reports.one_decision.trace import Decision, Trace
from dmil.reports.one_decision.words import SIDES, IntArray, line

PARTS = {1: ("",), 2: ("counts", "scaled")}
"""What the parts of a key are called, by how many it has."""


@dataclass(frozen=True, slots=True)
class Story:
    """A decision, told.

    Attributes
    ----------
    trace
        The run.
    decision
        The decision that the page follows.
    staging
        A decision that stages a short-term memory.
    """

    trace: Trace
    decision: Decision
    staging: Decision

    @property
    def agent(self) -> int:
        """Whose decision it is."""
        return self.decision.agent

    @property
    def phases(self) -> tuple[str, ...]:
        """Names of the agent's phases."""
        return self.trace.scenario.network.intersections[self.agent].phase_names

    def phase(self, action: int) -> str:
        """Return the name of an action, as code."""
        return f"`{self.phases[action]}`"

    def all_phases(self) -> list[str]:
        """Return the names of all actions, as code."""
        return [self.phase(action) for action in range(len(self.phases))]

    def place(self, agent: int) -> str:
        """Return the name of an agent's intersection, as code."""
        return f"`{self.trace.scenario.network.intersections[agent].id}`"

    def east_becomes(self, variant: int) -> str:
        """Return the side to which a symmetry of the agent's intersection carries the East."""
        shape = self.trace.classes.shape[self.agent]
        first = int(self.trace.classes.movement_image[shape, variant, 0])
        return SIDES[first * len(SIDES) // self.decision.state.size]

    def parts(self, key: IntArray) -> list[tuple[str, IntArray]]:
        """Return the parts of a key, each with its name; each is as long as a state."""
        count = key.size // self.decision.state.size
        return list(zip(PARTS[count], np.split(key, count), strict=True))

    def key(self, key: IntArray) -> str:
        """Return a key in one line."""
        return ", ".join(f"{name} {line(part)}".strip() for name, part in self.parts(key))
