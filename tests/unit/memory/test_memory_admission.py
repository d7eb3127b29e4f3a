"""A cap on the long-term memory, worked out by hand; saved and cut at a meeting."""

import numpy as np
import pytest

from dmil.errors import PolicyError
from dmil.memory import (
    ABSENT,
    NO_CAP,
    admission_of,
    append,
    frequency,
    keep_most_frequent,
    make_admission,
    make_best_table,
    make_scratch,
    mark_of,
    pack_admission,
    record,
    unpack_admission,
)
from tests.unit.memory.test_memory_dual import CLASSES, Example


def capped(capacity, **rules):
    # Every insert is staged at once.
    return Example(
        short_capacity=1, staged_ratio=1.0, admission=make_admission(1, capacity), **rules
    )


def keys(agent):
    return [key for key, _, _ in agent.long]


def test_the_less_frequent_of_two_classes_goes():
    agent = capped(2)
    agent.insert((10, 10), 0, 1.0)
    agent.insert((20, 20), 1, 2.0)
    assert keys(agent) == [(10, 10), (20, 20)]
    # All came once: a newcomer has to come more often.
    agent.insert((30, 30), 2, 9.0)
    assert keys(agent) == [(10, 10), (20, 20)]
    # The second visit: twice against once; of equals the first row goes, whatever its Q.
    agent.insert((30, 30), 2, 9.0)
    assert agent.long == [((30, 30), 2, 9.0), ((20, 20), 1, 2.0)]
    # Known classes are consolidated as ever, and counted.
    agent.insert((20, 20), 1, 2.1)
    assert agent.long[1] == ((20, 20), 1, 2.0)
    # All came twice now; what was turned out is remembered to have come once, this is twice.
    agent.insert((10, 10), 0, 5.0)
    assert keys(agent) == [(30, 30), (20, 20)]
    # Thrice: from the row after the one replaced last on, equals leave in turn.
    agent.insert((10, 10), 0, 5.0)
    assert agent.long == [((30, 30), 2, 9.0), ((10, 10), 0, 5.0)]


def test_near_and_swapped_keys_count_as_one():
    agent = capped(1)
    agent.insert((60, 0), 0, 1.0)
    marks = [
        mark_of(CLASSES, 0, np.array(key, np.int32), 1, agent.scratch)
        for key in ((30, 9), (9, 30), (29, 10), (31, 8), (32, 9), (30, 11))
    ]
    # Cells of three: 29 to 31 and 8 to 10, either way round.
    assert len(set(marks[:4])) == 1
    assert len(set(marks[3:])) == 3
    agent.insert((30, 9), 2, 1.0)
    agent.insert((8, 31), 2, 1.0)
    assert keys(agent) == [(8, 31)]


def test_without_a_cap_nothing_is_counted():
    agent = Example(short_capacity=1, staged_ratio=1.0)
    for count in range(0, 60, 3):
        agent.insert((count, count), 0, 1.0)
    assert len(agent.long) == 20
    assert pack_admission(NO_CAP) == {}
    assert admission_of(NO_CAP, np.arange(5)) is NO_CAP
    assert unpack_admission({}, 0, np.array([7], np.int32)) is NO_CAP


def test_counters_stop_and_are_halved():
    admission = make_admission(1, 2)
    for expected in [*range(1, 16), 15, 15, 15, 15, 7]:
        record(admission, 0, 5)
        assert frequency(admission, 0, 5) == expected
    # The twentieth was the last of the sample; counters in one byte do not mix.
    assert admission.recorded[0] == 10
    assert set(np.unique(admission.counts)) <= {0, 7, 7 << 4, 7 | 7 << 4}


def test_a_meeting_keeps_what_all_together_met_most():
    capacity, members = 2, np.array([0, 2], np.int32)
    classes = CLASSES._replace(shape=np.zeros(3, np.int32))
    scratch = make_scratch(classes)
    table, admission = make_best_table(3, 5, 2, 1), make_admission(3, capacity)
    known = np.array([[5, 5], [10, 10], [20, 20], [30, 30]], np.int32)
    for owner in members:
        for row, key in enumerate(known):
            append(table.rows, owner, key)
            table.action[owner, row], table.value[owner, row] = row % 3, float(row)
    for owner, times in ((0, (0, 3, 1, 0)), (2, (2, 0, 1, 3)), (1, (9, 0, 0, 0))):
        for key, count in zip(known, times, strict=True):
            for _ in range(count):
                record(admission, owner, mark_of(classes, 0, key, 1, scratch))
    admission.untouched[:] = 0
    keep_most_frequent(table, admission, classes, members, scratch)
    # 2, 3, 2 and 3 times: the second and the fourth, in their order.
    for owner in members:
        assert table.rows.size[owner] == 2
        assert table.rows.keys[owner, :2].tolist() == [[10, 10], [30, 30]]
        assert (table.action[owner, :2].tolist(), table.value[owner, :2].tolist()) == (
            [1, 0],
            [1.0, 3.0],
        )
        marks = [mark_of(classes, 0, key, 1, scratch) for key in known[[1, 3]]]
        assert admission.mark[owner].tolist() == marks
    assert admission.untouched.tolist() == [2, 0, 2]
    assert table.rows.size[1] == 0


def test_what_was_counted_is_packed_and_unpacked():
    admission = make_admission(3, 4)
    for mark in range(50):
        record(admission, mark % 2, mark << 31)
    admission.hand[1] = 3
    packed = pack_admission(admission)
    found = unpack_admission(packed, 4, np.array([4, 0, 1], np.int32))
    for name in ("counts", "recorded", "hand"):
        assert getattr(found, name).tolist() == getattr(admission, name).tolist()
        assert not np.shares_memory(packed[name], getattr(admission, name))
    copies = admission_of(admission, np.array([1, 1]))
    assert copies.hand.tolist() == [3, 3]
    assert copies.counts[0].tolist() == copies.counts[1].tolist() == admission.counts[1].tolist()


@pytest.mark.parametrize(
    ("change", "capacity", "message"),
    [
        ({}, 3, "at most long_capacity = 3"),
        ({"counts": None}, 4, "array 'counts': missing"),
        ({"hand": np.zeros(2, np.int32)}, 4, "array 'hand'"),
        ({"recorded": np.zeros(1, np.int64)}, 4, "array 'recorded'"),
        ({}, 17, "array 'counts'"),
    ],
)
def test_counts_that_do_not_fit_are_refused(change, capacity, message):
    arrays = pack_admission(make_admission(1, 4)) | change
    arrays = {name: array for name, array in arrays.items() if array is not None}
    with pytest.raises(PolicyError) as error:
        unpack_admission(arrays, capacity, np.array([4], np.int32))
    assert message in str(error.value)


def test_too_few_tried_actions_are_neither_told_nor_staged():
    agent = Example(least_tried=2)
    agent.insert((10, 10), 0, 5.0)
    assert agent.recall((10, 10)) == ABSENT
    # Its value still counts where it is learned from.
    assert agent.value((10, 10), 0) == 5.0
    agent.insert((10, 10), 2, 6.0)
    assert agent.recall((10, 10)) == 2
    agent.insert((20, 20), 0, 9.0)
    agent.insert((30, 30), 0, 8.0)
    agent.insert((40, 40), 0, 7.0)
    # ⌈½·4⌉ = 2 rows may be staged, and one has something to tell.
    assert agent.long == [((10, 10), 2, 6.0)]
    assert agent.short == []
