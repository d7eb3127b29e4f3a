"""Who may stay in a full long-term memory: those who come more often (TinyLFU).

After Einziger, Friedman and Manes, "TinyLFU: A Highly Efficient Cache Admission Policy", ACM
Transactions on Storage 13 (2017). A count-min sketch says how often every class was met lately,
stored or not: `DEPTH` counters per class, of 4 bits, two in a byte, only the least of them counted
up ("minimal increment"), all halved after `SAMPLE` counts per row of the cap. A class that is not
stored takes the place of the least frequent row, if it is more frequent than that.

What of the paper's W-TinyLFU is not here, and why:

- the window, which gives a new key time to be counted before it has to compete: every class has
  been through short-term memory before, counted at each visit, so short-term memory is the window;
- the segmented main cache, which guesses in constant time which row is used least: there are few
  rows, and they compete only when something is staged, so that all are asked;
- the doorkeeper, which keeps keys met once out of the counters: these are half a byte each.

With a tolerance, or symmetries, a class is met under many keys. All keys of one cell (as wide as
the tolerance reaches) and their symmetric images are counted as one.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dmil.arrays import ByteArray, IntArray, LongArray
from dmil.compilation import kernel
from dmil.memory.rows import ABSENT, Rows, append, replace
from dmil.memory.tables import Scratch
from dmil.symmetry import Classes, vary

DEPTH = 4
"""Counters of a class; the least of them is its frequency."""
HIGHEST = 15
"""Where a counter of 4 bits stops."""
COUNTERS_PER_ROW = 4
"""Counters for each row of the cap, at least, in each of the `DEPTH` rows of the sketch."""
LEAST_COUNTERS = 64
"""In each row of the sketch, or two classes would often share all their counters."""
MARK_BITS = 15
"""Bits of a mark for each row of the sketch."""
SAMPLE = 10
"""All counters are halved after so many counts per row of the cap (TinyLFU, §3.3)."""


class Admission(NamedTuple):
    """A cap on the rows of all owners, and how often each met which class.

    Attributes
    ----------
    counts: (owners, DEPTH, half the counters) uint8
        Two counters of 4 bits in each byte.
    recorded: (owners,) int32
        Counts since the counters were halved, plus half of those before.
    hand: (owners,) int32
        Row from which on the least frequent one is looked for next: equals leave in turn.
    mark: (owners, capacity) int64
        `mark_of` each row's key; derived from the keys.
    untouched: (owners,) int32
        How many leading rows kept their keys since this was last set to the capacity.
    capacity: int
        Rows per owner at most; 0: no cap, and the arrays are empty.
    """

    counts: ByteArray
    recorded: IntArray
    hand: IntArray
    mark: LongArray
    untouched: IntArray
    capacity: int


def make_admission(owners: int, capacity: int) -> Admission:
    """Return an admission that has met nothing yet (ours)."""
    owners = owners if capacity else 0
    wanted = max(COUNTERS_PER_ROW * capacity, LEAST_COUNTERS)
    counters = 1 << (wanted - 1).bit_length()
    return Admission(
        counts=np.zeros((owners, DEPTH, counters // 2), np.uint8),
        recorded=np.zeros(owners, np.int32),
        hand=np.zeros(owners, np.int32),
        mark=np.zeros((owners, capacity), np.int64),
        untouched=np.full(owners, capacity, np.int32),
        capacity=capacity,
    )


NO_CAP = make_admission(0, 0)
"""Everything is admitted."""


def admission_of(admission: Admission, owners: npt.NDArray[np.integer]) -> Admission:
    """Give each new owner a copy of what the old owner that is named for it has met (ours)."""
    if not admission.capacity:
        return NO_CAP
    copies = make_admission(owners.size, admission.capacity)
    for name in ("counts", "recorded", "hand", "mark", "untouched"):
        getattr(copies, name)[:] = getattr(admission, name)[owners]
    return copies


@kernel
def mark_of(classes: Classes, shape: int, key: IntArray, tolerance: int, scratch: Scratch) -> int:
    """Return a number for the cell of a key, the same for its symmetric images.

    Cells are as wide as the tolerance reaches, 2·tolerance + 1. Of keys with several parts the last
    counts, in which most states match.
    """
    first = key.shape[0] - key.shape[0] // classes.parts
    count = vary(classes, shape, key, scratch.variants)
    width = 2 * tolerance + 1
    lowest = np.uint64(0xFFFFFFFFFFFFFFFF)
    for variant in range(count):
        mixed = np.uint64(0x9E3779B97F4A7C15)
        for place in range(first, key.shape[0]):
            cell = (scratch.variants[variant, place] + tolerance) // width
            mixed = (mixed ^ np.uint64(cell)) * np.uint64(0xFF51AFD7ED558CCD)
            mixed ^= mixed >> np.uint64(32)
        lowest = min(lowest, mixed)
    return int(lowest >> np.uint64(1))


@kernel
def _place(admission: Admission, mark: int, depth: int) -> int:
    """Return a class's counter in one row of the sketch: other bits of its mark for every row."""
    return int((mark >> (MARK_BITS * depth)) & (2 * admission.counts.shape[2] - 1))


@kernel
def _counter(admission: Admission, owner: int, depth: int, place: int) -> int:
    pair = admission.counts[owner, depth, place >> 1]
    return int(pair >> 4 if place & 1 else pair & 15)


@kernel
def frequency(admission: Admission, owner: int, mark: int) -> int:
    """Return how often an owner met a class lately, 0 to 15; never too low, seldom too high."""
    least = HIGHEST
    for depth in range(DEPTH):
        place = _place(admission, mark, depth)
        least = min(least, _counter(admission, owner, depth, place))
    return least


@kernel
def record(admission: Admission, owner: int, mark: int) -> None:
    """Count that an owner met a class; halve all counters when the sample is full."""
    least = frequency(admission, owner, mark)
    if least < HIGHEST:
        for depth in range(DEPTH):
            place = _place(admission, mark, depth)
            if _counter(admission, owner, depth, place) == least:
                admission.counts[owner, depth, place >> 1] += 16 if place & 1 else 1
    admission.recorded[owner] += 1
    if admission.recorded[owner] >= SAMPLE * admission.capacity:
        admission.recorded[owner] //= 2
        for depth in range(DEPTH):
            for pair in range(admission.counts.shape[2]):
                # Both halves of the byte at once, without what moves from one to the other.
                halved = (admission.counts[owner, depth, pair] >> 1) & 0x77
                admission.counts[owner, depth, pair] = halved


@kernel
def admit(
    rows: Rows,
    admission: Admission,
    classes: Classes,
    owner: int,
    shape: int,
    key: IntArray,
    scratch: Scratch,
) -> int:
    """Give a key that is not in the table a row; return its number, or `ABSENT` if it gets none.

    The caller has made room for as many rows as the cap allows, without a cap for one more.
    """
    if admission.capacity == 0:
        return append(rows, owner, key)
    mark = mark_of(classes, shape, key, rows.tolerance, scratch)
    if rows.size[owner] < admission.capacity:
        row = append(rows, owner, key)
    else:
        row = _least_frequent(rows, admission, owner)
        least = frequency(admission, owner, admission.mark[owner, row])
        if frequency(admission, owner, mark) <= least:
            return ABSENT
        replace(rows, owner, row, key)
        admission.hand[owner] = (row + 1) % admission.capacity
        admission.untouched[owner] = min(admission.untouched[owner], row)
    admission.mark[owner, row] = mark
    return row


@kernel
def _least_frequent(rows: Rows, admission: Admission, owner: int) -> int:
    size = rows.size[owner]
    best, best_frequency = ABSENT, HIGHEST + 1
    for turn in range(size):
        row = (admission.hand[owner] + turn) % size
        found = frequency(admission, owner, admission.mark[owner, row])
        if found < best_frequency:
            best, best_frequency = row, found
    return best


@kernel
def remark(
    rows: Rows, admission: Admission, classes: Classes, owner: int, shape: int, scratch: Scratch
) -> None:
    """Work the marks of an owner's rows out from their keys."""
    for row in range(rows.size[owner]):
        key = rows.keys[owner, row]
        admission.mark[owner, row] = mark_of(classes, shape, key, rows.tolerance, scratch)
