"""The central unit against a naive merge: one union of classes, every row looked up in turn."""

import numpy as np
import pytest

from dmil.memory import (
    ABSENT,
    append,
    average_best,
    average_values,
    look_up,
    make_best_table,
    make_scratch,
    make_value_table,
)
from dmil.seeding import stream
from dmil.symmetry import Embedding, SymmetryGroup, build_classes

PLACES, ACTIONS = 4, 3
CYCLE = SymmetryGroup(
    np.array([[(j + g) % 4 for j in range(4)] for g in range(4)], np.int32),
    np.array([[0, 1, 2], [1, 0, 2], [0, 1, 2], [1, 0, 2]], np.int32),
)
MEMBERS = np.array([1, 2, 4, 5], np.int32)
"""Owners 0 and 3 are of another shape and must stay as they are."""


def classes_of(embedding):
    return build_classes(embedding, [CYCLE, CYCLE], [1, 0, 0, 1, 0, 0])


def visit(table, classes, scratch, owner, key, rng):
    """Let an owner learn something at a key, as agents do: first come, first class."""
    row, _ = look_up(table.rows, classes, owner, 0, key, scratch)
    if row == ABSENT:
        row = append(table.rows, owner, key)
    action, q = int(rng.integers(ACTIONS)), float(rng.standard_normal())
    if hasattr(table, "tried"):
        table.value[owner, row, action] = q
        table.tried[owner, row, action] = True
        table.visits[owner, row] += 1
    else:
        table.action[owner, row], table.value[owner, row] = action, q


def rows_of(table, owner):
    """Return (key, {action: Q}) of all rows."""
    rows = []
    for row in range(table.rows.size[owner]):
        if hasattr(table, "tried"):
            tried = np.flatnonzero(table.tried[owner, row]).tolist()
            values = {a: float(table.value[owner, row, a]) for a in tried}
            assert not table.value[owner, row][~table.tried[owner, row]].any()
        else:
            values = {int(table.action[owner, row]): float(table.value[owner, row])}
        rows.append((tuple(table.rows.keys[owner, row].tolist()), values))
    return rows


def naive_merge(plain, memories, *, best_only):
    keys, votes = [], []
    for memory in memories:
        for key, values in memory:
            row, image = plain.find(keys, key)
            if row is None:
                row = len(keys)
                keys.append(key)
                votes.append({})
            for action, q in values.items():
                votes[row].setdefault(image[action], []).append(q)
    merged = []
    for key, ballot in zip(keys, votes, strict=True):
        means = {action: float(np.sum(qs) / len(qs)) for action, qs in ballot.items()}
        if best_only:
            best = min(means, key=lambda action: (-means[action], action))
            means = {best: means[best]}
        merged.append((key, means))
    return merged


@pytest.mark.parametrize("kind", ["values", "bests"])
@pytest.mark.parametrize(
    "embedding",
    [
        Embedding("exact"),
        Embedding("turned", rotations=True),
        Embedding("near", tolerance=1),
        Embedding("near and turned", tolerance=1, rotations=True),
    ],
    ids=lambda embedding: embedding.name,
)
def test_meetings_are_naive_merges(plain_classes, kind, embedding):
    rng = stream(1, "meetings", kind, embedding.name)
    classes, plain = classes_of(embedding), plain_classes(embedding, CYCLE)
    scratch, merge = make_scratch(classes), average_values if kind == "values" else average_best
    table = (
        make_value_table(6, 800, PLACES, ACTIONS, embedding.tolerance)
        if kind == "values"
        else make_best_table(6, 800, PLACES, embedding.tolerance)
    )
    common, filled_gaps = 0, 0
    for _ in range(5):
        for owner in range(6):
            for _ in range(12):
                key = rng.poisson(1.5, PLACES).astype(np.int32)
                visit(table, classes, scratch, owner, key, rng)
        strangers = [rows_of(table, owner) for owner in (0, 3)]
        memories = [rows_of(table, owner) for owner in MEMBERS]
        expected = naive_merge(plain, memories, best_only=kind == "bests")
        merge(table, classes, MEMBERS, common, scratch)
        for owner in MEMBERS:
            found = rows_of(table, owner)
            assert [key for key, _ in found] == [key for key, _ in expected]
            for (_, values), (_, wanted) in zip(found, expected, strict=True):
                assert values == pytest.approx(wanted, rel=1e-12)
            # The index knows the rows that came from others.
            for row, (key, _) in enumerate(found):
                counts = np.array(key, np.int32)
                assert look_up(table.rows, classes, owner, 0, counts, scratch) == (row, 0)
        assert [rows_of(table, owner) for owner in (0, 3)] == strangers
        common = len(expected)
        filled_gaps += common > max(len(memory) for memory in memories)
    assert filled_gaps


@pytest.mark.parametrize("kind", ["values", "bests"])
def test_a_meeting_without_common_rows_known_gives_the_same(kind):
    """After loading, how many rows are common is not known; 0 is always right."""
    embedding = Embedding("near and turned", tolerance=1, rotations=True)
    classes = classes_of(embedding)
    scratch, merge = make_scratch(classes), average_values if kind == "values" else average_best
    tables = []
    for known in (True, False):
        rng = stream(2, "meetings")
        table = (
            make_value_table(6, 400, PLACES, ACTIONS, 1)
            if kind == "values"
            else make_best_table(6, 400, PLACES, 1)
        )
        common = 0
        for _ in range(3):
            for owner in MEMBERS:
                for _ in range(10):
                    key = rng.poisson(1.5, PLACES).astype(np.int32)
                    visit(table, classes, scratch, owner, key, rng)
            merge(table, classes, MEMBERS, common, scratch)
            common = int(table.rows.size[MEMBERS[0]]) if known else 0
        tables.append([rows_of(table, owner) for owner in MEMBERS])
    assert tables[0] == tables[1]


def test_one_agent_alone_keeps_its_memory():
    classes = classes_of(Embedding("near", tolerance=1))
    scratch, rng = make_scratch(classes), stream(3, "meetings")
    table = make_value_table(6, 100, PLACES, ACTIONS, 1)
    for _ in range(30):
        visit(table, classes, scratch, 2, rng.poisson(2, PLACES).astype(np.int32), rng)
    before = rows_of(table, 2)
    average_values(table, classes, np.array([2], np.int32), 0, scratch)
    assert rows_of(table, 2) == before
