"""NEC: that it learns, what moves its embedding, and that training can be resumed."""

import numpy as np
import pytest
import torch

from dmil.controllers import RunContext, make_controller
from dmil.controllers.deep.nec import NecController
from dmil.controllers.deep.network import features
from dmil.controllers.deep.settings import NecSettings
from dmil.errors import DivergedError, PolicyError
from dmil.network import grid
from dmil.rewards import make_reward
from dmil.scenarios import SignalTiming, scenario
from dmil.seeding import stream
from dmil.simulation import Observation
from dmil.testing.proving_grounds import uneven_network
from dmil.training import controller_of, load_policy, policy_of, save_policy, train
from tests.unit.controllers.two_queues import ALTERNATING, drive, trained, wrong_states

NETWORK = grid(1, 2)


def practise(controller, network=NETWORK, *, decisions=60, seed=1):
    """Let a controller decide on queues drawn at random; return its actions."""
    rng, size = stream(seed, "queues"), len(network.intersections)
    most = max(len(item.movements) for item in network.intersections)
    controller.reset(RunContext(network, SignalTiming(), stream(seed)))
    done, earned = [], None
    for k in range(decisions):
        queue = rng.poisson(0.4, (size, most)).astype(np.int32)
        shown = np.zeros(size, np.int32)
        seen = Observation(queue, queue, shown, shown, 10 * k, queue.astype(float))
        done.append(controller.decide(seen, earned).tolist())
        earned = rng.standard_normal(size)
    return done


def test_it_chooses_best_wherever_it_was():
    def make(options):
        return make_controller("nec", options)

    options = {"steps": 2, "train_every": 4, "exploration_part": 0.8}
    frozen, met = trained(make, options, ALTERNATING, decisions=1800)
    # A wrong choice makes another state occur, so these are all that it can come to.
    occurring, stayed = drive(frozen, ALTERNATING, "test", 300)
    assert wrong_states(frozen, ALTERNATING, occurring) == []
    # The nearest entry of a state is a single return, so chance may rule where it rarely was.
    assert len(set(met)) >= 12
    assert len(wrong_states(frozen, ALTERNATING, met)) <= 2
    _, stayed_by_chance = drive(make_controller("random"), ALTERNATING, "test", 300)
    assert stayed < stayed_by_chance / 4


def test_a_resumed_training_is_an_uninterrupted_one(tmp_path):
    made, reward = scenario("grid:1x2", horizon_s=900), make_reward("queue")
    options = {"capacity": 40, "training_decisions": 200, "buffer_capacity": 150}

    def save(controller, to):
        policy = policy_of(
            controller, made.network, name="nec", options=options, reward="queue", training={}
        )
        save_policy(policy, tmp_path / to)

    whole, begun = make_controller("nec", options), make_controller("nec", options)
    train(made, whole, reward, 3, episodes=range(3))
    train(made, begun, reward, 3, episodes=range(1))
    save(begun, "begun.npz")
    resumed = controller_of(load_policy(tmp_path / "begun.npz"), made.network, where="")
    train(made, resumed, reward, 3, episodes=range(1, 3))
    save(whole, "whole.npz")
    save(resumed, "resumed.npz")
    assert (tmp_path / "whole.npz").read_bytes() == (tmp_path / "resumed.npz").read_bytes()
    # Dictionaries and replay were full, so what leaves is the same, too.
    assert whole.memory_use().entries_total > 200
    assert whole.arrays()["0.replay.written"] > 150


def test_what_is_learned_through_is_what_is_looked_up():
    controller = NecController(NecSettings(neighbours=5, batch_size=1000))
    practise(controller, decisions=120)
    rng = stream(1, "states")
    state = rng.poisson(0.4, (6, 8))
    embedding = controller._networks[0](features(state))
    key = embedding.detach().numpy()
    tables = np.arange(6, dtype=np.int32)
    assert (controller._entries.size[:6] > 5).all()
    mean = controller._mean(embedding, tables, key)
    arrays = controller.arrays()
    begin = np.concatenate([[0], np.cumsum(arrays["entries.size"])])
    for row, table in enumerate(tables.tolist()):
        part = slice(begin[table], begin[table + 1])
        keys, values = arrays["entries.keys"][part], arrays["entries.value"][part]
        distance = np.square(keys.astype(float) - key[row]).sum(axis=1)
        near = np.argsort(distance)[:5]
        weight = 1 / (distance[near] + 1e-3)
        expected = (weight * values[near]).sum() / weight.sum()
        assert mean[row].item() == pytest.approx(expected, rel=1e-4)
    # The acting look-up gives the same.
    value = controller._recalled(key[:2])
    assert value[0, 0] == pytest.approx(mean[0].item(), rel=1e-4)
    assert value[1, 1] == pytest.approx(mean[1].item(), rel=1e-4)


def test_the_gradient_of_a_look_up_is_the_slope_of_its_value():
    controller = NecController(NecSettings(neighbours=5, softening=0.1))
    practise(controller)
    key = controller._embeddings(np.ones((2, 8), np.int32))[:1]
    table = np.zeros(1, np.int32)

    def mean_at(point):
        return controller._mean(torch.from_numpy(point), table, key).item()

    point = torch.from_numpy(key.copy()).requires_grad_()
    (gradient,) = torch.autograd.grad(controller._mean(point, table, key)[0], point)
    for place in range(3):
        step = np.zeros_like(key)
        step[0, place] = 1e-2
        slope = (mean_at(key + step) - mean_at(key - step)) / 2e-2
        assert gradient[0, place].item() == pytest.approx(slope, rel=0.05, abs=1e-3)


def test_learning_brings_look_ups_nearer_to_the_returns():
    def error(controller):
        replay = controller._replays[0]
        rows = np.arange(replay.size)
        table = replay.take("action", rows).astype(np.int32)
        embedding = controller._networks[0](features(replay.take("state", rows)))
        mean = controller._mean(embedding, table, embedding.detach().numpy())
        return (mean - torch.from_numpy(replay.take("outcome", rows))).square().mean().item()

    controller = NecController(NecSettings(steps=1, train_every=10**6, neighbours=10))
    practise(controller, decisions=300)
    # The embedding has moved since these keys were stored, or it would find itself.
    controller._networks[0].weights.data.mul_(1.3)
    before = error(controller)
    for _ in range(100):
        controller._train()
    assert error(controller) < 0.8 * before


def test_a_frozen_controller_does_not_change():
    learned = make_controller("nec")
    practise(learned)
    frozen = make_controller("nec", {"learning": False})
    frozen.reset(RunContext(NETWORK, SignalTiming(), stream(2)))
    frozen.restore(learned.arrays())
    practise(frozen, seed=4)
    for name, array in learned.arrays().items():
        assert frozen.arrays()[name].tobytes() == array.tobytes()
    assert frozen.lookups()["neighbours"] == 60 * 2 * 8


def test_loading_replaces_and_never_adds():
    first, second = make_controller("nec"), make_controller("nec")
    practise(first)
    practise(second, seed=2)
    second.restore(first.arrays())
    second.restore(first.arrays())
    assert second.memory_use() == first.memory_use()
    for name, array in first.arrays().items():
        assert second.arrays()[name].tobytes() == array.tobytes()


def test_arrays_of_another_network_are_refused():
    saved, other = make_controller("nec"), make_controller("nec")
    practise(saved)
    practise(other, uneven_network(), decisions=5)
    with pytest.raises(PolicyError):
        other.restore(saved.arrays())
    with pytest.raises(PolicyError):
        other.restore({})


def test_numbers_that_are_none_stop_the_run():
    controller = make_controller("nec")
    practise(controller, decisions=5)
    controller._networks[0].weights.data[3] = float("nan")
    with pytest.raises(DivergedError, match="'nec' diverged at 0 s: embeddings"):
        practise(controller, decisions=5)
