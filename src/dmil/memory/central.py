"""The central unit: agents of one shape send their memory and get back the average of all.

After a meeting all memories are equal, and until the next one each agent only appends rows, or
under a cap replaces some. So the leading rows that nobody has replaced since the last meeting carry
the same numbers everywhere and need no look-up: only those behind them are matched by class.

Where all messages arrive at once the merge is made in place. `dmil.memory.answers` makes it where
some are lost or late.
"""

from __future__ import annotations

import numpy as np

from dmil.arrays import IntArray
from dmil.compilation import allocating_kernel
from dmil.memory.admission import Admission, frequency, mark_of
from dmil.memory.rows import ABSENT, append, clear
from dmil.memory.tables import (
    BestTable,
    Scratch,
    ValueTable,
    copy_best,
    copy_values,
    look_up_or_append,
)
from dmil.symmetry import Classes


@allocating_kernel
def merge_values(
    table: ValueTable,
    classes: Classes,
    members: IntArray,
    common: int,
    goal: ValueTable,
    owner: int,
    scratch: Scratch,
) -> None:
    """Merge tables of values: union of the classes, mean Q per class and action (paper, §IV-B).

    Parameters
    ----------
    members: (members,) int32
        Agents whose memories are merged; all of one shape.
    common: int
        How many leading rows have the same keys for all members.
    goal, owner
        Where the union is made: a table, maybe the same one, in which this owner has the rows of
        the first member, with room for the new rows of the others.
    """
    first = members[0]
    shape = classes.shape[first]
    actions = table.value.shape[2]
    most = common
    for member in members:
        most += table.rows.size[member] - common
    total = np.zeros((most, actions))
    voters = np.zeros((most, actions), np.int32)
    for member in members:
        for row in range(table.rows.size[member]):
            place, variant = row, 0
            if row >= common and member != first:
                place, variant = look_up_or_append(
                    goal.rows, classes, owner, shape, table.rows.keys[member, row], scratch
                )
            for action in range(actions):
                if table.tried[member, row, action]:
                    equivalent = classes.phase_image[shape, variant, action]
                    total[place, equivalent] += table.value[member, row, action]
                    voters[place, equivalent] += 1
    for row in range(goal.rows.size[owner]):
        for action in range(actions):
            voted = voters[row, action] > 0
            goal.tried[owner, row, action] = voted
            goal.value[owner, row, action] = (
                total[row, action] / voters[row, action] if voted else 0.0
            )


@allocating_kernel
def average_values(
    table: ValueTable, classes: Classes, members: IntArray, common: int, scratch: Scratch
) -> None:
    """Give all members the merged table; see `merge_values`."""
    first = members[0]
    merge_values(table, classes, members, common, table, first, scratch)
    for member in members[1:]:
        copy_values(table, first, member)


@allocating_kernel
def merge_best(
    table: BestTable,
    classes: Classes,
    members: IntArray,
    common: int,
    goal: BestTable,
    owner: int,
    scratch: Scratch,
) -> None:
    """Merge long-term memories: mean Q per class and action, the best action kept (§6).

    Parameters are those of `merge_values`.
    """
    first = members[0]
    shape = classes.shape[first]
    actions = classes.phase_count[shape]
    most = common
    for member in members:
        most += table.rows.size[member] - common
    total = np.zeros((most, actions))
    voters = np.zeros((most, actions), np.int32)
    for member in members:
        for row in range(table.rows.size[member]):
            place, variant = row, 0
            if row >= common and member != first:
                place, variant = look_up_or_append(
                    goal.rows, classes, owner, shape, table.rows.keys[member, row], scratch
                )
            equivalent = classes.phase_image[shape, variant, table.action[member, row]]
            total[place, equivalent] += table.value[member, row]
            voters[place, equivalent] += 1
    for row in range(goal.rows.size[owner]):
        best = ABSENT
        for action in range(actions):
            if voters[row, action] > 0:
                mean = total[row, action] / voters[row, action]
                if best == ABSENT or mean > goal.value[owner, row]:
                    best = action
                    goal.value[owner, row] = mean
        goal.action[owner, row] = best


@allocating_kernel
def average_best(
    table: BestTable, classes: Classes, members: IntArray, common: int, scratch: Scratch
) -> None:
    """Give all members the merged long-term memory; see `merge_best`."""
    first = members[0]
    merge_best(table, classes, members, common, table, first, scratch)
    for member in members[1:]:
        copy_best(table, first, member)


@allocating_kernel
def cut_to_cap(
    table: BestTable,
    owner: int,
    admission: Admission,
    classes: Classes,
    members: IntArray,
    scratch: Scratch,
) -> None:
    """Cut a merged long-term memory down to the cap (ours).

    The classes stay that all members together met most often lately, of equals the older.

    Parameters
    ----------
    table, owner
        Whose rows are cut, in place.
    admission
        The cap, and how often each agent met which class.
    """
    shape = classes.shape[members[0]]
    size = table.rows.size[owner]
    met = np.zeros(size, np.int64)
    for row in range(size):
        key = table.rows.keys[owner, row]
        mark = mark_of(classes, shape, key, table.rows.tolerance, scratch)
        for member in members:
            met[row] += frequency(admission, member, mark)
    kept = np.sort(np.argsort(-met, kind="mergesort")[: admission.capacity])
    if kept.size < size:
        keys = table.rows.keys[owner, :size].copy()
        clear(table.rows, owner)
        for row, old in enumerate(kept):
            append(table.rows, owner, keys[old])
            table.action[owner, row] = table.action[owner, old]
            table.value[owner, row] = table.value[owner, old]


@allocating_kernel
def keep_most_frequent(
    table: BestTable, admission: Admission, classes: Classes, members: IntArray, scratch: Scratch
) -> None:
    """Cut what all members have in common down to the cap (ours).

    Each member goes on counting for itself.

    Parameters
    ----------
    table
        Memories of all agents, those of the members equal; changed in place.
    admission, classes, members, scratch
        See `cut_to_cap`.
    """
    first = members[0]
    shape = classes.shape[first]
    cut_to_cap(table, first, admission, classes, members, scratch)
    for member in members[1:]:
        copy_best(table, first, member)
    for row in range(table.rows.size[first]):
        key = table.rows.keys[first, row]
        mark = mark_of(classes, shape, key, table.rows.tolerance, scratch)
        for member in members:
            admission.mark[member, row] = mark
    for member in members:
        admission.untouched[member] = admission.capacity
