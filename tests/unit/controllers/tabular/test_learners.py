"""The learners' life: what begin keeps, what does not fit, saving, memory in use."""

from dataclasses import replace

import numpy as np
import pytest
from pydantic import ValidationError

from dmil.controllers import MemoryController, Prior, RunContext, make_controller
from dmil.controllers.tabular.agents import agents_of
from dmil.controllers.tabular.choice import explores, greedy_action, uniform_action
from dmil.controllers.tabular.dual_memory import DualMemoryController
from dmil.controllers.tabular.meetings import NEWS, Meetings
from dmil.controllers.tabular.sarsa import SarsaController
from dmil.controllers.tabular.settings import (
    DualMemorySettings,
    LearnerSettings,
    SarsaSettings,
)
from dmil.errors import PolicyError
from dmil.network import RoadNetwork, grid
from dmil.rewards import make_reward
from dmil.scenarios import SignalTiming, scenario
from dmil.seeding import stream
from dmil.simulation import Observation, QueueSimulator
from dmil.training import run, vehicles_of_seed

LEARNERS = ["sarsa", "dual-memory"]
EACH = pytest.mark.parametrize("name", LEARNERS)


def context(network, seed=1):
    return RunContext(network, SignalTiming(), stream(seed))


def observation(queue, time_s=0):
    queue = np.array(queue, np.int32)
    empty = np.zeros(len(queue), np.int32)
    return Observation(queue, np.zeros_like(queue), empty, empty, time_s, np.zeros(queue.shape))


def practise(controller, network, *, decisions=40, seed=1, begins=True):
    """Let a controller decide on queues drawn at random; return its actions."""
    rng = stream(seed, "queues")
    if begins:
        controller.reset(context(network, seed))
    done, reward = [], None
    for k in range(decisions):
        seen = observation(rng.poisson(1.0, (len(network.intersections), 12)), 10 * k)
        done.append(controller.decide(seen, reward).tolist())
        reward = rng.standard_normal(len(network.intersections))
    return done


def other_phases(network):
    """Return a network whose first intersection lacks its last phase."""
    first, *rest = network.intersections
    return replace(network, intersections=(replace(first, phases=first.phases[:-1]), *rest))


def test_values_by_hand():
    """ε = 0, learning rate ½, discount ½: Q ← Q + ½(r + ½Q′ − Q)."""
    network = grid(1, 1)
    options = {"epsilon": 0.0, "learning_rate": 0.5, "discount": 0.5}
    first, second = [[5] + [0] * 11], [[0] * 11 + [5]]
    for controller, stored in (
        (SarsaController(SarsaSettings(**options)), lambda c: c.table),
        (DualMemoryController(DualMemorySettings(**options)), lambda c: c.memory.short),
    ):
        controller.reset(context(network))
        assert isinstance(controller, MemoryController)
        a = int(controller.decide(observation(first), None)[0])
        # Nothing to learn from yet.
        assert controller.memory_use().entries == 0
        b = int(controller.decide(observation(second), np.array([2.0]))[0])
        # Q(first, a) = 0 + ½(2 + ½·0 − 0)
        assert stored(controller).value[0, 0, a] == 1.0
        assert controller.decide(observation(first), np.array([4.0]))[0] == a
        # Q(second, b) = 0 + ½(4 + ½·1 − 0), for a is the best action of the first state again
        assert stored(controller).value[0, 1, b] == 2.25
        assert controller.decide(observation(second), np.array([-1.0]))[0] == b
        # Q(first, a) = 1 + ½(−1 + ½·2.25 − 1)
        assert stored(controller).value[0, 0, a] == 1.0 + 0.5 * (-1.0 + 0.5 * 2.25 - 1.0)
        assert stored(controller).tried[0].sum() == 2
        assert stored(controller).visits[0, :2].tolist() == [2, 1]


@EACH
def test_what_was_learned_stays_over_runs_on_the_same_shapes(name):
    controller = make_controller(name)
    practise(controller, grid(2, 2))
    before = {key: array.copy() for key, array in controller.arrays().items()}
    controller.reset(context(replace(grid(2, 2), name="the same by another name")))
    after = controller.arrays()
    assert all(np.array_equal(after[key], array) for key, array in before.items())
    practise(controller, grid(2, 2), seed=2)
    assert (
        controller.memory_use().entries_total
        > before["size" if name == "sarsa" else "long.size"].sum()
    )


@EACH
@pytest.mark.parametrize(
    "network", [grid(2, 3), grid(1, 1), other_phases(grid(2, 2))], ids=["more", "fewer", "others"]
)
def test_other_shapes_after_learning_are_an_error(name, network: RoadNetwork):
    controller = make_controller(name)
    practise(controller, grid(2, 2))
    memory = controller.memory_use()
    with pytest.raises(PolicyError, match="other shapes"):
        controller.reset(context(network))
    # Nothing is lost: it goes on where it learned.
    assert controller.memory_use() == memory
    practise(controller, grid(2, 2), begins=False)


def test_shared_tables_go_with_any_number_of_agents_of_their_shapes():
    controller = SarsaController(SarsaSettings(shared=True))
    practise(controller, grid(1, 1))
    practise(controller, grid(3, 3))
    assert controller.table.rows.size.shape == (1,)
    with pytest.raises(PolicyError, match="other shapes"):
        controller.reset(context(other_phases(grid(3, 3))))


@EACH
def test_a_prior_of_other_shapes_is_an_error(name):
    dummy = SarsaController(SarsaSettings(shared=True))
    practise(dummy, other_phases(grid(1, 2)))
    controller = make_controller(name, prior=Prior(dummy.table))
    with pytest.raises(PolicyError, match="2 shapes with up to 12 movements"):
        controller.reset(context(grid(2, 2)))
    classes = SarsaController(SarsaSettings(shared=True, embedding="simple"))
    practise(classes, grid(2, 2))
    controller = make_controller(name, prior=Prior(classes.table))
    with pytest.raises(PolicyError, match="exact"):
        controller.reset(context(grid(2, 2)))


@EACH
@pytest.mark.parametrize("embedding", ["exact", "simple", "complex", "cells"])
def test_a_restored_controller_goes_on_as_the_saved_one(name, embedding):
    network = grid(2, 2)
    options = {"embedding": embedding, "communication": True, "epsilon": 0.3}
    original = make_controller(name, options)
    practise(original, network, decisions=55)
    copy = make_controller(name, options)
    copy.reset(context(network))
    copy.restore({key: array.copy() for key, array in original.arrays().items()})
    done = practise(original, network, decisions=45, seed=7)
    assert practise(copy, network, decisions=45, seed=7) == done
    for key, array in original.arrays().items():
        assert copy.arrays()[key].tobytes() == array.tobytes()
    assert copy.memory_use() == original.memory_use()


@EACH
def test_arrays_of_another_network_cannot_be_restored(name):
    saved, other = make_controller(name), make_controller(name)
    practise(saved, grid(2, 2))
    other.reset(context(grid(1, 3)))
    with pytest.raises(PolicyError, match="expected 3 numbers of rows"):
        other.restore(saved.arrays())
    with pytest.raises(PolicyError, match="missing"):
        other.restore({})


@EACH
def test_rows_that_are_not_in_common_are_refused(name):
    saved, other = make_controller(name), make_controller(name)
    practise(saved, grid(2, 2))
    other.reset(context(grid(2, 2)))
    for wrong in (-1, 10**6):
        with pytest.raises(PolicyError, match="do not have in common"):
            other.restore({**saved.arrays(), "common": np.array([wrong], np.int32)})


def test_a_larger_short_term_memory_is_staged_when_restored_into_a_smaller():
    """The long-term memory must have room for more rows than the smaller one could stage."""
    large = DualMemoryController(DualMemorySettings(short_capacity=500, embedding="exact"))
    practise(large, grid(1, 1), decisions=400)
    held = int(large.memory.short.rows.size[0])
    small = DualMemoryController(
        DualMemorySettings(short_capacity=4, embedding="exact", staged_ratio=1.0)
    )
    small.reset(context(grid(1, 1)))
    small.restore(large.arrays())
    practise(small, grid(1, 1), decisions=2, seed=3)
    assert small.memory.short.rows.size[0] == 0
    assert small.memory.long.rows.size[0] >= held > 300
    assert small.memory.long.value.shape[1] >= held


@EACH
def test_a_frozen_controller_does_not_change(name):
    learned = make_controller(name)
    practise(learned, grid(1, 2))
    frozen = make_controller(name, {"learning": False, "communication": True})
    frozen.reset(context(grid(1, 2)))
    frozen.restore(learned.arrays())
    practise(frozen, grid(1, 2), seed=4)
    for key, array in learned.arrays().items():
        assert frozen.arrays()[key].tobytes() == array.tobytes()


def test_memory_in_use_is_counted_as_in_the_paper():
    network = other_phases(grid(1, 2))
    sarsa = SarsaController()
    practise(sarsa, network)
    sizes = sarsa.table.rows.size
    use = sarsa.memory_use()
    assert use.entries == use.table_entries == sizes.mean() > 10
    # |A|·m_Q: the first intersection has 7 phases, the second 8.
    assert use.msize == (7 * sizes[0] + 8 * sizes[1]) / 2
    assert use.entries_total == sizes.sum()
    dual = DualMemoryController()
    practise(dual, network)
    short, long = dual.memory.short.rows.size, dual.memory.long.rows.size
    use = dual.memory_use()
    assert (use.short_term_entries, use.long_term_entries) == (short.mean(), long.mean())
    assert use.msize == (3 * long.sum() + 7 * short[0] + 8 * short[1]) / 2
    assert use.entries_total == short.sum() + long.sum() > 0
    shared = SarsaController(SarsaSettings(shared=True))
    practise(shared, grid(1, 2))
    use = shared.memory_use()
    # Counted once, and as what every agent can read.
    assert use.entries_total == shared.table.rows.size[0] == use.table_entries


def test_epsilon_decays_from_decision_to_decision_and_starts_anew():
    """With ε = 1 halved every decision, the share of random choices halves."""
    network = grid(1, 1)
    state, decisions = [[5] + [0] * 11], 6
    explored = np.zeros(decisions)
    controller = SarsaController(SarsaSettings(epsilon=1.0, epsilon_decay=0.5, learning=True))
    controller.reset(context(network))
    best = int(controller.decide(observation(state), None)[0])
    controller.decide(observation(state), np.array([100.0]))
    arrays = controller.arrays()
    frozen = SarsaController(SarsaSettings(epsilon=1.0, epsilon_decay=0.5, learning=False))
    for seed in range(800):
        frozen.reset(context(network, seed))
        if seed == 0:
            frozen.restore(arrays)
        for k in range(decisions):
            explored[k] += frozen.decide(observation(state), None)[0] != best
    # A random choice is the best one in one of eight cases.
    expected = 800 * 0.5 ** np.arange(decisions) * 7 / 8
    assert (np.abs(explored - expected) < 4 * np.sqrt(expected)).all()


def test_choices_from_draws():
    assert [uniform_action(draw, 4) for draw in (0.0, 0.249, 0.25, 0.999999)] == [0, 0, 1, 3]
    # The largest draw there is, one step below 1, times a count never rounds up to the count.
    largest = np.nextafter(1.0, 0.0)
    assert all(uniform_action(largest, count) == count - 1 for count in range(1, 2000))
    assert explores(np.array([0.3, 0.0, 0.0]), 0.31)
    assert not explores(np.array([0.3, 0.0, 0.0]), 0.3)
    assert not explores(np.array([0.0, 0.0, 0.0]), 0.0)
    value = np.array([0.0, 2.0, -1.0, 2.0])
    straight, turned = np.arange(4, dtype=np.int32), np.array([3, 0, 1, 2], np.int32)
    assert [greedy_action(value, straight, 4, draw) for draw in (0.0, 0.49, 0.5, 0.9)] == [
        1,
        1,
        3,
        3,
    ]
    # Action 0 stands in place 3, action 2 in place 1.
    assert [greedy_action(value, turned, 4, draw) for draw in (0.0, 0.9)] == [0, 2]
    # Places beyond the shape's actions do not count.
    assert greedy_action(value, straight, 3, 0.9) == 1
    assert greedy_action(-np.ones(1), straight[:1], 1, 0.5) == 0


def test_agents_meet_once_per_period():
    def times(interval_s, **options):
        meetings, news = Meetings(LearnerSettings(**options), 1), np.zeros((2, NEWS))
        return [t for t in range(0, 500, interval_s) if meetings.due(0, t, news, np.arange(2))]

    assert times(10) == [100, 200, 300, 400]
    assert times(10, communication_period_s=5) == list(range(10, 500, 10))
    assert times(70) == [140, 210, 350, 420]


@pytest.mark.parametrize(
    "wrong",
    [
        {"epsilon": 1.1},
        {"epsilon_decay": 0.0},
        {"discount": -0.1},
        {"communication_period_s": 0},
        {"short_capacity": 0},
        {"staged_ratio": 0.0},
        {"staging": "newest"},
        {"stage_period": -1},
        {"eps": 0.1},
    ],
    ids=str,
)
def test_settings_out_of_range_are_refused(wrong):
    with pytest.raises(ValidationError):
        DualMemorySettings(**wrong)


def test_agents_of_equal_shape_are_members_of_one_group():
    agents = agents_of(other_phases(grid(2, 2)))
    assert agents.shape.tolist() == [0, 1, 1, 1]
    assert [members.tolist() for members in agents.members] == [[0], [1, 2, 3]]
    assert len(set(agents.signatures)) == 2
    # Without (S, F+L) a quarter turn no longer fits.
    assert [group.size for group in agents.groups] == [1, 4]


@pytest.mark.parametrize("name", ["sarsa", "dual-memory"])
def test_rows_shared_through_the_central_unit_count_once(name):
    made = scenario("grid:2x2", horizon_s=200)
    controller = make_controller(name, {"embedding": "simple", "communication": True})
    if name == "dual-memory":
        controller = make_controller(
            name, {"embedding": "simple", "communication": True, "short_capacity": 2}
        )
    run(
        QueueSimulator(made),
        controller,
        vehicles_of_seed(made, 0),
        make_reward("entropy"),
        stream(0, "x"),
    )
    controller._meet(0)
    use = controller.memory_use()
    per_agent = use.table_entries + use.long_term_entries
    assert per_agent > 1
    assert use.entries_total == per_agent + 4 * use.short_term_entries
