import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dmil.seeding import LARGEST_SEED, stream, tuning_seeds


@pytest.mark.parametrize(
    ("seed", "names", "draws"),
    [
        (0, ("demand",), [2237, 420446, 397570, 787622, 277887]),
        (7, ("training", "exploration", 3), [182930, 744749, 77010, 667631, 123198]),
    ],
)
def test_golden_draws(seed, names, draws):
    # A change here changes every published number. New values: print the line below.
    assert stream(seed, *names).integers(1_000_000, size=5).tolist() == draws


@given(st.integers(0, 2**64), st.lists(st.text() | st.integers(), max_size=3))
def test_the_same_seed_and_names_give_the_same_draws(seed, names):
    first, second = stream(seed, *names), stream(seed, *names)
    assert first is not second
    np.testing.assert_array_equal(first.random(8), second.random(8))


def test_other_streams_change_nothing():
    alone = stream(3, "demand").random(8)
    other = stream(3, "exploration")
    other.random(1000)
    np.testing.assert_array_equal(stream(3, "demand").random(8), alone)


def test_streams_of_different_names_and_seeds_differ():
    keys = [(seed, name) for seed in range(20) for name in ("demand", "exploration", "0", "1")]
    firsts = {stream(seed, name).integers(2**63) for seed, name in keys}
    assert len(firsts) == len(keys)


def test_neighbouring_seeds_are_uncorrelated():
    draws = np.array([stream(seed, "demand").random(2000) for seed in range(10)])
    correlation = np.corrcoef(draws)[np.triu_indices(10, k=1)]
    # Of 45 independent pairs the largest stays below 4.5 standard errors.
    assert np.abs(correlation).max() < 4.5 / np.sqrt(2000)


def test_draws_are_uniform():
    mean = stream(11, "demand").random(100_000).mean()
    assert mean == pytest.approx(0.5, abs=5 * np.sqrt(1 / 12 / 100_000))


def test_the_global_generator_is_left_alone():
    np.random.seed(5)
    before = np.random.get_state()[1].tolist()
    stream(5, "demand").random(10)
    assert np.random.get_state()[1].tolist() == before


def test_a_negative_seed_is_refused():
    with pytest.raises(ValueError, match="non-negative"):
        stream(-1, "demand")


def test_tuning_seeds_are_none_that_a_command_takes():
    seeds = [seed for master in range(50) for seed in tuning_seeds(master, 20)]
    assert len(set(seeds)) == 1000
    assert min(seeds) > LARGEST_SEED
    assert all(isinstance(seed, int) for seed in seeds)
