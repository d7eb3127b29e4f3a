"""The deep learners against plain twins: lists of transitions, torch's own layers and optimiser."""

from itertools import pairwise

import numpy as np
import pytest
import torch

from dmil.controllers import RunContext, make_controller
from dmil.network import grid
from dmil.scenarios import SignalTiming
from dmil.seeding import stream
from dmil.simulation import Observation

AGENTS, PHASES, GAMMA, BATCH, PERIOD, CAPACITY = 2, 8, 0.9, 8, 13, 60
PLANNED = 100
DECISIONS = 120
OPTIONS = {
    "discount": GAMMA,
    "batch_size": BATCH,
    "target_period": PERIOD,
    "buffer_capacity": CAPACITY,
    "hidden": 16,
    "training_decisions": PLANNED,
    "reward_scale": 1.0,
}


@pytest.fixture(autouse=True, scope="module")
def _one_thread():
    """As the learners have it: for so little, several threads wait for each other."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(before)


class PlainDeep:
    """DQN on lists; with ``urgent`` prioritised replay, with ``team`` value decomposition."""

    def __init__(self, inputs, rng, *, urgent=False, team=False):
        self.rng, self.urgent, self.team = rng, urgent, team
        self.inputs = inputs + (AGENTS if team else 0)
        sizes = (self.inputs, 16, 16, PHASES)
        layers = []
        for of, to in pairwise(sizes):
            layer = torch.nn.Linear(of, to)
            drawn = torch.from_numpy(rng.uniform(-1, 1, to * (of + 1)) / np.sqrt(of)).float()
            with torch.no_grad():
                layer.weight.copy_(drawn[: to * of].view(to, of))
                layer.bias.copy_(drawn[to * of :])
            layers += [layer, torch.nn.ReLU()]
        self.network = torch.nn.Sequential(*layers[:-1])
        self.optimiser = torch.optim.Adam(self.network.parameters(), lr=1e-3)
        self.renew()
        self.transitions, self.written, self.steps, self.decisions = [], 0, 0, 0
        self.priorities, self.largest = [], 1.0

    def renew(self):
        self.target = [weights.detach().clone() for weights in self.network.parameters()]

    def value(self, states, *, target=False):
        """Q of all phases; a team's states are (agents, places) and know whose they are."""
        x = torch.log1p(torch.tensor(np.array(states), dtype=torch.float32))
        if self.team:
            x = torch.cat([x, torch.eye(AGENTS).expand(len(x), AGENTS, AGENTS)], -1)
        if not target:
            return self.network(x)
        names = [name for name, _ in self.network.named_parameters()]
        return torch.func.functional_call(
            self.network, dict(zip(names, self.target, strict=True)), (x,)
        )

    def remember(self, transition):
        place = self.written % CAPACITY
        if len(self.transitions) <= place:
            self.transitions.append(None)
            self.priorities.append(0.0)
        self.transitions[place] = transition
        self.priorities[place] = self.largest
        self.written += 1

    def sample(self, draws):
        """Return rows and weights."""
        if not self.urgent:
            return [int(draw * len(self.transitions)) for draw in draws], np.ones(BATCH)
        total, rows = sum(self.priorities), []
        edges = np.cumsum(self.priorities)
        for k, draw in enumerate(draws):
            rows.append(int(np.searchsorted(edges, (k + draw) / BATCH * total, side="right")))
        beta = 0.4 + 0.6 * min(1.0, self.decisions / PLANNED)
        chance = np.array([self.priorities[row] for row in rows]) / total
        weights = (len(self.transitions) * chance) ** -beta
        return rows, weights / weights.max()

    def learn(self):
        if len(self.transitions) < BATCH:
            return
        rows, weights = self.sample(self.rng.random(BATCH))
        state, action, reward, following = zip(*(self.transitions[r] for r in rows), strict=True)
        best = self.value(following, target=True).max(-1).values.detach()
        every = torch.tensor(np.array(action))[..., None]
        chosen = self.value(state).gather(-1, every)[..., 0]
        if self.team:
            best, chosen = best.sum(1), chosen.sum(1)
        goal = torch.tensor(reward, dtype=torch.float32) + GAMMA * best
        error = goal - chosen
        huber = torch.where(error.abs() < 1, error**2 / 2, error.abs() - 0.5)
        self.optimiser.zero_grad()
        (huber * torch.from_numpy(weights).float()).mean().backward()
        self.optimiser.step()
        self.steps += 1
        if self.steps % PERIOD == 0:
            self.renew()
        for row, delta in zip(rows, error.tolist(), strict=True):
            self.priorities[row] = (abs(delta) + 1e-6) ** 0.6
            self.largest = max(self.largest, self.priorities[row])

    def decide(self, state, reward):
        if reward is not None:
            if self.team:
                self.remember((self.state, self.action, sum(reward), state))
            else:
                for each in zip(self.state, self.action, reward, state, strict=True):
                    self.remember(each)
            self.learn()
        left = max(0.0, 1 - self.decisions / (0.2 * PLANNED))
        epsilon = 0.05 + left * 0.95
        value = self.value([state])[0] if self.team else self.value(state)
        action = []
        for values, draws in zip(value.tolist(), self.rng.random((AGENTS, 3)), strict=True):
            explores = draws[0] < epsilon
            action.append(int(draws[1] * PHASES) if explores else int(np.argmax(values)))
        self.decisions += 1
        self.state, self.action = state, action
        return action


@pytest.mark.parametrize(
    ("name", "kind"), [("dqn", {}), ("dqn-prioritised", {"urgent": True}), ("vdn", {"team": True})]
)
def test_choices_and_values_are_those_of_the_plain_twin(name, kind):
    network = grid(1, AGENTS)
    signalled = [j for j in range(12) if j not in network.intersections[0].unsignalled]
    learner = make_controller(name, OPTIONS)
    learner.reset(RunContext(network, SignalTiming(), stream(1)))
    plain = PlainDeep(8, stream(1), **kind)
    rng, reward = stream(2), None
    phase = np.zeros(AGENTS, np.int32)
    for k in range(DECISIONS):
        queue = rng.poisson(3.0, (AGENTS, 12)).astype(np.int32)
        seen = Observation(queue, queue * 0, phase, phase, 10 * k, queue * 0.0)
        state = queue[:, signalled]
        assert learner.decide(seen, reward).tolist() == plain.decide(state, reward)
        reward = rng.normal(-1.0, 2.0, AGENTS)
        value = plain.value([state])[0] if plain.team else plain.value(state)
        assert np.allclose(learner._values(state), value.detach().numpy(), atol=1e-3)
    assert plain.steps > 100
    assert plain.written > CAPACITY
