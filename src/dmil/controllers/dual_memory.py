"""Dual-memory integrated learning: the paper's memory-based agent (Algorithm 4)."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from dmil.compilation import kernel
from dmil.controllers.agents import agents_of, classes_of
from dmil.controllers.choice import DRAWS, explores, uniform_action
from dmil.controllers.meetings import Meetings
from dmil.controllers.prior import Prior
from dmil.controllers.protocol import Arrays, FloatArray, IntArray, MemoryUse, Situation
from dmil.controllers.sarsa import FIRST_CAPACITY, no_reward
from dmil.controllers.settings import DualMemorySettings
from dmil.memory import (
    ABSENT,
    BestTable,
    DualMemory,
    Scratch,
    ValueTable,
    average_best,
    best_table_with_room,
    bests_of,
    bytes_used,
    import_best,
    make_best_table,
    make_scratch,
    make_value_table,
    pack,
    recall,
    recalled_value,
    remember,
    unpack_bests,
    unpack_values,
    value_table_with_room,
)
from dmil.network import RoadNetwork
from dmil.simulation import Observation
from dmil.symmetry import Classes, Embedding, embed, embedding


class DualMemoryController:
    """One agent per intersection, each with a short-term and a long-term memory.

    Differs from the paper: only long-term memories are sent to the central unit ("STM or LTM" in
    the paper); see docs/paper.md for what the paper leaves open.

    Parameters
    ----------
    settings
        See `DualMemorySettings`.
    prior
        What the dummy agent of the training phase learned; the best part is the long-term memory
        to start from.
    """

    def __init__(
        self, settings: DualMemorySettings | None = None, *, prior: Prior | None = None
    ) -> None:
        self.settings = settings or DualMemorySettings()
        self._embedding = embedding(self.settings.embedding)
        self._prior = prior
        self._memory: DualMemory | None = None

    def begin(self, situation: Situation) -> None:
        """Get ready for a run; a memory from an earlier run on the same shapes stays."""
        network = situation.network
        self._rng, self._epsilon = situation.rng, self.settings.epsilon
        self._meetings = Meetings(self.settings)
        self._agents = agents_of(network)
        self._classes = classes_of(network, self._embedding)
        self._scratch = make_scratch(self._classes)
        count, places = len(network.intersections), self._classes.orientation_image.shape[2]
        if self._memory is None:
            start = starting_bests(
                network,
                self._embedding,
                self._prior,
                self.settings.staged_ratio,
                self.settings.significance,
            )
            self._common = start.rows.size.copy()
            self._memory = self._with_rules(
                self._empty_short(count), bests_of(start, self._agents.shape)
            )
        self._key, self._key_before = np.zeros((2, count, places), np.int32)
        self._action = np.full(count, ABSENT, np.int32)

    def decide(self, observation: Observation, reward: FloatArray | None) -> IntArray:
        """Choose ε-greedily, insert the new Q of the last choice, trigger the central unit."""
        settings = self.settings
        action = np.empty_like(self._action)
        self._make_room(settings.short_capacity)
        decide_dual_memory(
            self._classes,
            self.memory,
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
    def memory(self) -> DualMemory:
        """The memories of all agents."""
        assert self._memory is not None, "begin comes before anything else"
        return self._memory

    def memory_use(self) -> MemoryUse:
        """Return how much is remembered now: 3·m_L + |A|·m_s per agent (paper, §V)."""
        short, long = self.memory.short, self.memory.long
        actions = self._classes.phase_count[self._agents.shape]
        return MemoryUse(
            short_term_entries=float(short.rows.size.mean()),
            long_term_entries=float(long.rows.size.mean()),
            table_entries=0.0,
            msize=float((3 * long.rows.size + actions * short.rows.size).mean()),
            entries_total=int(short.rows.size.sum() + long.rows.size.sum()),
            bytes_total=bytes_used(short.rows, short[1:]) + bytes_used(long.rows, long[1:]),
        )

    def arrays(self) -> Arrays:
        """Return both memories as flat arrays."""
        parts = {"short": pack(self.memory.short), "long": pack(self.memory.long)}
        return {
            f"{part}.{name}": array
            for part, arrays in parts.items()
            for name, array in arrays.items()
        }

    def restore(self, arrays: Arrays) -> None:
        """Replace both memories."""
        tolerance = self._embedding.tolerance

        def part(name: str) -> Arrays:
            return {
                key.removeprefix(f"{name}."): value
                for key, value in arrays.items()
                if key.startswith(f"{name}.")
            }

        short = value_table_with_room(
            unpack_values(part("short"), tolerance), self.settings.short_capacity
        )
        self._memory = self._with_rules(short, unpack_bests(part("long"), tolerance))
        self._common = np.zeros_like(self._common)

    def _with_rules(self, short: ValueTable, long: BestTable) -> DualMemory:
        settings = self.settings
        return DualMemory(
            short=short,
            long=long,
            short_capacity=settings.short_capacity,
            staged_ratio=settings.staged_ratio,
            significance=settings.significance,
            stage_by_visits=settings.staging == "visits",
            stage_period=settings.stage_period,
        )

    def _empty_short(self, agents: int) -> ValueTable:
        _, _, places = self._classes.orientation_image.shape
        actions, capacity = self._classes.phase_image.shape[2], self.settings.short_capacity
        tolerance = self._classes.tolerance
        return value_table_with_room(
            make_value_table(agents, capacity, places, actions, tolerance), capacity
        )

    def _make_room(self, more: int) -> None:
        long = best_table_with_room(self.memory.long, more)
        if long is not self.memory.long:
            self._memory = self.memory._replace(long=long)

    def _communicate(self) -> None:
        for shape, members in enumerate(self._agents.members):
            if members.size < 2:
                continue
            common = int(self._common[shape])
            self._make_room(int((self.memory.long.rows.size[members] - common).sum()))
            average_best(self.memory.long, self._classes, members, common, self._scratch)
            self._common[shape] = self.memory.long.rows.size[members[0]]


@lru_cache(maxsize=16)
def starting_bests(
    network: RoadNetwork,
    embedding: Embedding,
    prior: Prior | None,
    staged_ratio: float,
    significance: float,
) -> BestTable:
    """Return long-term memories with shapes as owners, filled from an exact Q-table (ours).

    The result is shared by all agents that start from the same prior: copy it, never change it.
    """
    classes = classes_of(network, embedding)
    shapes, _, places = classes.orientation_image.shape
    rows = 0 if prior is None else int(prior.table.rows.size.max())
    table = make_best_table(shapes, FIRST_CAPACITY + rows, places, classes.tolerance)
    if prior is None:
        return table
    table = best_table_with_room(table, rows)
    scratch = make_scratch(classes)
    for shape in range(shapes):
        import_best(prior.table, table, classes, shape, staged_ratio, significance, scratch)
    return table


@kernel
def decide_dual_memory(
    classes: Classes,
    memory: DualMemory,
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
    """Choose the next actions of all agents and remember Q of the last ones (Algorithm 4).

    Parameters are those of `dmil.controllers.sarsa.decide_sarsa`, with a dual memory per agent.
    """
    for agent in range(state.shape[0]):
        shape = classes.shape[agent]
        count = classes.phase_count[shape]
        embed(classes, state[agent], key[agent])
        best = ABSENT
        if not explores(draws[agent], epsilon):
            best = recall(memory, classes, agent, shape, key[agent], scratch)
        if best == ABSENT:
            best = uniform_action(draws[agent, 1], count)
        action[agent] = best
        if not learns:
            continue
        following = recalled_value(memory, classes, agent, shape, key[agent], best, scratch)
        last = action_before[agent]
        value = recalled_value(memory, classes, agent, shape, key_before[agent], last, scratch)
        value += learning_rate * (reward[agent] + discount * following - value)
        remember(memory, classes, agent, shape, key_before[agent], last, value, scratch)
