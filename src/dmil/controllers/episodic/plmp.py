"""PLMP, pattern learning with memory and prediction (Han et al., L4DC 2023), reconstructed.

The paper's text could not be had: what is known of it and what is guessed is told apart in
docs/controllers/plmp.md.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from pydantic import Field

from dmil.arrays import Arrays, FloatArray, IntArray
from dmil.compilation import kernel
from dmil.controllers.episodic.by_shape import SharedLearner, SharedSettings
from dmil.controllers.parameters import parameters_of
from dmil.controllers.protocol import MemoryUse, RunContext
from dmil.controllers.tabular.announcements import Announcements
from dmil.controllers.tabular.choice import DRAWS, explores, greedy_action, uniform_action
from dmil.errors import DivergedError
from dmil.memory import (
    ABSENT,
    ValueTable,
    append,
    best_tried,
    bytes_used,
    make_value_table,
    pack,
    unpack_values,
    value_table_with_room,
)
from dmil.memory.neighbours import TimeArray
from dmil.memory.patterns import find_pattern
from dmil.simulation import Observation

FIRST_CAPACITY = 64


class PlmpSettings(SharedSettings):
    """Pattern learning with memory and prediction."""

    reach: int = Field(
        default=1,
        ge=0,
        description="v̄: range of a class, in vehicles above its key and in multiples of it.",
    )
    prediction: bool = Field(
        default=True,
        description="Whether a state without a class is looked up by its one-step prediction.",
    )
    learning_rate: float = Field(default=0.1, ge=0, le=1, description="Learning rate of Q.")
    discount: float = Field(default=0.95, ge=0, lt=1, description="γ.")
    capacity: int = Field(default=10_000, ge=1, description="Maximum classes per shape.")


class PlmpDecision(NamedTuple):
    """One decision of all agents, as the kernel takes it.

    Attributes
    ----------
    pattern, ahead: (agents, places) int32
        What is seen, and what is predicted for one step later.
    row, action: (agents,) int32
        Row and action of the last decision; replaced by those of this one.
    reward: (agents,) float64
        Reward of the last action.
    draws: (agents, 3) float64
        See `dmil.controllers.tabular.choice.DRAWS`.
    epsilon: float
    updates: bool
        Whether there is a last action to learn from.
    alike: (actions,) int32
        0, 1, 2 …
    lookups: (3,) int64
        Look-ups by `SOURCES`, counted up.
    key: (1, places) int32
        Working space.
    """

    pattern: IntArray
    ahead: IntArray
    row: IntArray
    action: IntArray
    reward: FloatArray
    draws: FloatArray
    epsilon: float
    updates: bool
    alike: IntArray
    lookups: TimeArray
    key: IntArray


class PlmpRules(NamedTuple):
    """The settings that the kernel needs; see `PlmpSettings`."""

    reach: int
    prediction: bool
    learning: bool
    learning_rate: float
    discount: float
    capacity: int


class PlmpController(SharedLearner):
    """One agent per intersection; agents of one shape share a table of Q over pattern classes."""

    SOURCES = ("pattern", "prediction", "unseen")
    _table: ValueTable

    def __init__(self, settings: PlmpSettings | None = None) -> None:
        self.settings = settings or PlmpSettings()
        super().__init__("plmp", self.settings)
        self._rules = parameters_of(PlmpRules, self.settings)

    def reset(self, context: RunContext) -> None:
        """Get ready for a run; see `SharedLearner.reset`."""
        super().reset(context)
        self._announcements = Announcements(context)
        agents = self.agents.shape.size
        self._row = np.full(agents, ABSENT, np.int32)
        self._action = np.zeros(agents, np.int32)

    def decide(self, observation: Observation, reward: FloatArray | None) -> IntArray:
        """Find the patterns' classes, learn from the last choice, choose ε-greedily.

        Raises
        ------
        DivergedError
            If a value of Q is not finite.
        """
        settings, count = self.settings, self._action.size
        # Each agent appends one class at most, all of them perhaps to one table.
        self._table = value_table_with_room(self._table, count)
        step = PlmpDecision(
            pattern=self.states(observation),
            ahead=self._ahead(observation),
            row=self._row,
            action=self._action,
            reward=np.zeros(count) if reward is None else reward,
            draws=self._rng.random((count, DRAWS)),
            epsilon=self.epsilon,
            updates=settings.learning and reward is not None,
            alike=np.arange(self._table.value.shape[2], dtype=np.int32),
            lookups=self._lookups,
            key=np.empty((1, self.places), np.int32),
        )
        if not decide_plmp(self._table, self.agents.shape, self._phase_count, step, self._rules):
            raise DivergedError("plmp", "values of Q", observation.time_s)
        self._guard.overrule(observation, self._action)
        self._decisions += settings.learning
        return self._action.copy()

    def memory_use(self) -> MemoryUse:
        """Return how much is remembered now: the classes."""
        return self.use_of(self._table.rows.size, bytes_used(self._table.rows, self._table[1:]))

    def arrays(self) -> Arrays:
        """Return the classes and their Q as flat arrays."""
        return self._with_decisions(pack(self._table))

    def restore(self, arrays: Arrays) -> None:
        """Replace the classes.

        Raises
        ------
        PolicyError
            If the arrays are not those of classes of these agents.
        """
        table = unpack_values(arrays, self._table)
        self._take_decisions(arrays)
        self._table = table

    def _start(self) -> None:
        shapes, actions = len(self.agents.signatures), int(self._phase_count.max())
        self._table = make_value_table(shapes, FIRST_CAPACITY, self.places, actions, 0)

    def _ahead(self, observation: Observation) -> IntArray:
        """Return what is predicted for one step later: (agents, places) int32."""
        queue = self.signalled(self._announcements.queue_ahead(observation))
        if not self.settings.approaching:
            return queue
        # Who approaches after that is not announced yet.
        return np.hstack([queue, np.zeros_like(queue)])


@kernel
def decide_plmp(
    table: ValueTable, shape: IntArray, phase_count: IntArray, step: PlmpDecision, rules: PlmpRules
) -> bool:
    """Choose the next actions of all agents and update Q of the last ones.

    Agents decide one after the other, in the order of the network: each sees what those of its
    shape before it have just learned.

    Returns
    -------
    finite: bool
        Whether every Q that was written is a number.
    """
    finite = True
    for agent in range(shape.shape[0]):
        owner, draws = shape[agent], step.draws[agent]
        row = _find(table, owner, step.pattern, agent, step, rules)
        known, source = row, 0
        if row == ABSENT and rules.prediction:
            known = _find(table, owner, step.ahead, agent, step, rules)
            source = 1
        step.lookups[source if known != ABSENT else 2] += 1
        best = ABSENT
        if known != ABSENT:
            best = best_tried(table, owner, known, phase_count[agent])
        last = step.row[agent]
        if step.updates and last != ABSENT:
            following = table.value[owner, known, best] if best != ABSENT else 0.0
            target = step.reward[agent] + rules.discount * following
            old = table.value[owner, last, step.action[agent]]
            value = old + rules.learning_rate * (target - old)
            finite = finite and np.isfinite(value)
            table.value[owner, last, step.action[agent]] = value
            table.tried[owner, last, step.action[agent]] = True
            table.visits[owner, last] += 1
        count = phase_count[agent]
        if known == ABSENT or explores(draws, step.epsilon):
            action = uniform_action(draws[1], count)
        elif rules.learning:
            # Untried ones count as 0, as in SARSA.
            action = greedy_action(table.value[owner, known], step.alike, count, draws[2])
        else:
            action = best if best != ABSENT else uniform_action(draws[1], count)
        step.action[agent] = action
        if row == ABSENT and rules.learning and table.rows.size[owner] < rules.capacity:
            row = append(table.rows, owner, step.pattern[agent])
        step.row[agent] = row
    return finite


@kernel
def _find(
    table: ValueTable,
    owner: int,
    patterns: IntArray,
    agent: int,
    step: PlmpDecision,
    rules: PlmpRules,
) -> int:
    """Return the class of an agent's pattern, or `ABSENT`."""
    return find_pattern(table.rows, owner, patterns[agent : agent + 1], rules.reach, step.key)
