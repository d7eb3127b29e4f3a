"""MFEC and PLMP: that they learn, what they keep, and that training can be resumed."""

import numpy as np
import pytest

from dmil.controllers import RunContext, make_controller
from dmil.controllers.episodic.by_shape import ReturnWindow, best_tried
from dmil.errors import DivergedError, PolicyError
from dmil.network import grid
from dmil.rewards import make_reward
from dmil.scenarios import SignalTiming, scenario
from dmil.seeding import stream
from dmil.simulation import Observation
from dmil.testing.proving_grounds import uneven_network
from dmil.training import controller_of, load_policy, policy_of, save_policy, train
from tests.unit.controllers.two_queues import (
    ALTERNATING,
    BUSY,
    STATES,
    best_phases,
    drive,
    trained,
    wrong_states,
)

NAMES = ["mfec", "plmp"]
EACH = pytest.mark.parametrize("name", NAMES)
SLOWLY = {"exploration_part": 0.8, "discount": 0.9, "reach": 0}


def context(network, seed=1):
    return RunContext(network, SignalTiming(), stream(seed))


def observation(queue, time_s=0):
    queue = np.array(queue, np.int32)
    none = np.zeros_like(queue)
    shown = np.zeros(len(queue), np.int32)
    return Observation(queue, none, shown, shown, time_s, none.astype(float))


def practise(controller, network, *, decisions=60, seed=1, mean_veh=0.4):
    """Let a controller decide on queues drawn at random; return its actions."""
    rng, size = stream(seed, "queues"), len(network.intersections)
    most = max(len(item.movements) for item in network.intersections)
    controller.reset(context(network, seed))
    done, earned = [], None
    for k in range(decisions):
        seen = observation(rng.poisson(mean_veh, (size, most)), 10 * k)
        done.append(controller.decide(seen, earned).tolist())
        earned = rng.standard_normal(size)
    return done


@pytest.mark.parametrize(
    ("name", "options", "arrivals", "decisions"),
    [
        ("mfec", {"steps": 3}, ALTERNATING, 4000),
        ("mfec", {"steps": 1}, BUSY, 2000),
        ("plmp", SLOWLY, ALTERNATING, 10_000),
        ("plmp", SLOWLY, BUSY, 14_000),
    ],
)
def test_it_chooses_best_wherever_it_was(name, options, arrivals, decisions):
    frozen, met = trained(
        lambda o: make_controller(name, o), options, arrivals, decisions=decisions
    )
    assert len(set(met)) >= 12
    assert wrong_states(frozen, arrivals, met) == []
    _, stayed = drive(frozen, arrivals, "test", 300)
    _, stayed_by_chance = drive(make_controller("random"), arrivals, "test", 300)
    assert stayed < stayed_by_chance / 4


def test_the_best_choices_are_those_of_the_longest_queue():
    for arrivals in (ALTERNATING, BUSY):
        for state, best in best_phases(arrivals).items():
            first, second = state
            assert state in STATES
            expected = {2} if first > second else {5} if second > first else {2, 5}
            assert best == (set(range(8)) if state == (0, 0) else expected)


def test_mfec_takes_luck_for_merit():
    """Of a sure 1 and a draw of −9 or +2, the maximum of returns prefers the draw."""
    controller = make_controller("mfec", {"steps": 1, "training_decisions": 200})
    controller.reset(context(grid(1, 1)))
    rng, earned = stream(0, "gamble"), None
    for k in range(300):
        action = controller.decide(observation([[1] * 12], 10 * k), earned)[0]
        earned = np.array([rng.choice([-9.0, 2.0]) if action == 0 else 1.0])
    frozen = make_controller("mfec", {"learning": False})
    frozen.reset(context(grid(1, 1)))
    frozen.restore(controller.arrays())
    assert frozen.decide(observation([[1] * 12]), None)[0] == 0


def test_returns_by_hand():
    window = ReturnWindow(2, 0.5)
    window.choose(np.array([1.0, 10.0]))
    assert window.reward(np.array([4.0, 0.0]), np.array([100.0, 100.0])) is None
    window.choose(np.array([2.0, 20.0]))
    (first,), value = window.reward(np.array([2.0, 8.0]), np.array([16.0, 0.0]))
    # 4 + ½·2 + ¼·16, and 0 + ½·8 + ¼·0
    assert (first.tolist(), value.tolist()) == ([1.0, 10.0], [9.0, 4.0])
    window.choose(np.array([3.0, 30.0]))
    (second,), value = window.reward(np.array([1.0, 1.0]), 0.0)
    assert (second.tolist(), value.tolist()) == ([2.0, 20.0], [2.5, 8.5])


def test_the_value_of_a_state_is_its_best_tried_one():
    inf = np.inf
    value = np.array([[inf, -3.0, -2.0], [inf, inf, inf], [-inf, -5.0, inf], [-inf, -inf, -inf]])
    assert best_tried(value).tolist() == [-2.0, 0.0, -5.0, 0.0]


def test_mfec_by_hand():
    """n = 1: an entry keeps its phase's largest reward; a new state gets that of its neighbour."""
    controller = make_controller("mfec", {"steps": 1, "epsilon_first": 0.0, "epsilon_last": 0.0})
    controller.reset(context(grid(1, 1)))
    rng, best, found, last, reward = stream(0, "rewards"), {}, 0, None, None
    for k in range(60):
        found += len(best)
        action = int(controller.decide(observation([[0, 3] + [0] * 10], 10 * k), reward)[0])
        # What was never tried comes first; the last reward is learned after the look-up.
        assert action not in best if len(best) < 8 else best[action] == max(best.values())
        if reward is not None:
            best[last] = max(best.get(last, -np.inf), reward[0])
        last, reward = action, rng.standard_normal(1)
    assert len(best) == controller.memory_use().entries_total == 8
    assert controller.arrays()["value"].tolist() == [best[action] for action in range(8)]
    assert controller.lookups() == {"exact": found, "neighbours": 0, "untried": 8 * 60 - found}
    # Another state is taken for its only neighbour; right turns make no other state.
    assert best[int(controller.decide(observation([[5, 4] + [0] * 10]), None)[0])] == max(
        best.values()
    )
    assert controller.lookups()["neighbours"] == 8
    controller.decide(observation([[5, 3] + [0] * 10]), None)
    assert controller.lookups()["neighbours"] == 8


@EACH
def test_a_resumed_training_is_an_uninterrupted_one(name, tmp_path):
    made, reward = scenario("grid:1x2", horizon_s=900), make_reward("queue")
    options = {"capacity": 40, "training_decisions": 200}

    def save(controller, to):
        policy = policy_of(
            controller, made.network, name=name, options=options, reward="queue", training={}
        )
        save_policy(policy, tmp_path / to)

    whole, begun = make_controller(name, options), make_controller(name, options)
    train(made, whole, reward, 3, episodes=range(3))
    train(made, begun, reward, 3, episodes=range(1))
    save(begun, "begun.npz")
    resumed = controller_of(load_policy(tmp_path / "begun.npz"), made.network, where="")
    train(made, resumed, reward, 3, episodes=range(1, 3))
    save(whole, "whole.npz")
    save(resumed, "resumed.npz")
    assert (tmp_path / "whole.npz").read_bytes() == (tmp_path / "resumed.npz").read_bytes()
    # The memory was full, so what leaves is the same, too.
    assert whole.memory_use().entries_total >= 40
    assert whole.memory_use() == resumed.memory_use()


@EACH
def test_loading_replaces_and_never_adds(name):
    network = grid(1, 2)
    first, second = make_controller(name), make_controller(name)
    practise(first, network)
    practise(second, network, seed=2)
    second.restore(first.arrays())
    second.restore(first.arrays())
    assert second.memory_use() == first.memory_use()
    for key, array in first.arrays().items():
        assert second.arrays()[key].tobytes() == array.tobytes()


@EACH
def test_a_frozen_controller_does_not_change(name):
    network = grid(1, 2)
    learned = make_controller(name)
    practise(learned, network)
    frozen = make_controller(name, {"learning": False})
    frozen.reset(context(network))
    frozen.restore(learned.arrays())
    practise(frozen, network, seed=4)
    for key, array in learned.arrays().items():
        assert frozen.arrays()[key].tobytes() == array.tobytes()


@EACH
def test_intersections_of_one_shape_share_their_memory(name):
    network = uneven_network()
    controller = make_controller(name)
    practise(controller, grid(1, 1))
    alone = controller.memory_use()
    practise(controller, grid(2, 2), seed=2)
    use = controller.memory_use()
    assert use.entries == use.entries_total > alone.entries
    with pytest.raises(PolicyError, match="other shapes"):
        controller.reset(context(network))
    # Three shapes have three memories: an agent's own is a part of all.
    controller = make_controller(name)
    practise(controller, network)
    use = controller.memory_use()
    assert use.entries == pytest.approx(use.entries_total / 3)


@EACH
def test_arrays_of_another_controller_are_refused(name):
    saved, other = make_controller(name), make_controller(name)
    practise(saved, grid(1, 1))
    practise(other, uneven_network())
    before = other.memory_use()
    with pytest.raises(PolicyError):
        other.restore(saved.arrays())
    with pytest.raises(PolicyError):
        other.restore({})
    missing = {key: array for key, array in saved.arrays().items() if key != "decisions"}
    with pytest.raises(PolicyError, match="decisions"):
        saved.restore(missing)
    assert other.memory_use() == before


@EACH
def test_rewards_beyond_all_numbers_stop_the_run(name):
    controller, reward = make_controller(name, {"discount": 0.999}), None
    controller.reset(context(grid(1, 1)))
    with pytest.raises(DivergedError, match=f"'{name}' diverged at [0-9]+ s"):
        for k in range(100):
            controller.decide(observation([[0] * 12], 10 * k), reward)
            reward = np.array([1.5e308])


def test_numbers_that_are_none_are_not_loaded():
    saved = make_controller("mfec", {"steps": 2})
    practise(saved, grid(1, 1))
    arrays = {key: array.copy() for key, array in saved.arrays().items()}
    arrays["value"][0] = np.nan
    with pytest.raises(PolicyError, match="'value'"):
        saved.restore(arrays)
