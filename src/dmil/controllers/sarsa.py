"""SARSA on equivalence classes: the paper's non-memory agent (§IV-C) for any embedding."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from dmil.compilation import kernel
from dmil.controllers.agents import agents_of, classes_of
from dmil.controllers.choice import DRAWS, explores, greedy_action, uniform_action
from dmil.controllers.meetings import Meetings
from dmil.controllers.prior import Prior
from dmil.controllers.protocol import Arrays, FloatArray, IntArray, MemoryUse, Situation
from dmil.controllers.settings import SarsaSettings
from dmil.memory import (
    ABSENT,
    Scratch,
    ValueTable,
    average_values,
    bytes_used,
    import_values,
    look_up,
    make_scratch,
    make_value_table,
    pack,
    unpack_values,
    value_table_with_room,
    values_of,
    write,
)
from dmil.network import RoadNetwork
from dmil.simulation import Observation
from dmil.symmetry import Classes, Embedding, embed, embedding

FIRST_CAPACITY = 64


class SarsaController:
    """One SARSA agent per intersection, each with a Q-table over equivalence classes.

    Differs from the paper: nothing; what the paper leaves open (learning rate, unseen states, ties)
    is in the specification, §6, and in docs/paper.md.

    Parameters
    ----------
    settings
        See `SarsaSettings`.
    prior
        What the dummy agent of the training phase learned, to start from.
    """

    def __init__(
        self, settings: SarsaSettings | None = None, *, prior: Prior | None = None
    ) -> None:
        self.settings = settings or SarsaSettings()
        self._embedding = embedding(self.settings.embedding)
        self._prior = prior
        self._table: ValueTable | None = None

    def begin(self, situation: Situation) -> None:
        """Get ready for a run; a memory from an earlier run on the same shapes stays."""
        network = situation.network
        self._rng, self._epsilon = situation.rng, self.settings.epsilon
        self._meetings = Meetings(self.settings)
        self._agents = agents_of(network)
        self._classes = classes_of(network, self._embedding)
        self._scratch = make_scratch(self._classes)
        count, places = len(network.intersections), self._classes.orientation_image.shape[2]
        self._owner = (
            self._agents.shape if self.settings.shared else np.arange(count, dtype=np.int32)
        )
        if self._table is None:
            start = starting_values(network, self._embedding, self._prior)
            self._common = start.rows.size.copy()
            self._table = values_of(
                start,
                np.arange(start.rows.size.size) if self.settings.shared else self._agents.shape,
            )
        self._key, self._key_before = np.zeros((2, count, places), np.int32)
        self._action = np.full(count, ABSENT, np.int32)

    def decide(self, observation: Observation, reward: FloatArray | None) -> IntArray:
        """Choose ε-greedily, update Q of the last choice, meet the central unit when it is time."""
        settings = self.settings
        action = np.empty_like(self._action)
        # One decision appends at most one row per agent, all of them to one table if it is shared.
        more = self._action.size if settings.shared else 1
        self._table = value_table_with_room(self.table, more)
        decide_sarsa(
            self._classes,
            self._table,
            self._owner,
            observation.queue_veh,
            self._key_before,
            self._key,
            self._action,
            action,
            no_reward(reward, self._action.size),
            self._rng.random((self._action.size, DRAWS)),
            self._epsilon,
            settings.learning_rate,
            settings.discount,
            settings.learning and reward is not None,
            self._scratch,
        )
        self._epsilon *= settings.epsilon_decay
        self._key, self._key_before = self._key_before, self._key
        self._action = action
        if settings.learning and self._meetings.due(observation.time_s):
            self._communicate()
        return action

    @property
    def table(self) -> ValueTable:
        """The Q-tables of all agents."""
        assert self._table is not None, "begin comes before anything else"
        return self._table

    def memory_use(self) -> MemoryUse:
        """Return how much is remembered now: |A|·m_Q per agent (paper, §V)."""
        table, sizes = self.table, self.table.rows.size
        actions = self._classes.phase_count[self._agents.shape]
        entries = sizes[self._owner]
        return MemoryUse(
            short_term_entries=0.0,
            long_term_entries=0.0,
            table_entries=float(entries.mean()),
            msize=float((entries * actions).mean()),
            entries_total=int(sizes.sum()),
            bytes_total=bytes_used(table.rows, table[1:]),
        )

    def arrays(self) -> Arrays:
        """Return the Q-tables as flat arrays."""
        return pack(self.table)

    def restore(self, arrays: Arrays) -> None:
        """Replace the Q-tables."""
        self._table = unpack_values(arrays, self._embedding.tolerance)
        self._common = np.zeros_like(self._common)

    def _communicate(self) -> None:
        table = self.table
        for shape, members in enumerate(self._agents.members):
            if self.settings.shared or members.size < 2:
                continue
            common = int(self._common[shape])
            new = int((table.rows.size[members] - common).sum())
            table = value_table_with_room(table, new)
            average_values(table, self._classes, members, common, self._scratch)
            self._common[shape] = table.rows.size[members[0]]
        self._table = table


@lru_cache(maxsize=16)
def starting_values(network: RoadNetwork, embedding: Embedding, prior: Prior | None) -> ValueTable:
    """Return tables with shapes as owners, filled from an exact Q-table if there is one (ours).

    The result is shared by all agents that start from the same prior: copy it, never change it.
    """
    classes = classes_of(network, embedding)
    shapes, _, places = classes.orientation_image.shape
    actions = classes.phase_image.shape[2]
    rows = 0 if prior is None else int(prior.table.rows.size.max())
    table = make_value_table(shapes, FIRST_CAPACITY + rows, places, actions, classes.tolerance)
    if prior is None:
        return table
    table = value_table_with_room(table, rows)
    scratch = make_scratch(classes)
    for shape in range(shapes):
        import_values(prior.table, table, classes, shape, scratch)
    return table


def no_reward(reward: FloatArray | None, agents: int) -> FloatArray:
    """Return the reward, or zeros that nothing reads where there is none (ours)."""
    return np.zeros(agents) if reward is None else reward


@kernel
def decide_sarsa(
    classes: Classes,
    table: ValueTable,
    owner: IntArray,
    state: IntArray,
    key_before: IntArray,
    key: IntArray,
    action_before: IntArray,
    action: IntArray,
    reward: FloatArray,
    draws: FloatArray,
    epsilon: float,
    learning_rate: float,
    discount: float,
    learns: bool,
    scratch: Scratch,
) -> None:
    """Choose the next actions of all agents and update Q of the last ones (paper, §IV-C).

    Parameters
    ----------
    classes, table
        Equivalence classes and Q-tables.
    owner: (agents,) int32
        Whose table an agent uses.
    state, key_before, key: (agents, orientations) int32
        Counts now, key at the last decision, key now (filled in place).
    action_before, action: (agents,) int32
        Last actions; next ones (filled in place).
    reward: (agents,) float64
    draws: (agents, 3) float64
    epsilon, learning_rate, discount: float
    learns: bool
        Whether there is a last action to learn from.
    scratch
        Working space.
    """
    for agent in range(owner.shape[0]):
        shape = classes.shape[agent]
        count = classes.phase_count[shape]
        embed(classes, state[agent], key[agent])
        row, variant = look_up(table.rows, classes, owner[agent], shape, key[agent], scratch)
        if row == ABSENT or explores(draws[agent], epsilon):
            # An unseen state takes a random action.
            action[agent] = uniform_action(draws[agent, 1], count)
        else:
            action[agent] = greedy_action(
                table.value[owner[agent], row],
                classes.phase_image[shape, variant],
                count,
                draws[agent, 2],
            )
        if not learns:
            continue
        following = 0.0
        if row != ABSENT:
            equivalent = classes.phase_image[shape, variant, action[agent]]
            following = table.value[owner[agent], row, equivalent]
        last = action_before[agent]
        row, variant = look_up(table.rows, classes, owner[agent], shape, key_before[agent], scratch)
        value = 0.0
        if row != ABSENT:
            value = table.value[owner[agent], row, classes.phase_image[shape, variant, last]]
        value += learning_rate * (reward[agent] + discount * following - value)
        write(table, classes, owner[agent], shape, key_before[agent], last, value, scratch)
