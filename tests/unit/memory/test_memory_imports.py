"""What a memory takes from the dummy agent's exact Q-table, worked out by hand."""

import numpy as np
import pytest

from dmil.memory import (
    append,
    import_best,
    import_values,
    make_best_table,
    make_scratch,
    make_value_table,
)
from dmil.symmetry import Embedding, SymmetryGroup, build_classes

SWAP = SymmetryGroup(
    np.array([[0, 1], [1, 0]], np.int32), np.array([[0, 1, 2], [1, 0, 2]], np.int32)
)
PAIRS = build_classes(Embedding("pairs", rotations=True, tolerance=1), [SWAP, SWAP], [0, 1])
SHAPE = 1


def exact_table(rows):
    """Return an exact table whose second owner holds ((counts), {action: Q}) rows."""
    table = make_value_table(2, 16, 2, 3, 0)
    for visits, (key, values) in enumerate(rows, start=1):
        row = append(table.rows, SHAPE, np.array(key, np.int32))
        for action, value in values.items():
            table.value[SHAPE, row, action] = value
            table.tried[SHAPE, row, action] = True
        table.visits[SHAPE, row] = visits
    return table


def test_all_rows_go_into_a_table_of_values_in_their_order():
    source = exact_table(
        [
            ((4, 0), {0: 1.0, 2: -1.0}),
            ((9, 9), {1: 5.0}),
            # (0, 3) swapped is near (4, 0): its 0 is 1 there; its 1 is 0 and replaces the 1.0.
            ((0, 3), {0: 2.0, 1: 7.0}),
            ((20, 0), {2: 1.0}),
            ((0, 20), {0: 3.0}),
        ]
    )
    table = make_value_table(2, 16, 2, 3, 1)
    import_values(source, table, PAIRS, SHAPE, make_scratch(PAIRS))
    assert table.rows.size.tolist() == [0, 3]
    assert table.rows.keys[SHAPE, :3].tolist() == [[4, 0], [9, 9], [20, 0]]
    expected = [[7.0, 2.0, -1.0], [0.0, 5.0, 0.0], [0.0, 3.0, 1.0]]
    assert table.value[SHAPE, :3].tolist() == expected
    assert table.tried[SHAPE, :3].tolist() == [[q != 0.0 for q in row] for row in expected]
    assert table.visits[SHAPE, :3].tolist() == [1 + 3, 2, 4 + 5]


@pytest.mark.parametrize(
    ("ratio", "expected"),
    [
        # ⌈0.5·5⌉ = 3 rows: best Q 7 of (0, 3), then 5 of (9, 9), then 3 of (20, 20), the older
        # of the two with 3.
        (0.5, [((0, 3), 1, 7.0), ((9, 9), 1, 5.0), ((20, 20), 2, 3.0)]),
        (0.2, [((0, 3), 1, 7.0)]),
        # All: (4, 0) falls into the class of (0, 3) and is worse.
        (
            1.0,
            [((0, 3), 1, 7.0), ((9, 9), 1, 5.0), ((20, 20), 2, 3.0), ((30, 30), 0, 3.0)],
        ),
    ],
)
def test_the_best_part_goes_into_long_term_memory(ratio, expected):
    source = exact_table(
        [
            ((4, 0), {0: 1.0, 2: -1.0}),
            ((20, 20), {0: 2.0, 2: 3.0}),
            ((9, 9), {1: 5.0}),
            ((30, 30), {0: 3.0}),
            ((0, 3), {0: 2.0, 1: 7.0}),
        ]
    )
    table = make_best_table(2, 16, 2, 1)
    import_best(source, table, PAIRS, SHAPE, ratio, 0.1, make_scratch(PAIRS))
    size = table.rows.size.tolist()
    assert size == [0, len(expected)]
    found = zip(
        map(tuple, table.rows.keys[SHAPE, : size[1]].tolist()),
        table.action[SHAPE].tolist(),
        table.value[SHAPE].tolist(),
        strict=False,
    )
    assert list(found) == expected


def test_an_empty_table_gives_nothing():
    source, table = exact_table([]), make_best_table(2, 16, 2, 1)
    import_best(source, table, PAIRS, SHAPE, 0.5, 0.1, make_scratch(PAIRS))
    assert table.rows.size.tolist() == [0, 0]
