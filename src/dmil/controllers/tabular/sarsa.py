"""SARSA on equivalence classes: the paper's non-memory agent (§IV-C) for any embedding."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from dmil.arrays import Arrays, IntArray
from dmil.compilation import TypedOnce, kernel
from dmil.controllers.protocol import MemoryUse, RunContext
from dmil.controllers.tabular.agents import Agents, Prior, classes_of
from dmil.controllers.tabular.choice import explores, greedy_action, uniform_action, unseen_action
from dmil.controllers.tabular.learner import FIRST_CAPACITY, Step, TabularLearner
from dmil.controllers.tabular.meetings import CHANGE, ROWS
from dmil.controllers.tabular.settings import SarsaSettings
from dmil.memory import (
    ABSENT,
    Merged,
    Scratch,
    ValueTable,
    average_values,
    bytes_used,
    give_values,
    import_values,
    look_up,
    look_up_nearest,
    make_scratch,
    make_value_table,
    merged_values,
    message_bytes,
    pack,
    rows_in_common,
    unpack_values,
    value_table_with_room,
    values_of,
    write_found,
)
from dmil.network import RoadNetwork
from dmil.symmetry import Classes, Embedding, embed


class SarsaController(TabularLearner):
    """One SARSA agent per intersection, each with a Q-table over equivalence classes.

    Differs from the paper: nothing; what the paper leaves open (learning rate, unseen states, ties)
    is in the specification, §6, and in docs/paper.md.

    Parameters
    ----------
    prior
        What the dummy agent of the training phase learned, to start from.
    """

    FOUND_IN = ("unseen", "table")
    settings: SarsaSettings

    def __init__(
        self, settings: SarsaSettings | None = None, *, prior: Prior | None = None
    ) -> None:
        super().__init__(settings or SarsaSettings(), prior)
        self._table: ValueTable | None = None
        self._decide = TypedOnce(decide_sarsa)

    @property
    def table(self) -> ValueTable:
        """The Q-tables of all agents."""
        assert self._table is not None, "reset comes before anything else"
        return self._table

    def reset(self, context: RunContext) -> None:
        """Get ready for a run; see `TabularLearner.reset`."""
        super().reset(context)
        # Whose table an agent uses.
        shape = self.agents.shape
        self._owner = shape if self.settings.shared else np.arange(shape.size, dtype=np.int32)

    def memory_use(self) -> MemoryUse:
        """Return how much is remembered now: |A|·m_Q per agent (paper, §V)."""
        table, sizes = self.table, self.table.rows.size
        entries = sizes[self._owner]
        return MemoryUse(
            table_entries=int(entries.sum()) / entries.size,
            msize=int(entries.dot(self._phase_count)) / entries.size,
            entries_total=int(sizes.sum()) if self.settings.shared else self._stored_once(sizes),
            bytes_total=bytes_used(table.rows, table[1:]) + self._guard.bytes_total,
            messages=self._post.messages,
            exchanged_bytes=self._post.exchanged_bytes,
        )

    def arrays(self) -> Arrays:
        """Return the Q-tables as flat arrays."""
        return self._with_common(pack(self.table))

    def restore(self, arrays: Arrays) -> None:
        """Replace the Q-tables.

        Raises
        ------
        PolicyError
            If the arrays are not those of Q-tables of these agents.
        """
        packed, common = self._without_common(arrays)
        table = unpack_values(packed, self.table)
        if not self.settings.shared:
            self._check_common(common, table.rows)
        self._table, self._common = table, common
        self._answers.clear()

    def _fits(self, known: Agents, agents: Agents) -> bool:
        # Tables that agents of one shape share do not depend on how many agents there are.
        return (
            known.signatures == agents.signatures
            if self.settings.shared
            else super()._fits(known, agents)
        )

    def _start(self, network: RoadNetwork, agents: Agents) -> None:
        start = starting_values(network, self._embedding, self._prior)
        capacity = start.rows.keys.shape[1]
        self._common = start.rows.size.copy()
        shapes = np.arange(len(agents.signatures), dtype=np.int32)
        owners = shapes if self.settings.shared else agents.shape
        self._table = values_of(start, owners, capacity)

    def _take(self, step: Step) -> None:
        # One decision appends at most one row per agent, all of them to one table if it is shared.
        agents = self.agents.shape.size
        self._table = value_table_with_room(self.table, agents if self.settings.shared else 1)
        self._decide(self._classes, self._table, self._owner, step, self._scratch)

    @property
    def _communicates(self) -> bool:
        # Who shares a table has nothing to tell another.
        return super()._communicates and not self.settings.shared

    def _sent_bytes(self, members: IntArray) -> int:
        return message_bytes(self.table, members)

    def _meet(self, shape: int) -> int:
        members, common = self.agents.members[shape], int(self._common[shape])
        more = int((self.table.rows.size[members] - common).sum())
        self._table = table = value_table_with_room(self.table, more)
        average_values(table, self._classes, members, common, self._scratch)
        self._common[shape] = table.rows.size[members[0]]
        return message_bytes(table, members[:1])

    def _merge(self, shape: int, heard: IntArray) -> Merged:
        common = int(self._common[shape])
        return Merged(merged_values(self.table, self._classes, heard, common, self._scratch))

    def _take_over(self, shape: int, merged: Merged, reached: IntArray) -> None:
        assert merged.values is not None, "tables of values are what was sent"
        self._table = table = value_table_with_room(self.table, int(merged.values.rows.size[0]))
        give_values(table, merged.values, self._classes, shape, reached, self._scratch)
        self._common[shape] = rows_in_common(table.rows, self.agents.members[shape])


@lru_cache(maxsize=16)
def starting_values(network: RoadNetwork, embedding: Embedding, prior: Prior | None) -> ValueTable:
    """Return tables with shapes as owners, filled from an exact Q-table if there is one (ours).

    The result is shared by all agents that start from the same prior: copy it, never change it.
    """
    classes = classes_of(network, embedding)
    shapes, _, places = classes.movement_image.shape
    actions = classes.phase_image.shape[2]
    rows = 0 if prior is None else int(prior.table.rows.size.max())
    table = make_value_table(
        shapes, FIRST_CAPACITY + rows, places, actions, classes.tolerance, classes.parts
    )
    if prior is None:
        return table
    scratch = make_scratch(classes)
    for shape in range(shapes):
        import_values(prior.table, table, classes, shape, scratch)
    return table


@kernel
def decide_sarsa(
    classes: Classes, table: ValueTable, owner: IntArray, step: Step, scratch: Scratch
) -> None:
    """Choose the next actions of all agents and update Q of the last ones (paper, §IV-C).

    Agents decide one after the other, in the order of the network: with a shared table each sees
    what those before it have just learned.

    Parameters
    ----------
    owner: (agents,) int32
        Whose table an agent uses.
    """
    for agent in range(owner.shape[0]):
        mine, shape = owner[agent], classes.shape[agent]
        key, key_before = step.key[agent], step.key_before[agent]
        draws = step.draws[agent]
        embed(classes, step.state[agent], key)
        row, variant = look_up(table.rows, classes, mine, shape, key, scratch)
        step.found_in[0 if row == ABSENT else 1] += 1
        count, image = classes.phase_count[shape], classes.phase_image[shape, variant]
        if explores(draws, step.epsilon):
            action = uniform_action(draws[1], count)
        elif row == ABSENT:
            near, turn = ABSENT, 0
            if step.asks_nearest:
                near, turn = look_up_nearest(table.rows, classes, mine, shape, key, scratch)
            if near == ABSENT:
                action = unseen_action(step.fallback[agent], draws[1], count)
            else:
                turned = classes.phase_image[shape, turn]
                action = greedy_action(table.value[mine, near], turned, count, draws[2])
        else:
            action = greedy_action(table.value[mine, row], image, count, draws[2])
        step.action[agent] = action
        if not step.learns:
            continue
        following = table.value[mine, row, image[action]] if row != ABSENT else 0.0
        last = step.action_before[agent]
        row, variant = look_up(table.rows, classes, mine, shape, key_before, scratch)
        value = 0.0
        if row != ABSENT:
            value = table.value[mine, row, classes.phase_image[shape, variant, last]]
        else:
            step.news[agent, ROWS] += 1.0
        before = value
        value += step.learning_rate * (step.reward[agent] + step.discount * following - value)
        step.news[agent, CHANGE] += abs(value - before)
        write_found(table, classes, mine, shape, key_before, row, variant, last, value)
