"""What a comparison says of its measures."""

from dataclasses import replace

import numpy as np
import pytest

from dmil.experiments.comparison import REFERENCE, Comparison


@pytest.fixture
def found():
    values = np.array([[10.0, 12.0, 20.0], [11.0, 14.0, 18.0], [12.0, 13.0, 25.0]])
    labels = ["mine", "program", REFERENCE]
    return Comparison(labels, range(3), {"delay_s": values}, same_demand=False)


@pytest.mark.parametrize(
    ("reference", "means"), [("program", [-2, 0, 8]), (REFERENCE, [-10, -8, 0])]
)
def test_differences_are_taken_to_the_reference_on_the_same_seeds(found, reference, means):
    difference = replace(found, reference=reference).difference("delay_s")
    np.testing.assert_allclose(difference.value, means)
    own = found.labels.index(reference)
    assert difference.low[own] == difference.high[own] == 0
    others = np.arange(3) != own
    assert (difference.low[others] < difference.value[others]).all()
    assert (difference.high[others] > difference.value[others]).all()


def test_without_the_reference_there_is_no_difference(found):
    assert replace(found, reference="actuated").difference("delay_s") is None
