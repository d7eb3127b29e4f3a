"""Where the tabular learners found the states they met."""

import pytest

from dmil.controllers import make_controller
from dmil.rewards import make_reward
from dmil.scenarios import scenario
from dmil.simulation import QueueSimulator
from dmil.training import evaluate, vehicles_of_seed

HORIZON_S = 600


@pytest.mark.parametrize(
    ("controller", "names"),
    [
        ("sarsa", {"unseen", "table"}),
        ("dual-memory", {"unseen", "short-term", "long-term", "both"}),
    ],
)
def test_every_decision_of_every_agent_is_counted_once(controller, names):
    made = scenario("grid:1x2", horizon_s=HORIZON_S)
    simulator, vehicles = QueueSimulator(made), vehicles_of_seed(made, 0)
    learner = make_controller(controller, {"embedding": "complex"})
    assert set(learner.lookups()) == names
    assert sum(learner.lookups().values()) == 0
    counts = []
    for _ in range(2):
        evaluate(simulator, learner, vehicles, make_reward("queue"), 0)
        counts.append(learner.lookups())
    decisions = 2 * HORIZON_S // made.timing.decision_interval_s
    assert [sum(count.values()) for count in counts] == [decisions, 2 * decisions]
    # The same vehicles again: what was seen once is found.
    again = counts[1]["unseen"] - counts[0]["unseen"]
    assert 0 <= again < counts[0]["unseen"]


def test_a_table_that_learns_nothing_finds_nothing():
    made = scenario("grid:1x1", horizon_s=HORIZON_S)
    learner = make_controller("sarsa", {"learning": False})
    evaluate(QueueSimulator(made), learner, vehicles_of_seed(made, 0), make_reward("queue"), 0)
    assert learner.lookups() == {"unseen": 60, "table": 0}
