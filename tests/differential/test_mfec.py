"""MFEC's decisions against plain Python: returns, neighbours, what leaves."""

import numpy as np
import pytest

from dmil.controllers import RunContext, make_controller
from dmil.controllers.tabular.choice import DRAWS
from dmil.network import grid
from dmil.scenarios import SignalTiming
from dmil.seeding import stream
from dmil.simulation import Observation
from dmil.testing.proving_grounds import uneven_network

NETWORKS = {"grid": grid(2, 2), "uneven": uneven_network()}
DECISIONS = 120


class PlainMfec:
    """Dictionaries from states to (value, time of last use, number of the entry)."""

    def __init__(self, network, shapes, *, steps, discount, bootstrap, neighbours, capacity):
        self.phases = [len(item.phases) for item in network.intersections]
        self.shapes, self.steps, self.discount = shapes, steps, discount
        self.bootstrap, self.neighbours, self.capacity = bootstrap, neighbours, capacity
        self.tables, self.window, self.time = {}, [], 0

    def decide(self, states, reward, draws, epsilon):
        worth = [self.values(i, state) for i, state in enumerate(states)]
        chosen = []
        for i, values in enumerate(worth):
            best = [phase for phase, value in enumerate(values) if value == max(values)]
            greedy = best[int(draws[i, 2] * len(best))]
            explores = draws[i, 0] < epsilon
            chosen.append(int(draws[i, 1] * self.phases[i]) if explores else greedy)
        if reward is not None:
            self.window[-1].append(reward)
            self.learn(worth)
        self.window.append([states, chosen])
        return chosen

    def values(self, i, state):
        found = []
        for phase in range(self.phases[i]):
            table = self.tables.setdefault((self.shapes[i], phase), {})
            if not table:
                found.append(np.inf)
                continue
            self.time += 1
            read = [state]
            if state not in table:
                here = np.array(state)
                far = {other: int(np.square(here - other).sum()) for other in table}
                read = sorted(table, key=lambda other: (far[other], table[other][2]))
                read = read[: self.neighbours]
            for other in read:
                table[other][1] = self.time
            found.append(sum(table[other][0] for other in read) / len(read))
        return found

    def learn(self, worth):
        if len(self.window) < self.steps:
            return
        states, chosen, _ = self.window[-self.steps]
        rewards = [each[2] for each in self.window[-self.steps :]]
        for i, state in enumerate(states):
            tried = [value for value in worth[i] if value < np.inf]
            outcome = self.discount**self.steps * max(tried) if tried and self.bootstrap else 0.0
            for k in reversed(range(self.steps)):
                outcome = outcome + self.discount**k * rewards[k][i]
            self.keep(self.tables[self.shapes[i], chosen[i]], state, outcome)

    def keep(self, table, state, outcome):
        self.time += 1
        if state in table:
            table[state][:2] = max(table[state][0], outcome), self.time
            return
        number = len(table)
        if number == self.capacity:
            oldest = min(table, key=lambda other: (table[other][1], table[other][2]))
            number = table.pop(oldest)[2]
        table[state] = [outcome, self.time, number]


def looks(network, seed):
    """Yield observations whose states recur now and then."""
    rng = stream(seed, "looks")
    most = max(len(item.movements) for item in network.intersections)
    for k in range(DECISIONS):
        queue = np.zeros((len(network.intersections), most), np.int32)
        for i, item in enumerate(network.intersections):
            queue[i, : len(item.movements)] = rng.poisson(0.25, len(item.movements))
        shown = np.zeros(len(queue), np.int32)
        yield Observation(queue, queue, shown, shown, 10 * k, queue.astype(float))


@pytest.mark.parametrize("bootstrap", [False, True])
@pytest.mark.parametrize(("capacity", "steps"), [(1000, 1), (1000, 4), (9, 4)])
@pytest.mark.parametrize("name", NETWORKS)
def test_decisions_are_those_of_the_plain_twin(name, capacity, steps, bootstrap):
    network = NETWORKS[name]
    rules = {"steps": steps, "discount": 0.9, "bootstrap": bootstrap}
    rules |= {"neighbours": 3, "capacity": capacity}
    controller = make_controller("mfec", {**rules, "epsilon_first": 0.2, "epsilon_last": 0.2})
    controller.reset(RunContext(network, SignalTiming(), stream(5, "chance")))
    twin = PlainMfec(network, controller.agents.shape.tolist(), **rules)
    chance, rewards, reward = stream(5, "chance"), stream(5, "rewards"), None
    for seen in looks(network, 2):
        states = [tuple(state) for state in controller.states(seen).tolist()]
        draws = chance.random((len(states), DRAWS))
        assert controller.decide(seen, reward).tolist() == twin.decide(states, reward, draws, 0.2)
        reward = rewards.standard_normal(len(states))
    arrays, expected = controller.arrays(), []
    for table in [table for _, table in sorted(twin.tables.items())]:
        expected += sorted((entry[2], state, *entry[:2]) for state, entry in table.items())
    assert arrays["keys"].tolist() == [list(each[1]) for each in expected]
    assert arrays["value"].tolist() == [each[2] for each in expected]
    assert arrays["used"].tolist() == [each[3] for each in expected]
    assert arrays["clock"].tolist() == [twin.time]
    assert min(controller.lookups().values()) > 0
