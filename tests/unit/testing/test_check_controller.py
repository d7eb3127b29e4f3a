"""Every rule for controllers catches a controller that breaks it, and all of ours keep them."""

import random
from dataclasses import replace
from itertools import product
from typing import ClassVar

import numpy as np
import pytest

from dmil import scenario
from dmil.controllers import CONTROLLERS, NO_MEMORY, MemoryUse, make_controller
from dmil.controllers.rules.baselines import LongestQueueFirstController, RandomController
from dmil.testing import ConformanceError, ControllerRule, check_controller
from dmil.testing.proving_grounds import proving_grounds

LEARNERS = ("sarsa", "dual-memory")
EMBEDDINGS = ("exact", "simple", "complex", "cells")

# The grounds of the check have no programs, and more than the one intersection that oracles plan.
ORACLES = sorted(name for name, entry in CONTROLLERS.items() if entry.oracle)
# The smaller their networks, the sooner they learn.
SMALL = {"hidden": 8, "batch_size": 8, "train_every": 5}
OPTIONS = dict.fromkeys(("dqn", "dqn-prioritised", "dqn-hindsight", "vdn", "nec"), SMALL)
# Whatever the options: the ground on which no two intersections are alike.
UNEVEN = replace(proving_grounds()[-1], horizon_s=200)
OTHERS = sorted(
    name for name, entry in CONTROLLERS.items() if not (entry.oracle or entry.shows_plan)
)


@pytest.mark.parametrize("name", ORACLES)
def test_our_planners_conform_on_one_intersection(name):
    check_controller(lambda: make_controller(name), scenario("grid:1x1"))


@pytest.mark.parametrize("name", OTHERS)
def test_our_controllers_conform(name):
    check_controller(lambda: make_controller(name, OPTIONS.get(name)))


@pytest.mark.parametrize(
    ("name", "embedding", "communication"), list(product(LEARNERS, EMBEDDINGS, (False, True)))
)
def test_our_learners_conform_with_every_embedding(name, embedding, communication):
    options = {"embedding": embedding, "communication": communication, "epsilon": 0.2}
    options |= {"communication_period_s": 50}
    check_controller(lambda: make_controller(name, options), UNEVEN)


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("sarsa", {"shared": True}),
        ("sarsa", {"learning": False}),
        ("dual-memory", {"learning": False, "epsilon": 0.0}),
        ("dual-memory", {"staging": "visits"}),
        ("dual-memory", {"stage_period": 5}),
        ("dual-memory", {"short_capacity": 1, "epsilon_decay": 0.9}),
        ("fixed-cycle", {"green_s": 25}),
        ("longest-queue-first", {"approaching": True, "hysteresis": 1.0}),
        ("max-pressure", {"approaching": True, "hysteresis": 1.0}),
        ("webster", {"saturation_flow_veh_per_s": 0.2, "min_cycle_s": 45}),
        ("gap-out", {"min_green_s": 15, "max_green_s": 20, "extend_veh": 1}),
        ("sotl", {"theta_veh_s": 60, "min_green_s": 15, "mu_veh": 3}),
    ],
)
def test_our_controllers_conform_with_other_options(name, options):
    check_controller(lambda: make_controller(name, options), UNEVEN)


class Bandit:
    """Learns which phase pays at each intersection; a small controller with a memory."""

    def __init__(self):
        self.value = None

    def reset(self, context):
        self.rng = context.rng
        self.phases = np.array([len(item.phases) for item in context.network.intersections])
        if self.value is None:
            self.value = np.zeros((self.phases.size, self.phases.max()))
        self.chosen = None

    def decide(self, observation, reward):
        agents = np.arange(self.phases.size)
        if reward is not None:
            self.value[agents, self.chosen] += 0.1 * (reward - self.value[agents, self.chosen])
        known = np.where(np.arange(self.value.shape[1]) < self.phases[:, None], self.value, -np.inf)
        explored = self.rng.random(self.phases.size) < 0.3
        drawn = self.rng.integers(0, self.phases)
        self.chosen = np.where(explored, drawn, known.argmax(axis=1))
        return self.chosen

    def memory_use(self):
        return MemoryUse(0.0, 0.0, 1.0, 1.0, len(self.value), self.value.nbytes)

    def arrays(self):
        return {"value": self.value.copy()}

    def restore(self, arrays):
        self.value = arrays["value"].copy()


def test_a_controller_of_ones_own_conforms():
    check_controller(Bandit)


def longest(change):
    """Make a class that changes what longest-queue-first does at a decision."""

    class Changed(LongestQueueFirstController):
        def decide(self, observation, reward):
            return change(super().decide(observation, reward), observation, reward)

    return Changed


def bandit(**methods):
    return type("Wrong", (Bandit,), methods)


def use(**fields):
    """Return a memory_use that says something else."""
    entries = ("short_term_entries", "long_term_entries", "table_entries", "msize")
    usual = {**dict.fromkeys(entries, 1.0), "entries_total": 3, "bytes_total": 9}
    return lambda self: MemoryUse(**{**usual, **fields})


class NoBegin:
    def decide(self, observation, reward):
        return np.zeros(1, np.int32)


class FailsInASecondRun(LongestQueueFirstController):
    def reset(self, context):
        assert not hasattr(self, "begun"), "begun twice"
        self.begun = True
        super().reset(context)


class NeedsAReward(LongestQueueFirstController):
    def decide(self, observation, reward):
        return super().decide(observation, reward + 1)


class NormalisesTheReward(LongestQueueFirstController):
    def decide(self, observation, reward):
        if reward is not None:
            1 / int(np.abs(reward).sum())
        return super().decide(observation, reward)


class OnlyOneSize(RandomController):
    def decide(self, observation, reward):
        return super().decide(observation, reward).reshape(1)


class EightPhases(RandomController):
    def decide(self, observation, reward):
        return self._rng.integers(0, 8, observation.phase.size)


class NumpysChance(RandomController):
    def decide(self, observation, reward):
        return np.random.randint(0, self._phases)


class PythonsChance(RandomController):
    def decide(self, observation, reward):
        return np.array([random.randrange(count) for count in self._phases])


class ItsOwnChance(RandomController):
    def reset(self, context):
        super().reset(context)
        self._rng = np.random.default_rng()


class SeedsNumpy(LongestQueueFirstController):
    def reset(self, context):
        np.random.seed(1)
        super().reset(context)


class FirstChance(RandomController):
    def reset(self, context):
        rng = getattr(self, "_rng", context.rng)
        super().reset(context)
        self._rng = rng


class SharedMemory(Bandit):
    memories: ClassVar = {}

    def reset(self, context):
        super().reset(context)
        self.value = self.memories.setdefault(context.network.name, self.value)


def changed_reward(phases, observation, reward):
    if reward is not None:
        reward -= reward.mean() + 1
    return phases


def changed_queue(phases, observation, reward):
    observation.queue_veh[0].sort()
    observation.queue_veh[0, -1] += 1
    return phases


class Frozen(LongestQueueFirstController):
    """Returned by a make that makes nothing new."""


ONLY_ONE = Frozen()

WRONG = [
    (ControllerRule.VERBS, NoBegin, "no method reset"),
    (ControllerRule.VERBS, dict, "no method reset and no method decide"),
    (ControllerRule.FRESH, lambda: ONLY_ONE, "the same object twice"),
    (ControllerRule.FRESH, ONLY_ONE, "not callable"),
    (ControllerRule.RUNS, FailsInASecondRun, "reset raised AssertionError: begun twice"),
    (ControllerRule.RUNS, NeedsAReward, "decision 1 (0 s) of the first run on grid:1x1"),
    (ControllerRule.RUNS, NormalisesTheReward, "ZeroDivisionError"),
    (ControllerRule.RUNS, OnlyOneSize, "grid:2x3"),
    (ControllerRule.PHASES, longest(lambda p, o, r: p.tolist()), "a list"),
    (ControllerRule.PHASES, longest(lambda p, o, r: p.astype(float)), "type float64"),
    (ControllerRule.PHASES, longest(lambda p, o, r: p > 0), "type bool"),
    (ControllerRule.PHASES, longest(lambda p, o, r: p[:, None]), "shape (1, 1)"),
    (ControllerRule.PHASES, longest(lambda p, o, r: p[:1]), "expected: an array of shape (6,)"),
    (ControllerRule.EXISTING, EightPhases, "on uneven"),
    (ControllerRule.EXISTING, longest(lambda p, o, r: p - 1), "phase -1 at intersection '0,0'"),
    (ControllerRule.EXISTING, longest(lambda p, o, r: p + 8), "a phase from 0 to 7"),
    (ControllerRule.INPUTS, longest(changed_queue), "it changed observation.queue_veh[0, 11]"),
    (ControllerRule.INPUTS, longest(changed_reward), "it changed reward[0]"),
    (ControllerRule.CHANCE, NumpysChance, "the global random numbers"),
    (ControllerRule.CHANCE, PythonsChance, "the global random numbers"),
    (ControllerRule.CHANCE, SeedsNumpy, "reset of the first run on grid:1x1"),
    (ControllerRule.REPEAT, ItsOwnChance, "as in an equal run of a controller made before"),
    (ControllerRule.CHANCE, FirstChance, "the generator of an earlier run"),
    (ControllerRule.REPEAT, SharedMemory, "as in an equal run of a controller made before"),
    (ControllerRule.MEMORY_VERBS, bandit(restore=None), "only memory_use and arrays"),
    (ControllerRule.MEMORY_USE, bandit(memory_use=use(msize=np.nan)), "msize = nan"),
    (ControllerRule.MEMORY_USE, bandit(memory_use=use(entries_total=-1)), "entries_total = -1"),
    (ControllerRule.MEMORY_USE, bandit(memory_use=use(entries_total=2)), "2 entries in total"),
    (ControllerRule.MEMORY_USE, bandit(memory_use=use(entries_total=99)), "99 entries in total"),
    (ControllerRule.MEMORY_USE, bandit(memory_use=use(bytes_total=0)), "3 entries in 0 bytes"),
    (ControllerRule.MEMORY_USE, bandit(memory_use=lambda self: 3), "a int"),
    (ControllerRule.MEMORY_USE, bandit(memory_use=lambda self: 1 / 0), "ZeroDivisionError"),
    (ControllerRule.ARRAYS, bandit(arrays=lambda self: [self.value]), "a list"),
    (ControllerRule.ARRAYS, bandit(arrays=lambda self: {"value": [1.0]}), "'value' is a list"),
    (
        ControllerRule.ARRAYS,
        bandit(arrays=lambda self: {"value": np.array([{}, None])}),
        "'value' is an array of shape (2,) and type object",
    ),
    (ControllerRule.ARRAYS, bandit(arrays=lambda self: {"header": self.value}), "'header'"),
    (ControllerRule.ARRAYS, bandit(arrays=lambda self: {1: self.value}), "the name 1"),
    (ControllerRule.SNAPSHOT, bandit(arrays=lambda self: {"value": self.value}), "arrays() gave"),
    (
        ControllerRule.SNAPSHOT,
        bandit(restore=lambda self, arrays: setattr(self, "value", arrays["value"])),
        "what restore took was changed: arrays['value'][0, ",
    ),
    (ControllerRule.RESTORE, bandit(restore=lambda self, arrays: None), "were restored"),
    (ControllerRule.RESTORE, bandit(restore=lambda self, arrays: 1 / 0), "restore after reset"),
]


@pytest.mark.parametrize(("rule", "make", "says"), WRONG)
def test_a_wrong_controller_is_caught(rule, make, says):
    with pytest.raises(ConformanceError) as caught:
        check_controller(make)
    assert caught.value.rule is rule, caught.value
    assert says in str(caught.value)


def test_every_rule_has_a_wrong_controller():
    assert {rule for rule, _, _ in WRONG} == set(ControllerRule)


class ForgetsHowMany(Bandit):
    """Its memory_use is one that arrays() does not carry over."""

    def reset(self, context):
        super().reset(context)
        self.extra = getattr(self, "extra", 0)

    def decide(self, observation, reward):
        self.extra = 1
        return super().decide(observation, reward)

    def memory_use(self):
        agents = len(self.phases)
        return MemoryUse(0.0, 0.0, 1.0 + self.extra, 1.0, agents * (1 + self.extra), 8)


class CountsQuestions(Bandit):
    asked = 0

    def memory_use(self):
        self.asked += 1
        return MemoryUse(0.0, 0.0, float(self.asked), 1.0, self.asked * len(self.phases), 8)


class AnswersDifferently(Bandit):
    asked = 0

    def arrays(self):
        self.asked += 1
        return {"value": self.value + self.asked}


@pytest.mark.parametrize(
    ("make", "rule", "says"),
    [
        (ForgetsHowMany, ControllerRule.RESTORE, "table_entries = 1.0"),
        (CountsQuestions, ControllerRule.MEMORY_USE, "asked twice, memory_use()"),
        (AnswersDifferently, ControllerRule.ARRAYS, "asked twice, arrays()['value'][0, 0]"),
    ],
)
def test_a_memory_that_is_not_what_it_says_is_caught(make, rule, says):
    with pytest.raises(ConformanceError) as caught:
        check_controller(make)
    assert caught.value.rule is rule, caught.value
    assert says in str(caught.value)


def test_a_controller_without_entries_may_still_have_memory():
    check_controller(bandit(memory_use=lambda self: NO_MEMORY))


def test_a_scenario_of_ones_own_replaces_ours():
    with pytest.raises(ConformanceError):
        check_controller(EightPhases)
    check_controller(EightPhases, scenario("grid:1x2", horizon_s=100))


def test_the_message_names_rule_place_found_and_expected():
    wrong = longest(lambda phases, observation, reward: phases + 8 * (observation.time_s >= 30))
    with pytest.raises(ConformanceError) as caught:
        check_controller(wrong, scenario("grid:2x2"))
    head, where, found, expected = str(caught.value).splitlines()
    assert head == f"Changed breaks the rule EXISTING: {ControllerRule.EXISTING.value}"
    assert where == "  where:    decision 4 (30 s) of the first run on grid:2x2"
    assert found.startswith("  found:    phase ")
    assert expected == "  expected: a phase from 0 to 7"
    assert isinstance(caught.value, AssertionError)
