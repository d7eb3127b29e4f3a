"""Keyed rows: the one compiled table under every memory.

A table holds, for each owner, rows that are found by a key (a vector of whole numbers). Without a
tolerance a row is found by hashing; with one, by walking a trie whose levels are the places of the
key, so that only branches within the tolerance are entered and no look-up scans all keys. Rows are
only ever appended or emptied as a whole: the number of a row never changes.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dmil.compilation import kernel

IntArray = npt.NDArray[np.int32]

ABSENT = -1
"""Row number of a key that is not in the table; end of a list of nodes."""

VALUE, CHILD, SIBLING, ROW = range(4)
"""Columns of a trie node; a leaf has a row and stands for all the places below it."""
NODE_FIELDS = 4
ROOT = 0

SPARE_ROWS = 64
"""Room left in a fresh copy of a table."""


class Rows(NamedTuple):
    """Keys of all owners and the index over them.

    Attributes
    ----------
    size: (owners,) int32
        Rows in use.
    keys: (owners, capacity, places) int32
    slots: (owners, power of two) int32
        Hash table of row numbers (tolerance 0), else of size 1 and unused.
    nodes: (owners, nodes, 4) int32
        Trie (tolerance above 0), else of size 1 and unused.
    node_count: (owners,) int32
    tolerance: int
    """

    size: IntArray
    keys: IntArray
    slots: IntArray
    nodes: IntArray
    node_count: IntArray
    tolerance: int


def make_rows(owners: int, capacity: int, places: int, tolerance: int) -> Rows:
    """Return empty rows with room for ``capacity`` of them per owner (ours)."""
    hashed, walked = tolerance == 0, tolerance > 0
    slots = 1 << max(1, (2 * capacity - 1).bit_length()) if hashed else 1
    rows = Rows(
        size=np.zeros(owners, np.int32),
        keys=np.zeros((owners, capacity, places), np.int32),
        slots=np.full((owners, slots), ABSENT, np.int32),
        nodes=np.zeros((owners, _nodes(capacity, places) if walked else 1, NODE_FIELDS), np.int32),
        node_count=np.ones(owners, np.int32),
        tolerance=tolerance,
    )
    rows.nodes[:, ROOT] = ABSENT
    return rows


def _nodes(capacity: int, places: int) -> int:
    # Keys share most of their upper places: about two nodes a row in practice; grown when not so.
    return 3 * capacity + 2 * places + 2


def is_short_of_room(rows: Rows, more: int) -> bool:
    """Tell whether ``more`` rows might not fit for some owner (ours)."""
    places = rows.keys.shape[2]
    if rows.size.max() + more > rows.keys.shape[1]:
        return True
    return bool(
        rows.tolerance and rows.node_count.max() + more * (places + 1) > rows.nodes.shape[1]
    )


def with_room(rows: Rows, more: int) -> Rows:
    """Return the same rows with at least twice the room and space for ``more`` (ours)."""
    owners, capacity, places = rows.keys.shape
    larger = max(2 * capacity, int(rows.size.max()) + more)
    grown = make_rows(owners, larger, places, rows.tolerance)
    if rows.tolerance:
        needed = int(rows.node_count.max()) + more * (places + 1)
        if grown.nodes.shape[1] < needed:
            grown = grown._replace(nodes=np.zeros((owners, 2 * needed, NODE_FIELDS), np.int32))
        used = int(rows.node_count.max())
        grown.nodes[:, :used] = rows.nodes[:, :used]
        grown.node_count[:] = rows.node_count
    grown.keys[:, :capacity] = rows.keys
    grown.size[:] = rows.size
    if not rows.tolerance:
        _rehash(grown)
    return grown


def rows_of(rows: Rows, owners: IntArray) -> Rows:
    """Give each new owner a copy of the rows of the old owner that is named for it (ours).

    Room is left for `SPARE_ROWS` more.
    """
    places = rows.keys.shape[2]
    capacity = int(rows.size.max()) + SPARE_ROWS
    nodes = int(rows.node_count.max()) + (SPARE_ROWS * (places + 1) if rows.tolerance else 0)
    roomy = rows
    if capacity > rows.keys.shape[1] or nodes > rows.nodes.shape[1]:
        roomy = with_room(rows, SPARE_ROWS)
    return Rows(
        roomy.size[owners],
        roomy.keys[owners, :capacity],
        roomy.slots[owners],
        roomy.nodes[owners, :nodes],
        roomy.node_count[owners],
        rows.tolerance,
    )


@kernel
def find(
    rows: Rows, owner: int, variants: IntArray, count: int, scratch: IntArray
) -> tuple[int, int]:
    """Find the row of a class: the nearest key by L1, of equally near ones the oldest (§5).

    Parameters
    ----------
    rows
        The table.
    owner: int
        Whose rows.
    variants: (at least count, places) int32
        The key looked for under each symmetry.
    count: int
        How many variants to try.
    scratch: (2, at least places + 1) int32
        Working space.

    Returns
    -------
    row, variant: int
        The row, or `ABSENT`; and the variant under which it was found.
    """
    best_row, best_variant = ABSENT, 0
    if rows.tolerance == 0:
        for variant in range(count):
            row = _find_exact(rows, owner, variants[variant])
            if row != ABSENT and (best_row == ABSENT or row < best_row):
                best_row, best_variant = row, variant
        return best_row, best_variant
    best_distance = rows.tolerance * rows.keys.shape[2] + 1
    for variant in range(count):
        row, distance = _find_near(rows, owner, variants[variant], best_row, best_distance, scratch)
        if row != best_row:
            best_row, best_variant, best_distance = row, variant, distance
    return best_row, best_variant


@kernel
def append(rows: Rows, owner: int, key: IntArray) -> int:
    """Add a row for a key that is not in the table; return its number.

    The caller has made room (`is_short_of_room`, `with_room`).
    """
    row = rows.size[owner]
    rows.size[owner] = row + 1
    for place in range(key.shape[0]):
        rows.keys[owner, row, place] = key[place]
    if rows.tolerance == 0:
        _hash_in(rows, owner, row)
    else:
        _grow_trie(rows, owner, row)
    return row


@kernel
def clear(rows: Rows, owner: int) -> None:
    """Remove every row of an owner."""
    rows.size[owner] = 0
    for slot in range(rows.slots.shape[1]):
        rows.slots[owner, slot] = ABSENT
    rows.node_count[owner] = 1
    rows.nodes[owner, ROOT, CHILD] = ABSENT


@kernel
def copy_rows(rows: Rows, source: int, goal: int) -> None:
    """Make the rows of one owner equal to those of another."""
    rows.size[goal] = rows.size[source]
    for row in range(rows.size[source]):
        for place in range(rows.keys.shape[2]):
            rows.keys[goal, row, place] = rows.keys[source, row, place]
    for slot in range(rows.slots.shape[1]):
        rows.slots[goal, slot] = rows.slots[source, slot]
    rows.node_count[goal] = rows.node_count[source]
    for node in range(rows.node_count[source]):
        for field in range(rows.nodes.shape[2]):
            rows.nodes[goal, node, field] = rows.nodes[source, node, field]


@kernel
def _hash(key: IntArray) -> int:
    mixed = np.uint64(0x9E3779B97F4A7C15)
    for j in range(key.shape[0]):
        mixed = (mixed ^ np.uint64(key[j])) * np.uint64(0xFF51AFD7ED558CCD)
        mixed ^= mixed >> np.uint64(32)
    return np.int64(mixed >> np.uint64(1))


@kernel
def _same(first: IntArray, second: IntArray) -> bool:
    for j in range(first.shape[0]):
        if first[j] != second[j]:
            return False
    return True


@kernel
def _find_exact(rows: Rows, owner: int, key: IntArray) -> int:
    slots = rows.slots[owner]
    mask = slots.shape[0] - 1
    place = _hash(key) & mask
    while slots[place] != ABSENT:
        if _same(rows.keys[owner, slots[place]], key):
            return slots[place]
        place = (place + 1) & mask
    return ABSENT


@kernel
def _hash_in(rows: Rows, owner: int, row: int) -> None:
    slots = rows.slots[owner]
    mask = slots.shape[0] - 1
    place = _hash(rows.keys[owner, row]) & mask
    while slots[place] != ABSENT:
        place = (place + 1) & mask
    slots[place] = row


@kernel
def _rehash(rows: Rows) -> None:
    for owner in range(rows.size.shape[0]):
        for slot in range(rows.slots.shape[1]):
            rows.slots[owner, slot] = ABSENT
        for row in range(rows.size[owner]):
            _hash_in(rows, owner, row)


@kernel
def _find_near(
    rows: Rows, owner: int, key: IntArray, best_row: int, best_distance: int, scratch: IntArray
) -> tuple[int, int]:
    """Walk the branches within the tolerance and nearer than the best row so far."""
    nodes, keys = rows.nodes[owner], rows.keys[owner]
    places, tolerance = key.shape[0], rows.tolerance
    current, travelled = scratch[0], scratch[1]
    depth = 0
    current[0] = nodes[ROOT, CHILD]
    travelled[0] = 0
    while depth >= 0:
        node = current[depth]
        # Siblings stand in the order of their values.
        if node == ABSENT or nodes[node, VALUE] > key[depth] + tolerance:
            depth -= 1
            continue
        current[depth] = nodes[node, SIBLING]
        off = abs(nodes[node, VALUE] - key[depth])
        distance = travelled[depth] + off
        if off > tolerance or distance > best_distance:
            continue
        row = nodes[node, ROW]
        if row == ABSENT:
            depth += 1
            current[depth] = nodes[node, CHILD]
            travelled[depth] = distance
            continue
        for j in range(depth + 1, places):
            off = abs(keys[row, j] - key[j])
            distance += off
            if off > tolerance:
                distance = best_distance + 1
                break
        if distance < best_distance or (distance == best_distance and row < best_row):
            best_row, best_distance = row, distance
    return best_row, best_distance


@kernel
def _grow_trie(rows: Rows, owner: int, row: int) -> None:
    """Hang a new leaf below the last node that its key shares with another key."""
    nodes, key = rows.nodes[owner], rows.keys[owner, row]
    parent = ROOT
    for depth in range(key.shape[0]):
        before, node = ABSENT, nodes[parent, CHILD]
        while node != ABSENT and nodes[node, VALUE] < key[depth]:
            before, node = node, nodes[node, SIBLING]
        if node == ABSENT or nodes[node, VALUE] != key[depth]:
            leaf = _new_node(rows, owner, key[depth], node, row)
            if before == ABSENT:
                nodes[parent, CHILD] = leaf
            else:
                nodes[before, SIBLING] = leaf
            return
        other = nodes[node, ROW]
        if other != ABSENT:
            # A leaf becomes a branch, and its row moves one place down.
            nodes[node, ROW] = ABSENT
            nodes[node, CHILD] = _new_node(
                rows, owner, rows.keys[owner, other, depth + 1], ABSENT, other
            )
        parent = node


@kernel
def _new_node(rows: Rows, owner: int, value: int, sibling: int, row: int) -> int:
    node = rows.node_count[owner]
    rows.node_count[owner] = node + 1
    rows.nodes[owner, node, VALUE] = value
    rows.nodes[owner, node, CHILD] = ABSENT
    rows.nodes[owner, node, SIBLING] = sibling
    rows.nodes[owner, node, ROW] = row
    return node
