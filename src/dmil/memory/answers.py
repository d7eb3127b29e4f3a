"""What the central unit answers where messages are late or lost, and how it is taken over (ours).

The answer is a merge in tables of its own. Whoever it reaches puts it in the place of its memory,
and behind it what the answer lacks: what was stored since, or what never arrived.
"""

from __future__ import annotations

from math import prod
from typing import NamedTuple

import numpy as np

from dmil.arrays import IntArray
from dmil.compilation import kernel
from dmil.memory.admission import NO_CAP, Admission, admit, mark_of
from dmil.memory.central import cut_to_cap, merge_best, merge_values
from dmil.memory.dual import DualMemory
from dmil.memory.rows import ABSENT, Rows, append, clear
from dmil.memory.staging import take_in
from dmil.memory.tables import (
    BestTable,
    Scratch,
    ValueTable,
    bests_of,
    clear_values,
    columns_of,
    look_up,
    make_value_table,
    values_of,
)
from dmil.symmetry import Classes

NOT_SENT = "visits"
"""The column of a table that is none of a message: visits stay each agent's own."""
ALONE = np.zeros(1, np.int32)
"""The owner of a table of one owner."""


class Merged(NamedTuple):
    """The central unit's answer: tables of one owner.

    Attributes
    ----------
    values: ValueTable or None
        Q-table or short-term memory; None if these are not sent.
    best: BestTable or None
        Long-term memory; None if these are not sent.
    """

    values: ValueTable | None = None
    best: BestTable | None = None

    @property
    def size_bytes(self) -> int:
        """Bytes of the message to one agent."""
        return sum(message_bytes(table, ALONE) for table in self if table is not None)


def rows_in_common(rows: Rows, members: IntArray) -> int:
    """Return how many leading rows of all members have the same keys (ours).

    Parameters
    ----------
    members: (members,) int32
    """
    least = int(rows.size[members].min())
    keys = rows.keys[members, :least]
    same = (keys == keys[:1]).all(axis=(0, 2))
    return least if same.all() else int(same.argmin())


def message_bytes(table: ValueTable | BestTable, owners: IntArray) -> int:
    """Return the bytes of the rows that some owners send, all together (ours).

    Of a table of values these are keys, Q of all actions and which were tried; of long-term memory
    keys, actions and Q. Of a key with several parts the first is sent: the others follow from it.

    Parameters
    ----------
    owners: (owners,) int
    """
    keys = table.rows.keys
    columns = [array for name, array in columns_of(table).items() if name != NOT_SENT]
    row_bytes: int = keys.itemsize * keys.shape[2] // table.rows.parts
    row_bytes += sum(array.itemsize * prod(array.shape[2:]) for array in columns)
    return int(table.rows.size[owners].sum()) * row_bytes


def merged_values(
    table: ValueTable, classes: Classes, heard: IntArray, common: int, scratch: Scratch
) -> ValueTable:
    """Return what `merge_values` makes of the tables of some agents, and leave these as they are.

    Parameters
    ----------
    heard: (agents,) int32
        Whose memories arrived; at least one.
    common: int
        How many leading rows have the same keys for all of them.
    """
    goal = values_of(table, heard[:1], _room(table.rows, heard, common))
    merge_values(table, classes, heard, common, goal, 0, scratch)
    return goal


def merged_best(
    table: BestTable,
    classes: Classes,
    heard: IntArray,
    common: int,
    scratch: Scratch,
    admission: Admission = NO_CAP,
) -> BestTable:
    """Do for long-term memories what `merged_values` does; a cap cuts the merge (ours)."""
    goal = bests_of(table, heard[:1], _room(table.rows, heard, common))
    merge_best(table, classes, heard, common, goal, 0, scratch)
    if admission.capacity:
        cut_to_cap(goal, 0, admission, classes, heard, scratch)
    return goal


def _room(rows: Rows, heard: IntArray, common: int) -> int:
    return max(int(rows.size.max()), common + int((rows.size[heard] - common).sum()))


def give_values(
    table: ValueTable,
    merged: ValueTable,
    classes: Classes,
    shape: int,
    reached: IntArray,
    scratch: Scratch,
) -> None:
    """Let some agents take a merged table over; see `take_over_values`.

    Parameters
    ----------
    table
        Memories of all agents; room for the rows of the merged one beside the most of an agent.
    merged
        Table of one owner.
    reached: (agents,) int32
        Whom it reached; all of one shape.
    """
    for agent in reached:
        mine = values_of(table, np.array([agent]), int(table.rows.size.max()))
        take_over_values(table, agent, mine, merged, classes, shape, scratch)


def give_best(
    memory: DualMemory,
    merged: BestTable,
    classes: Classes,
    shape: int,
    reached: IntArray,
    scratch: Scratch,
) -> None:
    """Let some agents take a merged long-term memory over; see `give_values`."""
    long = memory.long
    for agent in reached:
        mine = bests_of(long, np.array([agent]), int(long.rows.size.max()))
        take_over_best(long, agent, mine, merged, memory.admission, classes, shape, scratch)


def give_short(
    memory: DualMemory,
    merged: ValueTable,
    classes: Classes,
    shape: int,
    reached: IntArray,
    scratch: Scratch,
) -> None:
    """Let a merged short-term memory, and what it lacks, enter that of some agents (ours).

    Rows enter as if they were learned now, oldest first, so that short-term memory stages whenever
    it is full: agents that had sent all they have end up with the same one. Parameters are those
    of `give_values`; long-term memory has room for the rows of both tables.
    """
    short = memory.short
    most = int(merged.rows.size[0] + short.rows.size.max())
    for agent in reached:
        mine = values_of(short, np.array([agent]), int(short.rows.size.max()))
        rows = short.rows
        places, actions = rows.keys.shape[2], short.value.shape[2]
        both = make_value_table(1, most, places, actions, rows.tolerance, rows.parts)
        take_over_values(both, 0, mine, merged, classes, shape, scratch)
        take_in(memory, both, classes, agent, shape, scratch)


@kernel
def take_over_values(
    table: ValueTable,
    owner: int,
    mine: ValueTable,
    answer: ValueTable,
    classes: Classes,
    shape: int,
    scratch: Scratch,
) -> None:
    """Make a table the central unit's answer, and behind it what the answer lacks (ours).

    Of a class that the answer has nothing stays but the number of visits: leading rows carry the
    same numbers for all whom it reaches.

    Parameters
    ----------
    table, owner
        What is replaced; room for all rows of both.
    mine, answer
        Tables of one owner: what ``owner`` had until now, and what the central unit sent.
    """
    clear_values(table, owner)
    for row in range(answer.rows.size[0]):
        append(table.rows, owner, answer.rows.keys[0, row])
        for action in range(table.value.shape[2]):
            table.value[owner, row, action] = answer.value[0, row, action]
            table.tried[owner, row, action] = answer.tried[0, row, action]
    for row in range(mine.rows.size[0]):
        key = mine.rows.keys[0, row]
        place = look_up(answer.rows, classes, 0, shape, key, scratch)[0]
        if place == ABSENT:
            place = append(table.rows, owner, key)
            for action in range(table.value.shape[2]):
                table.value[owner, place, action] = mine.value[0, row, action]
                table.tried[owner, place, action] = mine.tried[0, row, action]
        table.visits[owner, place] += mine.visits[0, row]


@kernel
def take_over_best(
    table: BestTable,
    owner: int,
    mine: BestTable,
    answer: BestTable,
    admission: Admission,
    classes: Classes,
    shape: int,
    scratch: Scratch,
) -> None:
    """Do for a long-term memory what `take_over_values` does for a table of values (ours).

    A class that the answer has gets its action and Q. Under a cap what it lacks is admitted as if
    it were staged.
    """
    clear(table.rows, owner)
    for row in range(answer.rows.size[0]):
        key = answer.rows.keys[0, row]
        append(table.rows, owner, key)
        table.action[owner, row] = answer.action[0, row]
        table.value[owner, row] = answer.value[0, row]
        if admission.capacity > 0:
            mark = mark_of(classes, shape, key, table.rows.tolerance, scratch)
            admission.mark[owner, row] = mark
    for row in range(mine.rows.size[0]):
        key = mine.rows.keys[0, row]
        if look_up(answer.rows, classes, 0, shape, key, scratch)[0] == ABSENT:
            place = admit(table.rows, admission, classes, owner, shape, key, scratch)
            if place != ABSENT:
                table.action[owner, place] = mine.action[0, row]
                table.value[owner, place] = mine.value[0, row]
