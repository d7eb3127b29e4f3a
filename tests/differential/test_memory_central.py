"""The central unit against a naive merge: one union of classes, every row looked up in turn."""

import numpy as np
import pytest

from dmil.memory import (
    ABSENT,
    Merged,
    append,
    average_best,
    average_values,
    bests_of,
    give_values,
    look_up,
    make_best_table,
    make_scratch,
    make_value_table,
    merged_best,
    merged_values,
    rows_in_common,
    take_over_best,
    values_of,
)
from dmil.memory.admission import NO_CAP
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


@pytest.mark.parametrize("kind", ["values", "bests"])
def test_an_answer_that_reaches_all_is_a_meeting(kind):
    """What is merged aside and taken over is what is merged in place."""
    embedding = Embedding("near and turned", tolerance=1, rotations=True)
    classes = classes_of(embedding)
    scratch, rng, common = make_scratch(classes), stream(4, "meetings", kind), 0
    make = (
        make_value_table(6, 400, PLACES, ACTIONS, 1)
        if kind == "values"
        else make_best_table(6, 400, PLACES, 1)
    )
    for _ in range(4):
        for owner in range(6):
            for _ in range(10):
                key = rng.poisson(1.5, PLACES).astype(np.int32)
                visit(make, classes, scratch, owner, key, rng)
        everyone = np.arange(6)
        if kind == "values":
            post = values_of(make, everyone, 400)
            merged = merged_values(post, classes, MEMBERS, common, scratch)
            assert [rows_of(post, owner) for owner in range(6)] == [
                rows_of(make, owner) for owner in range(6)
            ]
            give_values(post, merged, classes, 0, MEMBERS, scratch)
            average_values(make, classes, MEMBERS, common, scratch)
        else:
            post = bests_of(make, everyone, 400)
            merged = merged_best(post, classes, MEMBERS, common, scratch)
            for owner in MEMBERS:
                mine = bests_of(post, np.array([owner]), 400)
                take_over_best(post, owner, mine, merged, NO_CAP, classes, 0, scratch)
            average_best(make, classes, MEMBERS, common, scratch)
        assert [rows_of(post, owner) for owner in range(6)] == [
            rows_of(make, owner) for owner in range(6)
        ]
        common = rows_in_common(post.rows, MEMBERS)
        assert common == make.rows.size[1] == merged.rows.size[0]


def test_rows_in_common_are_the_leading_equal_ones():
    table = make_best_table(3, 8, 2, 0)
    for owner, keys in enumerate([(1, 2, 3), (1, 2, 4, 5), (1, 2, 3)]):
        for key in keys:
            append(table.rows, owner, np.array([key, 0], np.int32))
    assert rows_in_common(table.rows, np.array([0, 1, 2], np.int32)) == 2
    assert rows_in_common(table.rows, np.array([0, 2], np.int32)) == 3
    assert rows_in_common(table.rows, np.array([1], np.int32)) == 4
    empty = make_best_table(2, 8, 2, 0)
    assert rows_in_common(empty.rows, np.array([0, 1], np.int32)) == 0


def test_a_message_has_the_bytes_of_its_rows():
    values, best = make_value_table(1, 9, PLACES, ACTIONS, 0), make_best_table(1, 9, PLACES, 0)
    for table, count in ((values, 2), (best, 3)):
        for number in range(count):
            append(table.rows, 0, np.full(PLACES, number, np.int32))
    # Keys of 4 · 4 bytes; Q and a flag for each of 3 actions; an action and its Q.
    assert Merged(values).size_bytes == 2 * (16 + 3 * 8 + 3)
    assert Merged(None, best).size_bytes == 3 * (16 + 4 + 8)
    assert Merged(values, best).size_bytes == 2 * 43 + 3 * 28
    assert Merged().size_bytes == 0
