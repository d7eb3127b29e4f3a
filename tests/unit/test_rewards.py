import math

import numpy as np
import pytest
from pydantic import ValidationError

from dmil.errors import InputError
from dmil.network import grid
from dmil.rewards import (
    RELAXATION_VEH,
    REWARDS,
    TOLERATED_VEH,
    RewardConstants,
    default,
    diffusion,
    entropy,
    make_reward,
    pressure,
    queue,
)
from dmil.seeding import stream
from dmil.simulation import Observation

ONE = grid(1, 1)
EMPTY = (0,) * 12


def seen(queue_veh):
    queue_veh = np.atleast_2d(np.array(queue_veh, np.int32))
    nothing = np.zeros(len(queue_veh), np.int32)
    return Observation(
        queue_veh, np.zeros_like(queue_veh), nothing, nothing, 0, np.zeros(queue_veh.shape)
    )


def of_one(reward, before, after):
    """Return the reward of a single intersection; counts that are not given are 0."""
    full = (tuple(counts) + (0,) * (12 - len(counts)) for counts in (before, after))
    (value,) = reward(*map(seen, full), ONE)
    return value


# --- Literal formulas ------------------------------------------------------------------------


def literal_default(x, y, alpha=1.1, theta=10.0):
    def r(x_j, y_j):
        if y_j - x_j <= alpha:
            return 1
        return -1 if y_j - x_j >= alpha + theta else 0

    return sum(r(x_j, y_j) for x_j, y_j in zip(x, y, strict=True))


def literal_diffusion(x, y):
    d = [y_j - x_j for x_j, y_j in zip(x, y, strict=True)]
    return -sum(math.copysign(1, d_j) * d_j**2 for d_j in d) / len(d)


def literal_entropy(x, y):
    def w(s):
        return -sum(s_j * math.log(s_j) for s_j in s if s_j > 0)

    return w(y) - w(x)


def literal_queue(x, y):
    return -sum(y)


LITERAL = {
    "default": (default, literal_default),
    "diffusion": (diffusion, literal_diffusion),
    "entropy": (entropy, literal_entropy),
    "queue": (queue, literal_queue),
}


@pytest.mark.parametrize("name", LITERAL)
@pytest.mark.parametrize("kind", ["grid", "tee", "mixed_network"])
def test_every_reward_is_its_literal_formula_and_padding_does_not_count(name, kind, request):
    reward, literal = LITERAL[name]
    network = grid(3, 4) if kind == "grid" else request.getfixturevalue(kind)
    sizes = [len(node.movements) for node in network.intersections]
    # One column more than any intersection has, as if another of 13 movements were there.
    shape = len(sizes), max(sizes) + 1
    rng = stream(0, "rewards", name, kind)
    for most in (1, 2, 5, 20, 60) * 5:
        states = rng.integers(0, most + 1, (2, *shape))
        for i, size in enumerate(sizes):
            states[:, i, size:] = 0
        found = reward(seen(states[0]), seen(states[1]), network)
        expected = [
            literal(states[0, i, :size].tolist(), states[1, i, :size].tolist())
            for i, size in enumerate(sizes)
        ]
        assert found.shape == (len(sizes),)
        assert found.dtype == np.float64
        np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)


# --- By hand ---------------------------------------------------------------------------------


def test_the_papers_constants():
    assert (RELAXATION_VEH, TOLERATED_VEH) == (1.1, 10.0)


@pytest.mark.parametrize(
    ("growth", "of_it"), [(-30, 1), (0, 1), (1, 1), (2, 0), (11, 0), (12, -1), (50, -1)]
)
def test_default_has_three_branches(growth, of_it):
    before, after = max(0, -growth), max(0, growth)
    assert of_one(default, [before], [after]) == 11 + of_it


@pytest.mark.parametrize(("growth", "of_it"), [(0, 1), (2, 1), (3, 0), (6, 0), (7, -1), (12, -1)])
def test_default_with_other_constants(growth, of_it):
    # α = 2.5, θ = 4: rewarded up to 2.5, punished from 6.5 on.
    reward = make_reward("default", RewardConstants(relaxation_veh=2.5, tolerated_veh=4))
    assert of_one(reward, [0], [growth]) == 11 + of_it


def test_the_papers_constants_are_the_named_reward():
    assert make_reward("default", RewardConstants()) is REWARDS["default"]
    assert RewardConstants().changed == {}
    assert RewardConstants(tolerated_veh=5).changed == {"tolerated_veh": 5.0}


@pytest.mark.parametrize("name", ["entropy", "mine:calm"])
def test_only_the_default_reward_has_constants(name):
    with pytest.raises(InputError, match="reward_constants: tolerated_veh is given, but the"):
        make_reward(name, RewardConstants(tolerated_veh=5))


@pytest.mark.parametrize("value", [-1.0, float("nan"), float("inf")])
def test_constants_are_numbers_of_zero_or_more(value):
    with pytest.raises(ValidationError):
        RewardConstants(tolerated_veh=value)


def test_default_by_hand():
    # +1, +2, +11, +12, −4 and seven without change: 1 + 0 + 0 − 1 + 1 + 7.
    assert of_one(default, [3, 3, 0, 1, 4], [4, 5, 11, 13, 0]) == 8


def test_diffusion_by_hand():
    # d = 3, −2, 1, 0…: −(9 − 4 + 1)/12.
    assert of_one(diffusion, [0, 5, 1], [3, 3, 2]) == pytest.approx(-0.5)


def test_diffusion_rewards_what_flows_away():
    assert of_one(diffusion, [6], [0]) == 3.0
    assert of_one(diffusion, [0], [6]) == -3.0


@pytest.mark.parametrize("state", [[0], [1], [1, 1, 1, 0, 1]])
def test_nobody_or_one_vehicle_has_no_entropy(state):
    assert of_one(entropy, EMPTY, state) == 0.0
    assert of_one(entropy, state, EMPTY) == 0.0


def test_entropy_by_hand():
    # w = −2·ln 2 before, −4·ln 4 after.
    assert of_one(entropy, [2, 1], [4, 0]) == pytest.approx(2 * math.log(2) - 4 * math.log(4))
    assert of_one(entropy, [4, 0], [2, 1]) == pytest.approx(4 * math.log(4) - 2 * math.log(2))


def test_entropy_does_not_normalise_counts():
    assert of_one(entropy, [2, 2], [4, 4]) == pytest.approx(-12 * math.log(2))


def test_queue_by_hand():
    assert of_one(queue, [9, 9], [1, 2, 0, 4]) == -7.0


def test_pressure_by_hand():
    network = grid(1, 2)
    before, after = np.zeros((2, 2, 12), np.int32)
    after[0, 7] = 5  # from the West straight on, to the right-hand intersection
    after[1, 6:9] = 1, 2, 6  # waiting there
    # Left: 5 queued, and three movements lead to a road whose queues are 3 in the mean: 5 − 9.
    # Right: 9 queued, and the road to the left is empty.
    assert pressure(seen(before), seen(after), network).tolist() == [-4.0, -9.0]


def test_pressure_of_a_balanced_intersection_is_zero():
    network = grid(1, 2)
    after = np.zeros((2, 12), np.int32)
    after[0, 0] = 3  # from the East
    after[1, 6] = 3  # from the West: 1 in the mean of three movements, and three lead there
    value = pressure(seen(np.zeros((2, 12))), seen(after), network)
    assert value.tolist() == [0.0, 0.0]


@pytest.mark.parametrize("name", ["queue", "pressure"])
def test_what_stands_now_does_not_depend_on_before(name):
    rng = stream(1, "before")
    first, second, after = (seen(rng.integers(0, 9, (1, 12))) for _ in range(3))
    reward = REWARDS[name]
    assert reward(first, after, ONE).tolist() == reward(second, after, ONE).tolist()


@pytest.mark.parametrize("name", REWARDS)
def test_observations_are_left_as_they_are(name):
    rng = stream(2, "observations")
    states = rng.integers(0, 9, (2, 1, 12))
    before, after = map(seen, states)
    REWARDS[name](before, after, ONE)
    assert (before.queue_veh == states[0]).all()
    assert (after.queue_veh == states[1]).all()


@pytest.mark.parametrize("name", REWARDS)
def test_an_emptied_intersection_is_never_worse_than_a_filled_one(name):
    empty, full = seen(EMPTY), seen((15,) * 12)
    assert REWARDS[name](full, empty, ONE)[0] > REWARDS[name](empty, full, ONE)[0]
