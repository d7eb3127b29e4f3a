"""Dual memory: a short-term table of values beside a long-term one, and how both are read.

`dmil.memory.staging` writes it: the paper's Algorithms 1 and 2.
"""

from __future__ import annotations

from typing import NamedTuple

from dmil.arrays import IntArray, LongArray
from dmil.compilation import inlined_kernel, kernel
from dmil.memory.admission import NO_CAP, Admission
from dmil.memory.rows import ABSENT, find
from dmil.memory.tables import BestTable, Scratch, ValueTable, best_tried, look_up_nearest
from dmil.symmetry import Classes, vary


class DualMemory(NamedTuple):
    """Short-term and long-term memory of all owners, and the rules between them.

    Attributes
    ----------
    short: ValueTable
        Short-term memory; at most ``short_capacity`` rows per owner.
    long: BestTable
        Long-term memory.
    short_capacity: int
        m_s: the short-term memory stages when it holds this many rows.
    staged_ratio: float
        κ: the part of the rows that is staged.
    significance: float
        One Q is significantly better than another if it exceeds it by this part of its magnitude.
    stage_by_visits: bool
        Stage the rows most often written (the text) instead of those with the highest Q (the
        algorithm).
    stage_period: int
        T_stage: stage after this many writes instead of when full; 0 for the rule "when full".
    least_tried: int
        Actions of a class that must have been tried before short-term memory uses or stages the
        best of them.
    admission: Admission
        Cap on the long-term memory, and who may stay under it.
    """

    short: ValueTable
    long: BestTable
    short_capacity: int
    staged_ratio: float
    significance: float
    stage_by_visits: bool
    stage_period: int
    least_tried: int = 1
    admission: Admission = NO_CAP


@kernel
def significantly_better(value: float, than: float, significance: float) -> bool:
    """Tell whether a Q is significantly better: q > old + significance·|old| (§6)."""
    return value > than + significance * abs(than)


class Found(NamedTuple):
    """Where a key's class is in both memories: row (or `ABSENT`) and variant in each."""

    short_row: int
    short_variant: int
    long_row: int
    long_variant: int


@inlined_kernel
def find_both(
    memory: DualMemory, classes: Classes, owner: int, shape: int, key: IntArray, scratch: Scratch
) -> Found:
    """Look a key's class up in both memories; valid until either of them changes."""
    count = vary(classes, shape, key, scratch.variants)
    short_row, short_variant = find(memory.short.rows, owner, scratch.variants, count)
    long_row, long_variant = find(memory.long.rows, owner, scratch.variants, count)
    return Found(short_row, short_variant, long_row, long_variant)


@inlined_kernel
def find_again(
    memory: DualMemory,
    classes: Classes,
    owner: int,
    shape: int,
    key: IntArray,
    earlier: LongArray,
    scratch: Scratch,
) -> Found:
    """Return what `find_both` would: a memory whose keys are the same as then is not searched.

    Parameters
    ----------
    earlier: (6,) int64
        See `note_found`.
    """
    short_row, short_variant = earlier[0], earlier[1]
    long_row, long_variant = earlier[3], earlier[4]
    short, long = memory.short.rows, memory.long.rows
    short_changed = earlier[2] != short.changes[owner]
    long_changed = earlier[5] != long.changes[owner]
    if short_changed or long_changed:
        count = vary(classes, shape, key, scratch.variants)
        if short_changed:
            short_row, short_variant = find(short, owner, scratch.variants, count)
        if long_changed:
            long_row, long_variant = find(long, owner, scratch.variants, count)
    return Found(int(short_row), int(short_variant), int(long_row), int(long_variant))


@inlined_kernel
def note_found(found: Found, short_changes: int, long_changes: int, noted: LongArray) -> None:
    """Keep what was found for `find_again`.

    Parameters
    ----------
    short_changes, long_changes
        `Rows.changes` of both memories when it was looked up.
    noted: (6,) int64
        Row, variant and changes in short-term memory, then in long-term memory; filled in place.
    """
    noted[0], noted[1], noted[2] = found.short_row, found.short_variant, short_changes
    noted[3], noted[4], noted[5] = found.long_row, found.long_variant, long_changes


@kernel
def best_compared(memory: DualMemory, owner: int, row: int, count: int) -> int:
    """Return the best tried action of a short-term row, `ABSENT` if too few were tried."""
    tried = 0
    for action in range(count):
        tried += memory.short.tried[owner, row, action]
    return best_tried(memory.short, owner, row, count) if tried >= memory.least_tried else ABSENT


@inlined_kernel
def recall(memory: DualMemory, classes: Classes, owner: int, shape: int, found: Found) -> int:
    """Return the best action known for a key, −1 if its class is in neither memory.

    Long-term memory is read first; short-term memory wins if its Q is significantly better (paper,
    "Reading Dual-Memory"). The action is given back in the orientation of the key.
    """
    best, best_value = ABSENT, 0.0
    if found.long_row != ABSENT:
        action = memory.long.action[owner, found.long_row]
        best = classes.phase_preimage[shape, found.long_variant, action]
        best_value = memory.long.value[owner, found.long_row]
    if found.short_row != ABSENT:
        action = best_compared(memory, owner, found.short_row, classes.phase_count[shape])
        if action != ABSENT:
            value = memory.short.value[owner, found.short_row, action]
            if best == ABSENT or significantly_better(value, best_value, memory.significance):
                best = classes.phase_preimage[shape, found.short_variant, action]
    return best


@kernel
def recall_nearest(
    memory: DualMemory, classes: Classes, owner: int, shape: int, key: IntArray, scratch: Scratch
) -> int:
    """Return the action of the long-term row nearest to a key, −1 if there is none at all.

    For keys whose class is in neither memory; the action is given back in the key's orientation.
    """
    row, variant = look_up_nearest(memory.long.rows, classes, owner, shape, key, scratch)
    if row == ABSENT:
        return ABSENT
    return int(classes.phase_preimage[shape, variant, memory.long.action[owner, row]])


@inlined_kernel
def recalled_value(
    memory: DualMemory, classes: Classes, owner: int, shape: int, found: Found, action: int
) -> float:
    """Return Q of a key and an action (specification, §6).

    The short-term one if the action was tried there, else the long-term one if it is of that
    action, else 0.
    """
    value = 0.0
    if found.long_row != ABSENT:
        equivalent = classes.phase_image[shape, found.long_variant, action]
        if memory.long.action[owner, found.long_row] == equivalent:
            value = memory.long.value[owner, found.long_row]
    if found.short_row != ABSENT:
        equivalent = classes.phase_image[shape, found.short_variant, action]
        if memory.short.tried[owner, found.short_row, equivalent]:
            value = memory.short.value[owner, found.short_row, equivalent]
    return value
