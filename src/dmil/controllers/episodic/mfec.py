"""Model-free episodic control: acts on the best return that ever followed (Blundell et al. 2016).

See docs/controllers/mfec.md.
"""

from __future__ import annotations

import numpy as np
from pydantic import Field

from dmil.arrays import Arrays, FloatArray, IntArray
from dmil.compilation import kernel
from dmil.controllers.episodic.by_shape import (
    ReturnWindow,
    SharedLearner,
    SharedSettings,
    as_keys,
    best_tried,
)
from dmil.controllers.protocol import MemoryUse, RunContext
from dmil.errors import DivergedError
from dmil.memory.episodic import estimate, keep_best
from dmil.memory.neighbours import (
    Entries,
    KeyArray,
    Neighbours,
    TimeArray,
    make_entries,
    make_neighbours,
)
from dmil.memory.packing import bytes_of_entries, pack_entries, unpack_entries
from dmil.simulation import Observation


class MfecSettings(SharedSettings):
    """Model-free episodic control."""

    discount: float = Field(default=0.95, ge=0, lt=1, description="γ.")
    steps: int = Field(
        default=20, ge=1, description="n of n-step returns, in decisions; the task is continuing."
    )
    bootstrap: bool = Field(
        default=False,
        description="Whether returns bootstrap after n rewards. Since that value is a maximum as "
        "well, the upward bias accumulates.",
    )
    neighbours: int = Field(
        default=11, ge=1, description="Nearest entries in the mean for an unknown state."
    )
    capacity: int = Field(
        default=10_000,
        ge=1,
        description="Entries per phase and shape; the least recently used one is dropped.",
    )


class MfecController(SharedLearner):
    """One agent per intersection; agents of one shape share a table of entries per phase.

    Differs from the paper: returns are taken over n decisions, because traffic has no episodes; the
    state is the counts themselves, not a projection of a picture.
    """

    SOURCES = ("exact", "neighbours", "untried")
    _entries: Entries

    def __init__(self, settings: MfecSettings | None = None) -> None:
        self.settings = settings or MfecSettings()
        super().__init__("mfec", self.settings)

    def reset(self, context: RunContext) -> None:
        """Get ready for a run; see `SharedLearner.reset`."""
        super().reset(context)
        self._window = ReturnWindow(self.settings.steps, self.settings.discount)

    def decide(self, observation: Observation, reward: FloatArray | None) -> IntArray:
        """Look all phases up, learn the return that is known now, choose ε-greedily.

        Raises
        ------
        DivergedError
            If a value or a return is not finite.
        """
        settings, key = self.settings, as_keys(self.states(observation))
        # Who learns tries everything once; who does not keeps to what was tried.
        value = np.full((len(key), self._actions), np.inf if settings.learning else -np.inf)
        estimate_all(
            self._entries,
            self.agents.shape,
            self._phase_count,
            key,
            self._nearest,
            settings.learning,
            value,
            self._lookups,
        )
        action = self.choose(value, observation)
        if settings.learning:
            if reward is not None:
                self._learn(reward, value, observation.time_s)
            self._window.choose(key, action)
            self._decisions += 1
        return action

    def memory_use(self) -> MemoryUse:
        """Return how much is remembered now: one entry per state and phase."""
        sizes = self._entries.size.reshape(-1, self._actions).sum(axis=1)
        return self.use_of(sizes, bytes_of_entries(self._entries))

    def arrays(self) -> Arrays:
        """Return the entries as flat arrays."""
        return self._with_decisions(pack_entries(self._entries))

    def restore(self, arrays: Arrays) -> None:
        """Replace the entries.

        Raises
        ------
        PolicyError
            If the arrays are not those of entries of these agents.
        """
        entries = unpack_entries(arrays, self._entries)
        self._take_decisions(arrays)
        self._entries = entries

    def _start(self) -> None:
        self._actions = int(self._phase_count.max())
        tables = len(self.agents.signatures) * self._actions
        self._entries = make_entries(tables, self.settings.capacity, self.places)
        self._nearest = make_neighbours(self.settings.neighbours)

    def _learn(self, reward: FloatArray, value: FloatArray, time_s: int) -> None:
        found = self._window.reward(reward, best_tried(value) if self.settings.bootstrap else 0.0)
        if found is not None:
            (key, action), outcome = found
            if not np.isfinite(outcome).all():
                raise DivergedError("mfec", "returns", time_s)
            keep_all(self._entries, self.agents.shape, self._actions, key, action, outcome)


@kernel
def estimate_all(
    entries: Entries,
    shape: IntArray,
    phase_count: IntArray,
    key: KeyArray,
    nearest: Neighbours,
    touches: bool,
    value: FloatArray,
    lookups: TimeArray,
) -> None:
    """Look up the states of all agents under every phase.

    Parameters
    ----------
    entries
        Table shape·actions + action is that of a shape and an action.
    shape, phase_count: (agents,) int32
    key: (agents, places) float32
    touches
        Whether what is read counts as used.
    value: (agents, actions) float64
        Filled in place where a table has entries.
    lookups: (3,) int64
        Look-ups by `SOURCES`, counted up.
    """
    actions = value.shape[1]
    for agent in range(shape.shape[0]):
        for action in range(phase_count[agent]):
            table = shape[agent] * actions + action
            if entries.size[table] == 0:
                lookups[2] += 1
                continue
            found, exact = estimate(entries, table, key[agent], nearest, touches)
            value[agent, action] = found
            lookups[0 if exact else 1] += 1


@kernel
def keep_all(
    entries: Entries,
    shape: IntArray,
    actions: int,
    key: KeyArray,
    action: IntArray,
    outcome: FloatArray,
) -> None:
    """Remember the returns of all agents, one after the other."""
    for agent in range(shape.shape[0]):
        keep_best(entries, shape[agent] * actions + action[agent], key[agent], outcome[agent])
