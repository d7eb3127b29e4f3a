"""How memories are written: insert and stage (Algorithm 1), consolidate (Algorithm 2).

And how they begin with the dummy agent's exact Q-table (§VI-B).
"""

from __future__ import annotations

import numpy as np

from dmil.arrays import IntArray
from dmil.compilation import allocating_kernel, inlined_kernel, kernel
from dmil.memory.admission import NO_CAP, Admission, admit, mark_of, record
from dmil.memory.dual import DualMemory, Found, best_compared, significantly_better
from dmil.memory.rows import ABSENT, append
from dmil.memory.tables import (
    BestTable,
    Scratch,
    ValueTable,
    best_tried,
    clear_values,
    forget_values,
    look_up,
    look_up_or_append,
    write_found,
)
from dmil.symmetry import Classes, embed


@inlined_kernel
def remember(
    memory: DualMemory,
    classes: Classes,
    owner: int,
    shape: int,
    key: IntArray,
    found: Found,
    action: int,
    value: float,
    scratch: Scratch,
) -> None:
    """Insert into short-term memory; stage if it is full (Algorithm 1)."""
    row, variant = found.short_row, found.short_variant
    write_found(memory.short, classes, owner, shape, key, row, variant, action, value)
    if memory.admission.capacity > 0:
        mark = mark_of(classes, shape, key, memory.long.rows.tolerance, scratch)
        record(memory.admission, owner, mark)
    stage_when_due(memory, classes, owner, shape, scratch)


@kernel
def take_in(
    memory: DualMemory,
    table: ValueTable,
    classes: Classes,
    owner: int,
    shape: int,
    scratch: Scratch,
) -> None:
    """Replace short-term memory by rows that enter as if learned now, oldest first (ours).

    So a table larger than short-term memory is staged part by part. A row counts as visited as
    often as the table says, once if it says never.

    Parameters
    ----------
    memory
        Memories of all owners; long-term memory has room for all rows of the table.
    table
        Table of one owner; no key is in the class of an older one.
    """
    short = memory.short
    clear_values(short, owner)
    for row in range(table.rows.size[0]):
        entered = append(short.rows, owner, table.rows.keys[0, row])
        for action in range(short.value.shape[2]):
            short.value[owner, entered, action] = table.value[0, row, action]
            short.tried[owner, entered, action] = table.tried[0, row, action]
        short.visits[owner, entered] = max(1, table.visits[0, row])
        stage_when_due(memory, classes, owner, shape, scratch)


@inlined_kernel
def stage_when_due(
    memory: DualMemory, classes: Classes, owner: int, shape: int, scratch: Scratch
) -> None:
    """Stage if short-term memory is full or its period is over.

    With a stage period the memory stages when the writes since the last staging reach it. The
    counts of visits add up to just those writes, because staging empties the memory.
    """
    size = memory.short.rows.size[owner]
    due = size >= memory.short_capacity
    if memory.stage_period > 0:
        writes = 0
        for row in range(size):
            writes += memory.short.visits[owner, row]
        due = due or writes >= memory.stage_period
    if due:
        stage(memory, classes, owner, shape, scratch)


@kernel
def stage(memory: DualMemory, classes: Classes, owner: int, shape: int, scratch: Scratch) -> None:
    """Move the best part of short-term memory to long-term memory and empty it (Algorithm 1)."""
    short = memory.short
    size = short.rows.size[owner]
    # 1e-9: κ·m_s in floats may exceed a whole number by a rounding error.
    wanted = int(-((-memory.staged_ratio * size + 1e-9) // 1))
    for _ in range(wanted):
        chosen, chosen_action, chosen_merit = ABSENT, ABSENT, 0.0
        for row in range(size):
            action = best_compared(memory, owner, row, classes.phase_count[shape])
            if action == ABSENT:
                continue
            merit = short.value[owner, row, action]
            if memory.stage_by_visits:
                merit = float(short.visits[owner, row])
            if chosen == ABSENT or merit > chosen_merit:
                chosen, chosen_action, chosen_merit = row, action, merit
        if chosen == ABSENT:
            break
        consolidate(
            memory.long,
            memory.admission,
            classes,
            owner,
            shape,
            short.rows.keys[owner, chosen],
            chosen_action,
            short.value[owner, chosen, chosen_action],
            memory.significance,
            scratch,
        )
        # A row without tried actions is not chosen again.
        forget_values(short, owner, chosen)
    clear_values(short, owner)


@kernel
def consolidate(
    long: BestTable,
    admission: Admission,
    classes: Classes,
    owner: int,
    shape: int,
    key: IntArray,
    action: int,
    value: float,
    significance: float,
    scratch: Scratch,
) -> None:
    """Insert one staged row into long-term memory (Algorithm 2).

    A new class is stored, if there is room or a less frequent one makes way; a known one is
    replaced only by a significantly better Q.
    """
    row, variant = look_up(long.rows, classes, owner, shape, key, scratch)
    if row == ABSENT:
        row = admit(long.rows, admission, classes, owner, shape, key, scratch)
        if row == ABSENT:
            return
        better = True
    else:
        better = significantly_better(value, long.value[owner, row], significance)
    if better:
        long.action[owner, row] = classes.phase_image[shape, variant, action]
        long.value[owner, row] = value


@kernel
def import_values(
    source: ValueTable, table: ValueTable, classes: Classes, shape: int, scratch: Scratch
) -> None:
    """Insert every row of an exact Q-table, in its order, into the table of the same shape.

    Where several states fall into one class, the later Q of an action replaces the earlier one, as
    Algorithm 1 does.

    Parameters
    ----------
    source
        Exact table; its keys are states, its owners shapes.
    table
        Table with shapes as owners and room for all rows of the source.
    classes
        The embedding of ``table``.
    """
    for origin in range(source.rows.size[shape]):
        embed(classes, source.rows.keys[shape, origin], scratch.key)
        row, variant = look_up_or_append(table.rows, classes, shape, shape, scratch.key, scratch)
        for action in range(classes.phase_count[shape]):
            if source.tried[shape, origin, action]:
                equivalent = classes.phase_image[shape, variant, action]
                table.value[shape, row, equivalent] = source.value[shape, origin, action]
                table.tried[shape, row, equivalent] = True
        table.visits[shape, row] += source.visits[shape, origin]


def import_best(
    source: ValueTable,
    table: BestTable,
    classes: Classes,
    shape: int,
    staged_ratio: float,
    significance: float,
    scratch: Scratch,
    admission: Admission = NO_CAP,
) -> None:
    """Stage the ``staged_ratio`` part of an exact Q-table with the highest Q (specification, §7).

    Under a cap all visits of the source are counted first, so that the most frequent of those that
    are staged stay.

    Parameters
    ----------
    source
        Exact table; its keys are states, its owners shapes.
    table
        Long-term memory with shapes as owners and room for the staged rows.
    classes
        The embedding of ``table``.
    staged_ratio, significance: float
        See `DualMemory`.
    """
    if admission.capacity:
        _record_all(source, table, admission, classes, shape, scratch)
    _consolidate_best(source, table, admission, classes, shape, staged_ratio, significance, scratch)


@kernel
def _record_all(
    source: ValueTable,
    table: BestTable,
    admission: Admission,
    classes: Classes,
    shape: int,
    scratch: Scratch,
) -> None:
    for row in range(source.rows.size[shape]):
        embed(classes, source.rows.keys[shape, row], scratch.key)
        mark = mark_of(classes, shape, scratch.key, table.rows.tolerance, scratch)
        for _ in range(source.visits[shape, row]):
            record(admission, shape, mark)


@allocating_kernel
def _consolidate_best(
    source: ValueTable,
    table: BestTable,
    admission: Admission,
    classes: Classes,
    shape: int,
    staged_ratio: float,
    significance: float,
    scratch: Scratch,
) -> None:
    size = source.rows.size[shape]
    count = classes.phase_count[shape]
    best = np.empty(size, np.int32)
    merit = np.empty(size)
    for row in range(size):
        best[row] = best_tried(source, shape, row, count)
        merit[row] = -np.inf if best[row] == ABSENT else source.value[shape, row, best[row]]
    wanted = int(-((-staged_ratio * size + 1e-9) // 1))
    order = np.argsort(-merit, kind="mergesort")
    for row in order[:wanted]:
        if best[row] == ABSENT:
            break
        embed(classes, source.rows.keys[shape, row], scratch.key)
        consolidate(
            table,
            admission,
            classes,
            shape,
            shape,
            scratch.key,
            best[row],
            merit[row],
            significance,
            scratch,
        )
