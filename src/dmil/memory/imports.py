"""Start a memory from the dummy agent's exact Q-table (paper, §VI-B)."""

from __future__ import annotations

import numpy as np

from dmil.compilation import allocating_kernel, kernel
from dmil.memory.admission import NO_CAP, Admission, mark_of, record
from dmil.memory.rows import ABSENT
from dmil.memory.staging import consolidate
from dmil.memory.tables import BestTable, Scratch, ValueTable, best_tried, look_up_or_append
from dmil.symmetry import Classes, embed


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
    shape: int
    scratch
        Working space.
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
    shape: int
    staged_ratio, significance: float
        See `DualMemory`.
    scratch
        Working space.
    admission
        Cap on the table.
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
