"""Every rule for rewards catches a reward that breaks it, and all of ours keep them."""

import numpy as np
import pytest

from dmil.rewards import REWARDS
from dmil.testing import ConformanceError, RewardRule, check_reward


@pytest.mark.parametrize("name", REWARDS)
def test_our_rewards_conform(name):
    check_reward(REWARDS[name])


def fewer(before, after, network):
    return -after.queue_veh.sum(axis=1).astype(np.float64)


class Fewer:
    """A reward may be any object that can be called."""

    def __call__(self, before, after, network):
        return fewer(before, after, network)


@pytest.mark.parametrize("reward", [fewer, Fewer(), lambda *given: fewer(*given)])
def test_a_reward_of_ones_own_conforms(reward):
    check_reward(reward)


def per_vehicle(before, after, network):
    return fewer(before, after, network) * (1 / int(before.queue_veh.sum()))


def logarithm(before, after, network):
    with np.errstate(all="ignore"):
        return np.log(after.queue_veh.sum(axis=1, dtype=np.float64))


def twelve_ways(before, after, network):
    return -after.queue_veh.reshape(-1, 12).sum(axis=1, dtype=np.float64)


def changed_queue(before, after, network):
    after.queue_veh[after.queue_veh > 10] = 10
    return fewer(before, after, network)


def changed_past(before, after, network):
    np.subtract(after.queue_veh, before.queue_veh, out=before.queue_veh)
    return -before.queue_veh.sum(axis=1, dtype=np.float64)


def noisy(before, after, network):
    return fewer(before, after, network) + np.random.random()


class Remembers:
    def __init__(self):
        self.calls = 0

    def __call__(self, before, after, network):
        self.calls += 1
        return fewer(before, after, network) / self.calls


class OneBuffer:
    def __init__(self):
        self.buffers = {}

    def __call__(self, before, after, network):
        buffer = self.buffers.setdefault(after.phase.size, np.zeros(after.phase.size))
        buffer[:] = fewer(before, after, network)
        return buffer


class FirstNetwork:
    network = None

    def __call__(self, before, after, network):
        self.network = self.network or network
        assert self.network is network, "another network"
        return fewer(before, after, network)


WRONG = [
    (RewardRule.RUNS, per_vehicle, "it raised ZeroDivisionError"),
    (RewardRule.RUNS, FirstNetwork(), "grid:2x3"),
    (RewardRule.SHAPE, twelve_ways, "uneven"),
    (RewardRule.SHAPE, lambda b, a, n: -a.queue_veh.sum(axis=1), "type int64"),
    (RewardRule.SHAPE, lambda b, a, n: -float(a.queue_veh.sum()), "a float"),
    (RewardRule.SHAPE, lambda b, a, n: -a.queue_veh.astype(np.float64), "shape (1, 12)"),
    (RewardRule.SHAPE, lambda b, a, n: np.zeros(1), "shape (6,) and type float64"),
    (RewardRule.SHAPE, lambda b, a, n: None, "a NoneType"),
    (RewardRule.FINITE, logarithm, "-inf at intersection"),
    (RewardRule.INPUTS, changed_queue, "it changed after.queue_veh"),
    (RewardRule.INPUTS, changed_past, "it changed before.queue_veh"),
    (RewardRule.PURE, noisy, "the global random numbers"),
    (RewardRule.PURE, Remembers(), "called again with the same arguments"),
    (RewardRule.SNAPSHOT, OneBuffer(), "a new array from every call"),
]


@pytest.mark.parametrize(("rule", "reward", "says"), WRONG)
def test_a_wrong_reward_is_caught(rule, reward, says):
    with pytest.raises(ConformanceError) as caught:
        check_reward(reward)
    assert caught.value.rule is rule, caught.value
    assert says in str(caught.value)


def test_every_rule_has_a_wrong_reward():
    assert {rule for rule, _, _ in WRONG} == set(RewardRule)
