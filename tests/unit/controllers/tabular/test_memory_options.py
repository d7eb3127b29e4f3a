"""Options of the dual memory: prior for unseen states, cap, saving with every one of them."""

from dataclasses import replace

import numpy as np
import pytest

from dmil.controllers import RunContext, make_controller
from dmil.errors import InputError, PolicyError
from dmil.rewards import make_reward
from dmil.scenarios import SignalTiming, scenario
from dmil.seeding import stream
from dmil.simulation import Observation, QueueSimulator
from dmil.testing import check_controller
from dmil.testing.proving_grounds import proving_grounds
from dmil.training import train, train_prior

# All intersections differ, and the network is small.
UNEVEN = replace(proving_grounds()[-1], horizon_s=150)
FULL = {
    "long_capacity": 9,
    "short_capacity": 4,
    "staging": "visits",
    "least_tried": 2,
    "unseen": "longest-queue",
    "communication": True,
    "communication_period_s": 50,
}
EACH = [
    {"long_capacity": 7},
    {"long_capacity": 3, "short_capacity": 2, "communication": True, "communication_period_s": 40},
    {"unseen": "longest-queue"},
    {"unseen": "nearest", "long_capacity": 4, "short_capacity": 3},
    {"staging": "visits", "short_capacity": 3},
    {"least_tried": 2},
    FULL,
]


def observed(queue, phase, time_s=0):
    counts = np.zeros_like(queue)
    return Observation(queue, counts, phase, 0 * phase, time_s, counts.astype(float))


@pytest.mark.parametrize("options", EACH, ids=str)
def test_our_controllers_conform_with_every_option(options):
    check_controller(lambda: make_controller("dual-memory", {"epsilon": 0.2, **options}), UNEVEN)


@pytest.mark.parametrize("name", ["sarsa", "dual-memory"])
def test_who_knows_nothing_is_longest_queue_first(name, mixed_network, tee):
    options = {"unseen": "longest-queue", "learning": False, "epsilon": 0.0}
    for network in (mixed_network, tee):
        rng = stream(1, "queues", network.name)
        rivals = [make_controller(name, options), make_controller("longest-queue-first")]
        for each in rivals:
            each.reset(RunContext(network, SignalTiming(), stream(1)))
        nodes = network.intersections
        queue = np.zeros((len(nodes), max(len(node.movements) for node in nodes)), np.int32)
        for k in range(40):
            for i, node in enumerate(nodes):
                # Small counts, so that phases are often equally good.
                queue[i, : len(node.movements)] = rng.integers(0, 3, len(node.movements))
            shown = np.array([rng.integers(-1, len(node.phases)) for node in nodes], np.int32)
            seen = observed(queue, shown, 10 * k)
            mine, theirs = (each.decide(seen, None).tolist() for each in rivals)
            assert mine == theirs


def test_sarsa_conforms_with_every_rule_for_unseen_states():
    for unseen in ("longest-queue", "nearest"):
        options = {"unseen": unseen, "epsilon": 0.2}
        check_controller(lambda o=options: make_controller("sarsa", o), UNEVEN)


@pytest.mark.parametrize("options", EACH, ids=str)
def test_resumed_training_is_uninterrupted_training(options):
    made = scenario("grid:1x2", horizon_s=300)
    simulator, reward = QueueSimulator(made), make_reward("queue")
    prior = train_prior(made, reward, 1, simulator=simulator)

    def agent():
        return make_controller("dual-memory", options, prior=prior)

    whole, first, second = agent(), agent(), agent()
    train(made, whole, reward, 1, episodes=range(4), simulator=simulator)
    train(made, first, reward, 1, episodes=range(2), simulator=simulator)
    second.reset(RunContext(made.network, made.timing, stream(9)))
    second.restore({name: array.copy() for name, array in first.arrays().items()})
    train(made, second, reward, 1, episodes=range(2, 4), simulator=simulator)
    expected, found = whole.arrays(), second.arrays()
    assert found.keys() == expected.keys()
    for name, array in expected.items():
        assert found[name].tobytes() == array.tobytes(), name
    assert whole.memory_use() == second.memory_use()


def trained(options, network=None):
    made = scenario("grid:1x2", horizon_s=600)
    controller = make_controller("dual-memory", options)
    train(made, controller, make_reward("queue"), 1, episodes=range(2))
    return made, controller


def test_a_memory_goes_from_one_cap_to_another_only_where_it_fits():
    made, free = trained({"short_capacity": 2})
    _, capped = trained({"short_capacity": 2, "long_capacity": 5})
    assert free.memory_use().long_term_entries > 5 >= capped.memory_use().long_term_entries
    assert not [name for name in free.arrays() if name.startswith("admission")]
    # The cap may be lifted.
    fresh = make_controller("dual-memory", {"short_capacity": 2})
    fresh.reset(RunContext(made.network, made.timing, stream(1)))
    fresh.restore(capped.arrays())
    expected = capped.memory_use().long_term_entries
    assert fresh.memory_use().long_term_entries == expected
    # What does not fit under it is refused, with a cure.
    other = make_controller("dual-memory", {"short_capacity": 2, "long_capacity": 5})
    other.reset(RunContext(made.network, made.timing, stream(1)))
    with pytest.raises(PolicyError, match="at most long_capacity = 5"):
        other.restore(free.arrays())


def test_what_is_counted_for_the_cap_is_memory_too():
    _, free = trained({"short_capacity": 2})
    _, roomy = trained({"short_capacity": 2, "long_capacity": 4000})
    one, other = free.memory_use(), roomy.memory_use()
    assert one.entries_total == other.entries_total
    # Per agent 4 × 16,384 counters of half a byte, 4,000 marks of 8 bytes and three numbers.
    assert other.bytes_total - one.bytes_total == 2 * (4 * 16384 // 2 + 8 * 4000 + 3 * 4)


@pytest.mark.parametrize(
    ("option", "value", "message"),
    [
        ("unseen", "longest", "'random', 'longest-queue' or 'nearest'"),
        ("long_capacity", -1, "greater than or equal to 0"),
        ("long_capacity", 10**6, "less than or equal to 100000"),
        ("least_tried", 0, "greater than or equal to 1"),
        ("long_capacty", 5, "long_capacity"),
    ],
)
def test_options_that_cannot_be_used_are_refused(option, value, message):
    with pytest.raises(InputError) as error:
        make_controller("dual-memory", {option: value})
    assert message in str(error.value)
