"""Dual-memory integrated learning: the paper's memory-based agent (Algorithm 3)."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from dmil.arrays import Arrays, IntArray, LongArray
from dmil.compilation import TypedOnce, kernel
from dmil.controllers.parameters import parameters_of
from dmil.controllers.protocol import MemoryUse, RunContext
from dmil.controllers.tabular.agents import Agents, Prior, classes_of
from dmil.controllers.tabular.choice import explores, uniform_action, unseen_action
from dmil.controllers.tabular.learner import FIRST_CAPACITY, Step, TabularLearner
from dmil.controllers.tabular.meetings import CHANGE, ROWS, STAGED
from dmil.controllers.tabular.settings import DualMemorySettings
from dmil.memory import (
    ABSENT,
    Admission,
    BestTable,
    DualMemory,
    Merged,
    Scratch,
    ValueTable,
    admission_of,
    average_best,
    best_table_with_room,
    bests_of,
    bytes_used,
    find_again,
    find_both,
    give_best,
    give_short,
    import_best,
    keep_most_frequent,
    make_admission,
    make_best_table,
    make_scratch,
    make_value_table,
    merged_best,
    merged_values,
    message_bytes,
    note_found,
    pack,
    pack_admission,
    recall,
    recall_nearest,
    recalled_value,
    remark,
    remember,
    rows_in_common,
    unpack_admission,
    unpack_bests,
    unpack_values,
    value_table_with_room,
)
from dmil.memory.saved import named, part
from dmil.network import RoadNetwork
from dmil.symmetry import Classes, Embedding, embed


class DualMemoryController(TabularLearner):
    """One agent per intersection, each with a short-term and a long-term memory.

    Differs from the paper: nothing; see docs/paper.md for what it leaves open, such as which memory
    is sent to the central unit ("STM or LTM").

    Parameters
    ----------
    prior
        What the dummy agent of the training phase learned; the best part is the long-term memory
        to start from.
    """

    FOUND_IN = ("unseen", "short-term", "long-term", "both")
    settings: DualMemorySettings

    def __init__(
        self, settings: DualMemorySettings | None = None, *, prior: Prior | None = None
    ) -> None:
        super().__init__(settings or DualMemorySettings(), prior)
        self._memory: DualMemory | None = None
        self._decide = TypedOnce(decide_dual_memory)

    @property
    def memory(self) -> DualMemory:
        """The memories of all agents."""
        assert self._memory is not None, "reset comes before anything else"
        return self._memory

    def reset(self, context: RunContext) -> None:
        """Get ready for a run; see `TabularLearner.reset`."""
        super().reset(context)
        self._forget_found()

    def memory_use(self) -> MemoryUse:
        """Return how much is remembered now: 3·m_L + |A|·m_s per agent (paper, §V)."""
        short, long = self.memory.short, self.memory.long
        agents = self._phase_count.size
        short_total, long_total = int(short.rows.size.sum()), int(long.rows.size.sum())
        return MemoryUse(
            short_term_entries=short_total / agents,
            long_term_entries=long_total / agents,
            msize=(3 * long_total + int(short.rows.size.dot(self._phase_count))) / agents,
            entries_total=short_total
            + (self._stored_once(long.rows.size) if self._sends_long else long_total),
            bytes_total=bytes_used(short.rows, short[1:])
            + bytes_used(long.rows, long[1:])
            + sum(array.nbytes for array in self.memory.admission[:-1])
            + self._guard.bytes_total,
            messages=self._post.messages,
            exchanged_bytes=self._post.exchanged_bytes,
        )

    def arrays(self) -> Arrays:
        """Return both memories, and under a cap what was counted, as flat arrays."""
        packed = {
            **named("short", pack(self.memory.short)),
            **named("long", pack(self.memory.long)),
            **named("admission", pack_admission(self.memory.admission)),
        }
        return self._with_common(packed)

    def restore(self, arrays: Arrays) -> None:
        """Replace both memories.

        Raises
        ------
        PolicyError
            If the arrays are not those of memories of these agents.
        """
        packed, common = self._without_common(arrays)
        short = unpack_values(part("short", packed), self.memory.short)
        long = unpack_bests(part("long", packed), self.memory.long)
        self._check_common(common, long.rows)
        admission = unpack_admission(
            part("admission", packed), self.settings.long_capacity, long.rows.size
        )
        for agent, shape in enumerate(self.agents.shape if self.settings.long_capacity else ()):
            remark(long.rows, admission, self._classes, agent, shape, self._scratch)
        # The arrays may come from a short-term memory of another capacity than ours.
        short = value_table_with_room(short, self.settings.short_capacity)
        self._memory, self._common = self._with_rules(short, long, admission), common
        self._answers.clear()
        self._forget_found()

    def _forget_found(self) -> None:
        # Row, variant and changes in both memories; no memory has changed −1 times.
        self._found = np.full((self._phase_count.size, 6), -1, np.int64)

    def _start(self, network: RoadNetwork, agents: Agents) -> None:
        settings = self.settings
        start, admission = starting_bests(
            network,
            self._embedding,
            self._prior,
            settings.staged_ratio,
            settings.significance,
            settings.long_capacity,
        )
        self._common = start.rows.size.copy()
        short = make_value_table(
            agents.shape.size,
            settings.short_capacity,
            self._classes.movement_image.shape[2],
            self._classes.phase_image.shape[2],
            self._classes.tolerance,
            self._classes.parts,
        )
        long = bests_of(start, agents.shape, start.rows.keys.shape[1])
        self._memory = self._with_rules(short, long, admission_of(admission, agents.shape))

    def _with_rules(self, short: ValueTable, long: BestTable, admission: Admission) -> DualMemory:
        return parameters_of(
            DualMemory,
            self.settings,
            short=short,
            long=long,
            stage_by_visits=self.settings.staging == "visits",
            admission=admission,
        )

    def _take(self, step: Step) -> None:
        # One decision stages at most all that an agent's short-term memory can hold.
        self._make_room_to_stage(self.memory.short.value.shape[1])
        self._decide(self._classes, self.memory, step, self._found, self._scratch)
        if self.settings.long_capacity:
            # What one agent has replaced is common no more.
            for shape in range(len(self.agents.members)):
                self._forget_replaced(shape)

    def _make_room_to_stage(self, more: int) -> None:
        cap = self.settings.long_capacity
        self._make_room(min(more, cap - int(self.memory.long.rows.size.max())) if cap else more)

    def _make_room(self, more: int) -> None:
        long = best_table_with_room(self.memory.long, more)
        if long is not self.memory.long:
            self._memory = self.memory._replace(long=long)

    def _forget_replaced(self, shape: int) -> None:
        untouched = self.memory.admission.untouched[self.agents.members[shape]].min()
        self._common[shape] = min(self._common[shape], untouched)

    @property
    def _sends_long(self) -> bool:
        return self.settings.sent != "short"

    @property
    def _sends_short(self) -> bool:
        return self.settings.sent != "long"

    def _sent_bytes(self, members: IntArray) -> int:
        memory = self.memory
        total = message_bytes(memory.short, members) if self._sends_short else 0
        if self._sends_long:
            total += message_bytes(memory.long, members)
            if self.settings.long_capacity:
                total += memory.admission.counts[members].nbytes
        return total

    def _meet(self, shape: int) -> int:
        members, common = self.agents.members[shape], int(self._common[shape])
        merged = Merged(self._merged_short(members))
        answer_bytes = merged.size_bytes
        if self._sends_long:
            self._make_room(int((self.memory.long.rows.size[members] - common).sum()))
            long, admission = self.memory.long, self.memory.admission
            average_best(long, self._classes, members, common, self._scratch)
            if admission.capacity:
                keep_most_frequent(long, admission, self._classes, members, self._scratch)
            self._common[shape] = long.rows.size[members[0]]
            answer_bytes += message_bytes(long, members[:1])
        self._take_over(shape, merged, members)
        return answer_bytes

    def _merge(self, shape: int, heard: IntArray) -> Merged:
        long, admission = self.memory.long, self.memory.admission
        best = None
        if self._sends_long:
            common = int(self._common[shape])
            best = merged_best(long, self._classes, heard, common, self._scratch, admission)
        return Merged(self._merged_short(heard), best)

    def _merged_short(self, heard: IntArray) -> ValueTable | None:
        if not self._sends_short:
            return None
        return merged_values(self.memory.short, self._classes, heard, 0, self._scratch)

    def _take_over(self, shape: int, merged: Merged, reached: IntArray) -> None:
        given = self._classes, shape, reached, self._scratch
        if merged.best is not None:
            self._make_room_to_stage(int(merged.best.rows.size[0]))
            give_best(self.memory, merged.best, *given)
            members = self.agents.members[shape]
            self._common[shape] = rows_in_common(self.memory.long.rows, members)
            if self.settings.long_capacity:
                self.memory.admission.untouched[members] = self.settings.long_capacity
        if merged.values is not None:
            most = merged.values.rows.size[0] + self.memory.short.rows.size.max()
            self._make_room_to_stage(int(most))
            give_short(self.memory, merged.values, *given)
            if self.settings.long_capacity:
                self._forget_replaced(shape)


@lru_cache(maxsize=16)
def starting_bests(
    network: RoadNetwork,
    embedding: Embedding,
    prior: Prior | None,
    staged_ratio: float,
    significance: float,
    capacity: int,
) -> tuple[BestTable, Admission]:
    """Return long-term memories with shapes as owners, filled from an exact Q-table (ours).

    With what was counted for their cap. The result is shared by all agents that start from the same
    prior: copy it, never change it.
    """
    classes = classes_of(network, embedding)
    shapes, _, places = classes.movement_image.shape
    rows = 0 if prior is None else int(prior.table.rows.size.max())
    room = min(rows, capacity) if capacity else rows
    table = make_best_table(shapes, FIRST_CAPACITY + room, places, classes.tolerance, classes.parts)
    admission = make_admission(shapes, capacity)
    if prior is None:
        return table, admission
    scratch = make_scratch(classes)
    for shape in range(shapes):
        import_best(
            prior.table, table, classes, shape, staged_ratio, significance, scratch, admission
        )
    return table, admission


@kernel
def decide_dual_memory(
    classes: Classes, memory: DualMemory, step: Step, found_before: LongArray, scratch: Scratch
) -> None:
    """Choose the next actions of all agents and remember Q of the last ones (Algorithm 3).

    Parameters
    ----------
    found_before: (agents, 6) int64
        Where ``key_before`` was found, then where ``key`` was; see `dmil.memory.note_found`.
    """
    short_changes, long_changes = memory.short.rows.changes, memory.long.rows.changes
    for agent in range(step.state.shape[0]):
        shape = classes.shape[agent]
        key, key_before = step.key[agent], step.key_before[agent]
        draws = step.draws[agent]
        embed(classes, step.state[agent], key)
        found = find_both(memory, classes, agent, shape, key, scratch)
        found_with = short_changes[agent], long_changes[agent]
        step.found_in[(found.short_row != ABSENT) + 2 * (found.long_row != ABSENT)] += 1
        count = classes.phase_count[shape]
        if explores(draws, step.epsilon):
            action = uniform_action(draws[1], count)
        else:
            action = recall(memory, classes, agent, shape, found)
            if action == ABSENT and step.asks_nearest:
                action = recall_nearest(memory, classes, agent, shape, key, scratch)
            if action == ABSENT:
                action = unseen_action(step.fallback[agent], draws[1], count)
        step.action[agent] = action
        if not step.learns:
            note_found(found, found_with[0], found_with[1], found_before[agent])
            continue
        following = recalled_value(memory, classes, agent, shape, found, action)
        last = step.action_before[agent]
        again = find_again(memory, classes, agent, shape, key_before, found_before[agent], scratch)
        note_found(found, found_with[0], found_with[1], found_before[agent])
        before = recalled_value(memory, classes, agent, shape, again, last)
        error = step.reward[agent] + step.discount * following - before
        value = before + step.learning_rate * error
        remember(memory, classes, agent, shape, key_before, again, last, value, scratch)
        step.news[agent, ROWS] += again.short_row == ABSENT
        step.news[agent, CHANGE] += abs(value - before)
        # Staging is what empties short-term memory.
        step.news[agent, STAGED] += memory.short.rows.size[agent] == 0
