"""Policies of others as controllers, and controllers in loops of others."""

import numpy as np
import pytest

from dmil import REWARDS, QueueSimulator, evaluate, make_controller, scenario, vehicles_of_seed
from dmil.errors import InputError
from dmil.interop import ControllerPolicy, PredictController, env, parallel_env
from dmil.testing import check_controller

MOVEMENTS = 12


def longest_queue(vector):
    """Longest queue first on the paper's grids, as an outsider would write it."""
    served = [(1, 7), (2, 8), (4, 10), (5, 11), (1, 2), (4, 5), (7, 8), (10, 11)]
    totals = np.array([sum(vector[j] for j in phase) for phase in served])
    shown = vector[2 * MOVEMENTS + 1 : -1]
    kept = shown.argmax()
    return kept if shown.any() and totals[kept] == totals.max() else totals.argmax()


def measures(controller, name="grid:2x2", seed=1):
    ground = scenario(name)
    vehicles = vehicles_of_seed(ground, seed)
    return evaluate(QueueSimulator(ground), controller, vehicles, REWARDS["queue"], seed).measures


@pytest.mark.parametrize("padded", [False, True])
def test_a_policy_from_outside_does_what_the_same_controller_does(padded):
    ours = measures(make_controller("longest-queue-first"))
    assert ours.wait_veh_s > 0
    theirs = measures(PredictController(longest_queue, padded=padded))
    assert theirs.wait_veh_s == ours.wait_veh_s
    pairs = PredictController(lambda vector: (np.array(longest_queue(vector)), None))
    assert measures(pairs).wait_veh_s == ours.wait_veh_s


def test_every_intersection_may_have_its_own_policy():
    ids = ["0,0", "0,1", "1,0", "1,1"]
    each = PredictController({name: longest_queue for name in ids})
    ours = measures(make_controller("longest-queue-first"))
    assert measures(each).wait_veh_s == ours.wait_veh_s
    mixed = PredictController({name: longest_queue for name in ids} | {"1,0": lambda vector: 0})
    assert measures(mixed).wait_veh_s > ours.wait_veh_s
    with pytest.raises(InputError, match="intersection '1,1' has no policy"):
        measures(PredictController({name: longest_queue for name in ids[:3]}))


def test_a_masked_policy_gets_the_phases_that_exist():
    def last(vector, action_masks):
        return np.flatnonzero(action_masks)[-1], None

    check_controller(lambda: PredictController(last, padded=True, masked=True))
    check_controller(lambda: PredictController(last, masked=True))


def test_a_controller_that_learns_gets_the_rewards_of_the_loop():
    class Listening:
        def reset(self, context):
            self.heard = []
            self.rng = context.rng

        def decide(self, observation, reward):
            self.heard.append((observation.time_s, reward))
            return np.zeros(2, np.int32)

    made = parallel_env("grid:1x2", reward="queue")
    controller = Listening()
    policy = ControllerPolicy(made, controller)
    for seed in (0, 1):
        made.reset(seed=seed)
        given = [None]
        while made.agents:
            _, rewards, *_ = made.step(policy.actions())
            given.append(list(rewards.values()))
        assert [time for time, _ in controller.heard] == list(range(0, 300, 10))
        assert controller.heard[0][1] is None
        assert [reward.tolist() for _, reward in controller.heard[1:]] == given[1:-1]


def test_a_controller_needs_one_of_our_environments():
    with pytest.raises(InputError, match=r"it is a dict|expected an environment of dmil\.interop"):
        ControllerPolicy(type("Other", (), {"unwrapped": {}})(), make_controller("random"))
    assert ControllerPolicy(env("grid:1x1"), make_controller("random"))
