"""The deep learners' life: what is stored, when ε falls and targets move, saving, divergence."""

import numpy as np
import pytest

from dmil.controllers import RunContext, make_controller
from dmil.errors import DivergedError, PolicyError
from dmil.network import grid
from dmil.rewards import make_reward
from dmil.scenarios import SignalTiming, scenario
from dmil.seeding import stream
from dmil.simulation import Observation
from dmil.testing.proving_grounds import uneven_network
from dmil.training import controller_of, load_policy, policy_of, save_policy, train

NAMES = ["dqn", "dqn-prioritised", "dqn-hindsight", "vdn"]
EACH = pytest.mark.parametrize("name", NAMES)
SMALL = {"batch_size": 4, "hidden": 8, "training_decisions": 100}


def begin(controller, network, seed=0):
    controller.reset(RunContext(network, SignalTiming(), stream(seed)))
    return controller


def observation(network, number, time_s=0):
    """Return an observation in which every count says which one it is."""
    agents = len(network.intersections)
    queue = np.full((agents, 12), number, np.int32) + np.arange(agents, dtype=np.int32)[:, None]
    phase = np.full(agents, 2, np.int32)
    return Observation(queue, queue + 100, phase, phase, time_s, queue.astype(np.float64))


def drive(controller, network, numbers, *, reward=1.0):
    """Let a controller decide in a run; return what it chose."""
    chosen, given = [], None
    for number in numbers:
        seen = observation(network, number, 10 * number)
        chosen.append(controller.decide(seen, given).copy())
        # A simulator may use its arrays again.
        seen.queue_veh[:] = -1
        given = np.full(len(network.intersections), reward * number)
    return np.array(chosen)


def test_transitions_join_what_was_seen_chosen_and_got_and_end_with_the_run():
    network = grid(1, 2)
    learner = make_controller("dqn", SMALL | {"reward_scale": 0.5})
    actions = []
    for run in ([3, 4, 5], [20, 21]):
        begin(learner, network, run[0])
        actions.append(drive(learner, network, run))
    stored = learner.arrays()
    # Two agents, two transitions of the first run and one of the second: none from 5 to 20.
    assert stored["0.replay.state"][:, 0].tolist() == [3, 4, 4, 5, 20, 21]
    assert stored["0.replay.following"][:, 0].tolist() == [4, 5, 5, 6, 21, 22]
    assert stored["0.replay.reward"].tolist() == [1.5, 1.5, 2.0, 2.0, 10.0, 10.0]
    expected = np.concatenate([run[:-1].ravel() for run in actions])
    assert stored["0.replay.action"].tolist() == expected.tolist()
    assert stored["decisions"] == 5


def test_the_team_has_one_transition_with_the_sum_of_rewards():
    network = grid(1, 2)
    learner = begin(make_controller("vdn", SMALL | {"reward_scale": 0.5}), network)
    actions = drive(learner, network, [3, 4, 5])
    stored = learner.arrays()
    assert stored["replay.state"][:, :, 0].tolist() == [[3, 4], [4, 5]]
    assert stored["replay.following"][:, :, 0].tolist() == [[4, 5], [5, 6]]
    assert stored["replay.reward"].tolist() == [3.0, 4.0]
    assert stored["replay.action"].tolist() == actions[:-1].tolist()
    assert learner.memory_use().entries_total == 2


def test_inputs_can_be_more_than_queues():
    network = grid(1, 1)
    learner = begin(make_controller("dqn", {"approaching": True, "phase": True}), network)
    state = learner.states(observation(network, 3))
    assert state.tolist() == [[3] * 8 + [103] * 8 + [0, 0, 1, 0, 0, 0, 0, 0]]


def test_epsilon_falls_while_it_learns_and_is_0_when_it_does_not():
    network = grid(1, 1)
    options = {"training_decisions": 100, "exploration_part": 0.2}
    learner = begin(make_controller("dqn", options), network)
    found = []
    for _ in range(25):
        found.append(learner.epsilon)
        learner.decide(observation(network, 1), None)
    assert np.allclose(found[:21], np.linspace(1.0, 0.05, 21))
    assert np.allclose(found[20:], 0.05)
    greedy = begin(make_controller("dqn", options | {"learning": False}), network)
    greedy.restore(learner.arrays())
    assert greedy.epsilon == 0.0


@EACH
def test_who_does_not_learn_chooses_the_best_and_changes_nothing(name):
    network = uneven_network()
    greedy = begin(make_controller(name, SMALL | {"learning": False}), network)
    before = greedy.arrays()
    chosen = drive(greedy, network, range(30))
    for number, phases in enumerate(chosen):
        value = greedy._values(greedy.states(observation(network, number)))
        for agent, item in enumerate(network.intersections):
            assert phases[agent] == value[agent, : len(item.phases)].argmax()
    after = greedy.arrays()
    assert all(np.array_equal(before[key], after[key]) for key in before)


@EACH
def test_the_target_network_moves_when_its_time_has_come(name):
    network = grid(1, 1)
    options = SMALL | {"target_period": 10, "train_every": 2}
    learner = begin(make_controller(name, options), network)
    first, reward, times = learner.arrays()["0.target"], None, set()
    for number in range(60):
        learner.decide(observation(network, number % 7), reward)
        reward = np.array([-1.0])
        now = learner.arrays()
        if not np.array_equal(now["0.target"], first):
            times.add(int(now["0.steps"]))
            assert np.array_equal(now["0.target"], now["0.weights"])
            first = now["0.target"]
    # The fourth transition is there at the fifth decision, and every other decision learns.
    assert int(now["0.steps"]) == 28
    assert times == {10, 20}


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("capacity", [70, 1000])
def test_a_resumed_training_ends_with_the_same_bytes(name, capacity, tmp_path):
    made, reward = scenario("grid:1x2", horizon_s=300), make_reward("queue")
    options = SMALL | {"buffer_capacity": capacity, "target_period": 30}
    whole = make_controller(name, options)
    train(made, whole, reward, 3, episodes=range(4))
    half = make_controller(name, options)
    train(made, half, reward, 3, episodes=range(2))

    def saved(controller, file):
        header = {"name": name, "options": options, "reward": "queue", "training": {}}
        save_policy(policy_of(controller, made.network, **header), tmp_path / file)
        return tmp_path / file

    policy = load_policy(saved(half, "half.npz"))
    resumed = controller_of(policy, made.network, where="half.npz")
    train(made, resumed, reward, 3, episodes=range(2, 4))
    assert saved(resumed, "resumed.npz").read_bytes() == saved(whole, "whole.npz").read_bytes()


@EACH
def test_networks_of_other_sizes_and_numbers_that_are_none_are_refused(name):
    network = grid(1, 1)
    learner = begin(make_controller(name, SMALL), network)
    drive(learner, network, range(10))
    saved = learner.arrays()
    wrong = {key: np.delete(saved[key], 0) for key in ("0.weights", "0.mean", "0.target")}
    wrong["0.square"] = np.full_like(saved["0.square"], np.nan)
    wrong["0.steps"] = np.array(-1)
    wrong["decisions"] = np.array([1, 2])
    for key, array in wrong.items():
        with pytest.raises(PolicyError, match=key.split(".")[-1]):
            learner.restore({**saved, key: array})
    learner.restore(saved)


def test_the_team_keeps_to_its_network():
    learner = begin(make_controller("vdn", SMALL), grid(1, 2))
    with pytest.raises(PolicyError, match="other intersections"):
        begin(learner, grid(1, 3))


@EACH
def test_values_that_are_no_numbers_end_the_run_with_an_error(name):
    network = grid(1, 1)
    learner = begin(make_controller(name, SMALL), network)
    huge = {**learner.arrays()}
    huge["0.weights"] = np.full_like(huge["0.weights"], 3e38)
    learner.restore(huge)
    with pytest.raises(DivergedError) as caught:
        learner.decide(observation(network, 9, 120), None)
    assert (caught.value.controller, caught.value.at_time_s) == (name, 120)
    assert caught.value.what == "values of the phases"


def test_rewards_and_steps_that_are_too_large_end_the_run_with_an_error():
    network = grid(1, 1)
    with pytest.raises(DivergedError, match="rewards"):
        drive(begin(make_controller("dqn", SMALL), network), network, range(9), reward=1e300)
    wild = make_controller("dqn", SMALL | {"learning_rate": 1e30})
    with pytest.raises(DivergedError, match="values"):
        drive(begin(wild, network), network, range(50))
