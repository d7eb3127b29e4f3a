"""Algorithms 1 and 2 and the reading rule, row by row on an example worked out by hand.

Keys are pairs of counts, there are three actions, two keys match within 1 in each count, and
swapping the counts is a symmetry: it swaps actions 0 and 1 and leaves action 2.
"""

import numpy as np
import pytest

from dmil.memory import (
    ABSENT,
    DualMemory,
    find_both,
    make_best_table,
    make_scratch,
    make_value_table,
    recall,
    recalled_value,
    remember,
    significantly_better,
)
from dmil.symmetry import Embedding, SymmetryGroup, build_classes

SWAP = SymmetryGroup(
    np.array([[0, 1], [1, 0]], np.int32), np.array([[0, 1, 2], [1, 0, 2]], np.int32)
)
CLASSES = build_classes(Embedding("pairs", rotations=True, tolerance=1), [SWAP], [0])


class Example:
    """One agent's dual memory, short and long, read back as plain rows."""

    def __init__(self, **rules):
        self.scratch = make_scratch(CLASSES)
        self.memory = DualMemory(
            **{
                "short": make_value_table(1, 5, 2, 3, 1),
                "long": make_best_table(1, 20, 2, 1),
                "short_capacity": 4,
                "staged_ratio": 0.5,
                "significance": 0.1,
                "stage_by_visits": False,
                "stage_period": 0,
                **rules,
            }
        )

    def found(self, key):
        return find_both(self.memory, CLASSES, 0, 0, np.array(key, np.int32), self.scratch)

    def insert(self, key, action, value):
        counts = np.array(key, np.int32)
        found = self.found(key)
        remember(self.memory, CLASSES, 0, 0, counts, found, action, value, self.scratch)

    def recall(self, key):
        return recall(self.memory, CLASSES, 0, 0, self.found(key))

    def value(self, key, action):
        return recalled_value(self.memory, CLASSES, 0, 0, self.found(key), action)

    @property
    def short(self):
        table = self.memory.short
        return [
            (
                tuple(table.rows.keys[0, row].tolist()),
                {
                    int(a): float(table.value[0, row, a])
                    for a in np.flatnonzero(table.tried[0, row])
                },
            )
            for row in range(table.rows.size[0])
        ]

    @property
    def long(self):
        table = self.memory.long
        return [
            (
                tuple(table.rows.keys[0, row].tolist()),
                int(table.action[0, row]),
                float(table.value[0, row]),
            )
            for row in range(table.rows.size[0])
        ]


def test_the_worked_example():
    agent = Example()
    # Unknown: neither an action nor a value.
    assert agent.recall((4, 0)) == ABSENT
    assert agent.value((4, 0), 0) == 0.0

    # A new class (Algorithm 1, "New State Discovered").
    agent.insert((4, 0), 0, 1.0)
    assert agent.short == [((4, 0), {0: 1.0})]
    # (0, 5) swapped is (5, 0), within 1 of (4, 0): its row, and action 0 swapped is 1
    # (getEquivalentAction).
    agent.insert((0, 5), 0, 2.0)
    assert agent.short == [((4, 0), {0: 1.0, 1: 2.0})]
    # The value is written, not added or compared (Update Rule).
    agent.insert((4, 0), 0, -1.0)
    assert agent.short == [((4, 0), {0: -1.0, 1: 2.0})]
    # Read back: best tried action 1 for (4, 0), hence 0 for (0, 4); untried action 2 is worth 0.
    assert agent.recall((4, 0)) == 1
    assert agent.recall((0, 4)) == 0
    assert agent.value((0, 5), 0) == 2.0
    assert agent.value((0, 5), 1) == -1.0
    assert agent.value((0, 5), 2) == 0.0

    # Of what was tried the best counts, even if it is worse than the zero of what was not.
    agent.insert((9, 9), 2, -3.0)
    assert agent.recall((9, 9)) == 2
    # 2 away from (4, 0) in both counts: a class of its own.
    agent.insert((2, 2), 1, 0.5)
    assert [key for key, _ in agent.short] == [(4, 0), (9, 9), (2, 2)]
    assert agent.long == []

    # The fourth row fills it: ⌈½·4⌉ = 2 rows are staged, the best are 2.0, −3.0, 0.5 and 2.0; of
    # equal ones the older goes first. Then it is empty (LTM Staging Rule).
    agent.insert((7, 0), 0, 2.0)
    assert agent.short == []
    assert agent.long == [((4, 0), 1, 2.0), ((7, 0), 0, 2.0)]
    # Long-term memory alone answers now, in the orientation of the question.
    assert (agent.recall((4, 1)), agent.recall((1, 4))) == (1, 0)
    assert (agent.value((4, 0), 1), agent.value((0, 4), 0)) == (2.0, 2.0)
    # It knows one action per class; what was forgotten is worth 0.
    assert agent.value((4, 0), 0) == 0.0
    assert agent.recall((9, 9)) == ABSENT

    # Short-term memory wins only if significantly better than 2.0, which is above 2.2 …
    agent.insert((4, 1), 0, 2.1)
    assert agent.recall((4, 1)) == 1
    # … yet for the update its value comes first wherever it was tried.
    assert agent.value((4, 1), 0) == 2.1
    assert agent.value((4, 1), 1) == 2.0
    # (0, 7) is (7, 0) swapped; here 2.3 is above 2.2. Short-term keys are as they came.
    agent.insert((0, 7), 0, 2.3)
    assert agent.short[1] == ((0, 7), {0: 2.3})
    assert (agent.recall((0, 7)), agent.recall((7, 0))) == (0, 1)
    agent.insert((20, 20), 2, -1.0)

    # Full again: 2.3 is staged first, then 2.1. Algorithm 2: 2.3 replaces the 2.0 of its class,
    # with the action turned to the stored key; 2.1 is not significantly better, nothing changes.
    agent.insert((30, 30), 0, -2.0)
    assert agent.short == []
    assert agent.long == [((4, 0), 1, 2.0), ((7, 0), 1, 2.3)]


@pytest.mark.parametrize(
    ("value", "than", "answer"),
    [
        (2.2000001, 2.0, True),
        (2.1999999, 2.0, False),
        # 10 % of the magnitude: with a negative Q better still means higher.
        (-0.89, -1.0, True),
        (-0.95, -1.0, False),
        (0.0, 0.0, False),
        (1e-9, 0.0, True),
    ],
)
def test_significantly_better_means_by_a_tenth_of_the_magnitude(value, than, answer):
    assert significantly_better(value, than, 0.1) is answer


def test_negative_rows_are_staged_by_their_best_tried_value():
    agent = Example()
    for count, value in ((0, -4.0), (10, -1.0), (20, -3.0), (30, -2.0)):
        agent.insert((count, count), 0, value)
    # Untried actions with their zeros are no reason to stage a row.
    assert agent.long == [((10, 10), 0, -1.0), ((30, 30), 0, -2.0)]


def test_staging_by_visits_takes_the_rows_written_most_often():
    agent = Example(stage_by_visits=True)
    for _ in range(3):
        agent.insert((10, 10), 2, -5.0)
    agent.insert((10, 10), 1, -6.0)
    for _ in range(2):
        agent.insert((20, 20), 0, 0.0)
    agent.insert((0, 0), 0, 9.0)
    agent.insert((30, 30), 0, 8.0)
    # Visits are 4, 2, 1, 1; the best action of a row goes with it.
    assert agent.long == [((10, 10), 2, -5.0), ((20, 20), 0, 0.0)]


def test_a_stage_period_counts_writes_since_the_last_staging():
    agent = Example(stage_period=3)
    agent.insert((0, 0), 0, 1.0)
    agent.insert((0, 0), 0, 2.0)
    assert agent.long == []
    # The third write: ⌈½·2⌉ = 1 of two rows.
    agent.insert((10, 10), 0, 1.5)
    assert (agent.short, agent.long) == ([], [((0, 0), 0, 2.0)])
    for value in (3.0, 4.0):
        agent.insert((10, 10), 0, value)
    assert len(agent.long) == 1
    agent.insert((10, 10), 0, 5.0)
    assert (agent.short, agent.long[1]) == ([], ((10, 10), 0, 5.0))


@pytest.mark.parametrize(
    ("ratio", "capacity", "staged"),
    # 0.1·30 and 0.07·100 are a little above 3 and 7 in floats: no fourth or eighth row for that.
    [(0.5, 4, 2), (0.5, 5, 3), (0.01, 5, 1), (1.0, 5, 5), (0.1, 30, 3), (0.07, 100, 7)],
)
def test_the_part_staged_is_rounded_up(ratio, capacity, staged):
    agent = Example(
        short_capacity=capacity,
        staged_ratio=ratio,
        short=make_value_table(1, capacity, 2, 3, 1),
        long=make_best_table(1, capacity, 2, 1),
    )
    for row in range(capacity):
        agent.insert((2 * row, 2 * row), 0, float(row))
    assert [value for _, _, value in agent.long] == [capacity - 1.0 - k for k in range(staged)]


def test_staged_rows_of_one_long_term_class_compete():
    # Classes are not transitive: (3, 3) and (5, 5) are apart, and both near a stored (4, 4).
    agent = Example(short_capacity=2, staged_ratio=1.0)
    agent.insert((4, 4), 2, 1.0)
    agent.insert((40, 40), 2, 0.0)
    assert len(agent.long) == 2
    agent.insert((3, 3), 1, 1.05)
    agent.insert((5, 5), 0, 3.0)
    # 3.0 comes first and replaces 1.0; 1.05 then is worse.
    assert agent.long == [((4, 4), 0, 3.0), ((40, 40), 2, 0.0)]
