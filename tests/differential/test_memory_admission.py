"""Admission against a twin with lists of whole numbers: marks, counters, who stays."""

import numpy as np
import pytest

from dmil.memory import (
    ABSENT,
    admit,
    frequency,
    look_up,
    make_admission,
    make_rows,
    make_scratch,
    mark_of,
    record,
    remark,
)
from dmil.memory.admission import COUNTERS_PER_ROW, DEPTH, HIGHEST, LEAST_COUNTERS, SAMPLE
from dmil.seeding import stream
from dmil.symmetry import Embedding, SymmetryGroup, build_classes

PLACES = 4
TURNS = SymmetryGroup(
    np.array([[(j + g) % 4 for j in range(4)] for g in range(4)], np.int32),
    np.array([[(a + g) % 4 for a in range(4)] for g in range(4)], np.int32),
)
WORD = 2**64 - 1


class PlainAdmission:
    """TinyLFU as the module says it, one counter one number."""

    def __init__(self, images, tolerance, capacity):
        self.images, self.tolerance, self.capacity = images, tolerance, capacity
        counters = LEAST_COUNTERS
        while counters < COUNTERS_PER_ROW * capacity:
            counters *= 2
        self.counters = [[0] * counters for _ in range(DEPTH)]
        self.recorded, self.hand, self.keys = 0, 0, []

    def mark(self, key):
        marks = []
        for image in self.images:
            moved = [0] * len(key)
            for j, value in enumerate(key):
                moved[image[j]] = value
            mixed = 0x9E3779B97F4A7C15
            for value in moved:
                cell = (value + self.tolerance) // (2 * self.tolerance + 1)
                mixed = (mixed ^ cell) * 0xFF51AFD7ED558CCD & WORD
                mixed ^= mixed >> 32
            marks.append(mixed)
        return min(marks) >> 1

    def places(self, key):
        mark = self.mark(key)
        return [(mark >> 15 * depth) % len(self.counters[0]) for depth in range(DEPTH)]

    def frequency(self, key):
        return min(row[place] for row, place in zip(self.counters, self.places(key), strict=True))

    def record(self, key):
        least = self.frequency(key)
        for row, place in zip(self.counters, self.places(key), strict=True):
            if row[place] == least < HIGHEST:
                row[place] += 1
        self.recorded += 1
        if self.recorded == SAMPLE * self.capacity:
            self.recorded //= 2
            self.counters = [[count // 2 for count in row] for row in self.counters]

    def admit(self, key):
        if len(self.keys) < self.capacity:
            self.keys.append(key)
            return len(self.keys) - 1
        turns = [(self.hand + turn) % self.capacity for turn in range(self.capacity)]
        victim = min(turns, key=lambda row: self.frequency(self.keys[row]))
        if self.frequency(key) <= self.frequency(self.keys[victim]):
            return ABSENT
        self.keys[victim], self.hand = key, (victim + 1) % self.capacity
        return victim


@pytest.mark.parametrize("capacity", [1, 2, 7, 40])
@pytest.mark.parametrize("rotations", [False, True], ids=["alone", "rotations"])
@pytest.mark.parametrize("tolerance", [0, 1, 2])
def test_admission_is_its_twin(tolerance, rotations, capacity):
    rng = stream(capacity, "admission", tolerance, int(rotations))
    own = Embedding("own", tolerance=tolerance, rotations=rotations)
    classes = build_classes(own, [TURNS], [0, 0])
    scratch = make_scratch(classes)
    rows, admission = make_rows(2, capacity, PLACES, tolerance), make_admission(2, capacity)
    images = TURNS.movement_image[: 4 if rotations else 1].tolist()
    twins = [PlainAdmission(images, tolerance, capacity) for _ in range(2)]
    answers = set()
    for _ in range(700):
        owner = int(rng.integers(2))
        # Some come often, most hardly ever.
        key = (rng.geometric(0.25, PLACES) * 3).astype(np.int32)
        plain, twin = key.tolist(), twins[owner]
        mark = mark_of(classes, 0, key, tolerance, scratch)
        assert mark == twin.mark(plain)
        assert frequency(admission, owner, mark) == twin.frequency(plain)
        record(admission, owner, mark)
        twin.record(plain)
        if rng.random() < 0.4 and look_up(rows, classes, owner, 0, key, scratch)[0] == ABSENT:
            row = admit(rows, admission, classes, owner, 0, key, scratch)
            assert row == twin.admit(plain)
            answers.add(row == ABSENT)
    for owner, twin in enumerate(twins):
        assert admission.hand[owner] == twin.hand
        assert admission.recorded[owner] == twin.recorded
        size = rows.size[owner]
        assert rows.keys[owner, :size].tolist() == twin.keys
        low, high = admission.counts[owner] & 15, admission.counts[owner] >> 4
        assert np.stack([low, high], axis=2).reshape(DEPTH, -1).tolist() == twin.counters
        kept = admission.mark[owner, :size].copy()
        remark(rows, admission, classes, owner, 0, scratch)
        assert admission.mark[owner, :size].tolist() == kept.tolist()
        assert kept.tolist() == [twin.mark(key) for key in twin.keys]
    assert answers == {False, True}
