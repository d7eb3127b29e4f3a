"""The central unit: agents of one shape send their memory and get back the average of all.

After a meeting all memories are equal, and until the next one each agent only appends rows. So the
rows known at the last meeting carry the same numbers everywhere and need no look-up: only rows
that are new since are matched by class.
"""

from __future__ import annotations

import numpy as np

from dmil.compilation import allocating_kernel
from dmil.memory.rows import ABSENT
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
