"""The central unit: agents of one shape send their memory and get back the average of all.

After a meeting all memories are equal, and until the next one each agent only appends rows, or
under a cap replaces some. So the leading rows that nobody has replaced since the last meeting carry
the same numbers everywhere and need no look-up: only those behind them are matched by class.
"""

from __future__ import annotations

import numpy as np

from dmil.compilation import allocating_kernel
from dmil.memory.admission import Admission, frequency, mark_of
from dmil.memory.rows import ABSENT, append, clear
from dmil.memory.tables import (
    BestTable,
    IntArray,
    Scratch,
    ValueTable,
    copy_best,
    copy_values,
    look_up_or_append,
)
from dmil.symmetry import Classes


@allocating_kernel
def average_values(
    table: ValueTable, classes: Classes, members: IntArray, common: int, scratch: Scratch
) -> None:
    """Merge tables of values: union of the classes, mean Q per class and action (paper, §IV-B).

    Parameters
    ----------
    table
        Memories of all agents, changed in place; room for all new rows of all members.
    classes
        The embedding.
    members: (members,) int32
        Agents that meet; all of one shape.
    common: int
        How many leading rows have the same keys for all members.
    scratch
        Working space.
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
            goal, variant = row, 0
            if row >= common and member != first:
                goal, variant = look_up_or_append(
                    table.rows, classes, first, shape, table.rows.keys[member, row], scratch
                )
            for action in range(actions):
                if table.tried[member, row, action]:
                    equivalent = classes.phase_image[shape, variant, action]
                    total[goal, equivalent] += table.value[member, row, action]
                    voters[goal, equivalent] += 1
    for row in range(table.rows.size[first]):
        for action in range(actions):
            voted = voters[row, action] > 0
            table.tried[first, row, action] = voted
            table.value[first, row, action] = (
                total[row, action] / voters[row, action] if voted else 0.0
            )
    for member in members[1:]:
        copy_values(table, first, member)


@allocating_kernel
def average_best(
    table: BestTable, classes: Classes, members: IntArray, common: int, scratch: Scratch
) -> None:
    """Merge long-term memories: mean Q per class and action, the best action kept (§6).

    Parameters are those of `average_values`.
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
            goal, variant = row, 0
            if row >= common and member != first:
                goal, variant = look_up_or_append(
                    table.rows, classes, first, shape, table.rows.keys[member, row], scratch
                )
            equivalent = classes.phase_image[shape, variant, table.action[member, row]]
            total[goal, equivalent] += table.value[member, row]
            voters[goal, equivalent] += 1
    for row in range(table.rows.size[first]):
        best = ABSENT
        for action in range(actions):
            if voters[row, action] > 0:
                mean = total[row, action] / voters[row, action]
                if best == ABSENT or mean > table.value[first, row]:
                    best = action
                    table.value[first, row] = mean
        table.action[first, row] = best
    for member in members[1:]:
        copy_best(table, first, member)


@allocating_kernel
def keep_most_frequent(
    table: BestTable, admission: Admission, classes: Classes, members: IntArray, scratch: Scratch
) -> None:
    """Cut what all members have in common down to the cap (ours).

    The classes stay that all members together met most often lately, of equals the older; each
    member goes on counting for itself.

    Parameters
    ----------
    table
        Memories of all agents, those of the members equal; changed in place.
    admission
        The cap, and how often each agent met which class.
    classes, members, scratch
        See `average_best`.
    """
    first = members[0]
    shape = classes.shape[first]
    size = table.rows.size[first]
    mark = np.zeros(size, np.int64)
    met = np.zeros(size, np.int64)
    for row in range(size):
        mark[row] = mark_of(
            classes, shape, table.rows.keys[first, row], table.rows.tolerance, scratch
        )
        for member in members:
            met[row] += frequency(admission, member, mark[row])
    kept = np.sort(np.argsort(-met, kind="mergesort")[: admission.capacity])
    if kept.size < size:
        keys = table.rows.keys[first, :size].copy()
        clear(table.rows, first)
        for row, old in enumerate(kept):
            append(table.rows, first, keys[old])
            table.action[first, row] = table.action[first, old]
            table.value[first, row] = table.value[first, old]
    for member in members:
        if member != first:
            copy_best(table, first, member)
        for row, old in enumerate(kept):
            admission.mark[member, row] = mark[old]
        admission.untouched[member] = admission.capacity
