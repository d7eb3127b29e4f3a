"""The loop, the training phases and policies in files."""

import json
from dataclasses import replace

import numpy as np
import pytest

from dmil.controllers import RunContext, make_controller
from dmil.errors import InputError, OutputError, PolicyError
from dmil.rewards import REWARDS, make_reward
from dmil.scenarios import SignalTiming, scenario
from dmil.seeding import stream
from dmil.simulation import QueueSimulator
from dmil.training import (
    controller_of,
    evaluate,
    load_policy,
    policy_of,
    run,
    save_policy,
    train,
    train_prior,
    vehicles_of_seed,
)
from dmil.training.policies import RETIRED, shapes_of

SCENARIO = scenario("grid:1x2", horizon_s=120)
REWARD = make_reward("entropy")
OPTIONS = {"embedding": "complex", "communication": True, "communication_period_s": 50}


class Spy:
    """Keeps what the loop tells a controller."""

    def __init__(self):
        self.seen = []

    def reset(self, context):
        self.context = context

    def decide(self, observation, reward):
        self.seen.append((observation, reward))
        return np.zeros(len(self.context.network.intersections), np.int32)


def test_the_loop_gives_each_choice_the_reward_of_the_interval_before():
    spy = Spy()
    result = run(
        QueueSimulator(SCENARIO), spy, vehicles_of_seed(SCENARIO, 0), REWARD, stream(0, "x")
    )
    assert [observation.time_s for observation, _ in spy.seen] == list(range(0, 120, 10))
    assert spy.seen[0][1] is None
    for (before, _), (after, reward) in zip(spy.seen, spy.seen[1:], strict=False):
        assert reward == pytest.approx(REWARD(before, after, SCENARIO.network))
    assert result.time_s == (120,)
    assert len(result.memory) == 1


@pytest.mark.parametrize("wrong", [np.zeros(3), np.array([np.nan, 0.0]), np.zeros((2, 1))])
def test_a_reward_that_is_no_reward_is_one_clear_error(wrong):
    with pytest.raises(InputError, match=r"reward: .*one finite number for each of the 2"):
        run(
            QueueSimulator(SCENARIO),
            Spy(),
            vehicles_of_seed(SCENARIO, 0),
            lambda before, after, network: wrong,
            stream(0, "x"),
        )


def test_the_dummy_agent_has_one_exact_table_per_shape():
    prior = train_prior(SCENARIO, REWARD, 0)
    assert prior.table.rows.size.shape == (1,)
    assert prior.table.rows.tolerance == 0
    states = prior.table.rows.keys[0, : prior.table.rows.size[0]]
    assert len(np.unique(states, axis=0)) == len(states) > 5
    again = train_prior(SCENARIO, REWARD, 0)
    assert np.array_equal(again.table.value, prior.table.value)


@pytest.mark.parametrize("name", sorted(REWARDS))
def test_an_agent_starts_from_the_dummy(name):
    reward = REWARDS[name]
    prior = train_prior(SCENARIO, reward, 0)
    rows = int(prior.table.rows.size[0])
    network = SCENARIO.network
    for controller, expected in (("sarsa", rows), ("dual-memory", -(-rows // 2))):
        agent = make_controller(controller, {"embedding": "exact"}, prior=prior)
        agent.reset(RunContext(network, SignalTiming(), stream(0, "x")))
        assert agent.memory_use().entries == expected


def trained(episodes, seed=3):
    controller = make_controller("dual-memory", OPTIONS)
    train(SCENARIO, controller, REWARD, seed, episodes=episodes)
    return controller


def policy(controller, **training):
    return policy_of(
        controller,
        SCENARIO.network,
        name="dual-memory",
        options=OPTIONS,
        reward="entropy",
        training={"scenario": SCENARIO.name} | training,
    )


def test_training_that_goes_on_from_a_file_equals_training_without_a_pause(tmp_path):
    whole = trained(range(4))
    save_policy(policy(trained(range(2))), tmp_path / "half.npz")
    loaded = load_policy(tmp_path / "half.npz")
    resumed = controller_of(loaded, SCENARIO.network, where="half.npz")
    train(SCENARIO, resumed, REWARD, 3, episodes=range(2, 4))
    expected, found = whole.arrays(), resumed.arrays()
    assert expected.keys() == found.keys()
    for name in expected:
        assert np.array_equal(expected[name], found[name]), name


def test_the_same_policy_is_the_same_bytes_and_no_pickle(tmp_path):
    made = policy(trained(range(1)))
    save_policy(made, tmp_path / "one.npz")
    save_policy(made, tmp_path / "two.npz")
    assert (tmp_path / "one.npz").read_bytes() == (tmp_path / "two.npz").read_bytes()
    with np.load(tmp_path / "one.npz", allow_pickle=False) as file:
        header = json.loads(file["header"].tobytes())
    assert header["controller"] == "dual-memory"
    assert header["shapes"] == shapes_of(SCENARIO.network)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["one.npz", "two.npz"]


def test_a_frozen_policy_does_not_change():
    before = policy(trained(range(2)))
    frozen = controller_of(before, SCENARIO.network, where="x", learning=False, epsilon=0.0)
    simulator = QueueSimulator(SCENARIO)
    evaluate(simulator, frozen, vehicles_of_seed(SCENARIO, 9), REWARD, 9)
    after = frozen.arrays()
    for name, array in before.arrays.items():
        assert np.array_equal(array, after[name]), name


def test_policies_that_do_not_fit_are_refused(tmp_path):
    made = policy(trained(range(1)))
    path = tmp_path / "policy.npz"
    with pytest.raises(PolicyError, match=r"policy for 2 intersections.*one for the 4"):
        controller_of(made, scenario("grid:2x2").network, where="policy.npz")
    save_policy(made, path)
    whole = path.read_bytes()

    path.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(PolicyError, match="not a whole policy file"):
        load_policy(path)
    middle = whole.index(b"header.npy") + 40
    path.write_bytes(whole[:middle] + b"\xff" * 20 + whole[middle + 20 :])
    with pytest.raises(PolicyError, match="not a whole policy file"):
        load_policy(path)
    with path.open("wb") as file:
        np.save(file, np.zeros(3))
    with pytest.raises(PolicyError, match="not a whole policy file"):
        load_policy(path)
    np.savez(path, header=np.frombuffer(b'{"format": "other"}', np.uint8))
    with pytest.raises(PolicyError, match="no policy"):
        load_policy(path)
    text = json.dumps({"format": "dmil-policy", "version": 99, "dmil": "9.9"}).encode()
    np.savez(path, header=np.frombuffer(text, np.uint8))
    with pytest.raises(PolicyError, match=r"version 99 of the format, written by dmil 9\.9"):
        load_policy(path)
    with pytest.raises(PolicyError, match="no such file"):
        load_policy(tmp_path / "nowhere.npz")
    with pytest.raises(OutputError, match="cannot be"):
        save_policy(made, path / "inside-a-file.npz")


def test_a_policy_of_another_shape_names_the_intersection():
    made = policy(trained(range(1)))
    other = [made.shapes[0], "another"]
    wrong = type(made)(
        made.controller, made.options, made.reward, other, made.arrays, made.training
    )
    second = SCENARIO.network.intersections[1].id
    with pytest.raises(PolicyError, match=f"another shape at intersection '{second}'"):
        controller_of(wrong, SCENARIO.network, where="policy.npz")


@pytest.mark.parametrize("name", RETIRED)
def test_a_policy_with_an_option_that_is_gone_loads_where_it_changed_nothing(name, tmp_path):
    path = tmp_path / "old.npz"
    made = make_controller(name)
    train(SCENARIO, made, REWARD, 3, episodes=range(1))
    old = policy_of(made, SCENARIO.network, name=name, options={}, reward="entropy", training={})
    arrays = old.arrays
    if name == "factored":
        # What it kept with the option, and without it as an empty array.
        arrays = {**arrays, "square": np.zeros((0, 0), np.float32)}
    save_policy(replace(old, options={"learning": False, **RETIRED[name]}, arrays=arrays), path)
    loaded = load_policy(path)
    assert loaded.options == {"learning": False}
    restored = controller_of(loaded, SCENARIO.network, where=str(path)).arrays()
    assert {key: array.tobytes() for key, array in restored.items()} == {
        key: array.tobytes() for key, array in old.arrays.items()
    }


@pytest.mark.parametrize(
    ("name", "option", "value"),
    [("factored", "evidence", 0.5), ("dual-memory", "stage_untried", True)],
)
def test_a_policy_that_an_option_which_is_gone_has_shaped_is_one_clear_error(
    name, option, value, tmp_path
):
    path = tmp_path / "old.npz"
    save_policy(replace(policy(trained(range(1))), controller=name, options={option: value}), path)
    with pytest.raises(
        PolicyError, match=rf"old\.npz.*trained with {option} = {value}.*gone.*again"
    ):
        load_policy(path)
