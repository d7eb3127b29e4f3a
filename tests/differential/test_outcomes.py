"""Tables of outcomes against plain Python: running means, and how far they are believed."""

import numpy as np
import pytest

from dmil.memory.residuals import (
    MOST,
    SMALLEST_STEP,
    believed,
    count_outcome,
    learn_outcome,
    make_residuals,
)
from dmil.seeding import stream


def test_residuals_are_running_means():
    table, rng = make_residuals(3, 2, 2), stream(0, "outcomes")
    errors = rng.normal([1.0, -2.0], 1.0, (150, 2))
    for error in errors:
        for outcome in range(2):
            learn_outcome(table, 1, 1, outcome, error[outcome])
        count_outcome(table, 1, 1)
    assert table.residual[1, 1] == pytest.approx(errors.mean(axis=0), rel=1e-4)
    assert table.times[1, 1] == 150
    assert table.entries == 1
    assert np.count_nonzero(table.residual) == 2


def test_a_world_that_changes_is_learned_for_ever():
    table = make_residuals(1, 1, 1)
    table.times[:] = MOST
    expected = 0.0
    for _ in range(500):
        learn_outcome(table, 0, 0, 0, 3.0)
        count_outcome(table, 0, 0)
        expected += SMALLEST_STEP * (3.0 - expected)
    assert table.residual[0, 0, 0] == pytest.approx(expected, rel=1e-4)
    assert expected > 2.7
    assert table.times[0, 0] == MOST


@pytest.mark.parametrize(
    ("times", "trust", "part"), [(0, 5.0, 0.0), (0, 0.0, 0.0), (5, 5.0, 0.5), (7, 0.0, 1.0)]
)
def test_half_is_believed_after_as_many_times_as_trust(times, trust, part):
    table = make_residuals(1, 1, 1)
    table.residual[:], table.times[:] = 4.0, times
    assert believed(table, 0, 0, 0, trust) == 4.0 * part
