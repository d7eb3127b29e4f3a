"""Start a memory from the dummy agent's exact Q-table (paper, §VI-B)."""

from __future__ import annotations

import numpy as np

from dmil.compilation import allocating_kernel, kernel
from dmil.memory.dual import consolidate
from dmil.memory.rows import ABSENT
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


@allocating_kernel
def import_best(
    source: ValueTable,
    table: BestTable,
    classes: Classes,
    shape: int,
    staged_ratio: float,
    significance: float,
    scratch: Scratch,
) -> None:
    """Stage the ``staged_ratio`` part of an exact Q-table with the highest Q (specification, §7).

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
    """
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
            classes,
            shape,
            shape,
            scratch.key,
            best[row],
            merit[row],
            significance,
            scratch,
        )
