"""SARSA and dual memory against twins made of dicts and lists, decision by decision.

The twins are written from the specification (§5, §6), one agent and one dict at a time. Both get
the same observations, rewards and draws; actions must be the same and values equal to the last bit.
"""

import math
from fractions import Fraction

import numpy as np
import pytest

from dmil.controllers import Prior, RunContext
from dmil.controllers.tabular.agents import agents_of
from dmil.controllers.tabular.dual_memory import DualMemoryController
from dmil.controllers.tabular.sarsa import SarsaController
from dmil.controllers.tabular.settings import DualMemorySettings, SarsaSettings
from dmil.scenarios import SignalTiming
from dmil.seeding import stream
from dmil.simulation import Observation
from dmil.symmetry import EMBEDDINGS
from tests.differential.plain_merges import best_of, copied, union_of_bests, union_of_values

INTERVAL_S = 10


def pick(draw, options):
    return options[min(int(draw * len(options)), len(options) - 1)]


class Twin:
    """What both twins share; agents decide in the order of the network."""

    def __init__(self, settings, network, prior, plain_classes):
        self.settings, self.epsilon, self.met = settings, settings.epsilon, 0
        self.agents = agents_of(network)
        self.shape = self.agents.shape.tolist()
        embedding = EMBEDDINGS[settings.embedding]
        self.classes = [plain_classes(embedding, group) for group in self.agents.groups]
        self.last = [None] * len(self.shape)
        self.start(prior)

    def decide(self, observation, reward, draws):
        actions = []
        learns = self.settings.learning and reward is not None
        for i, s in enumerate(self.shape):
            classes, state = self.classes[s], observation.queue_veh[i]
            key = classes.key(state)
            action = self.choose(i, classes, key, draws[i])
            if learns:
                old_key, old_action = self.last[i]
                old = self.value(i, classes, old_key, old_action)
                following = self.value(i, classes, key, action)
                error = float(reward[i]) + self.settings.discount * following - old
                self.learn(
                    i, classes, old_key, old_action, old + self.settings.learning_rate * error
                )
            self.last[i] = (key, action)
            actions.append(action)
        self.epsilon *= self.settings.epsilon_decay
        periods = observation.time_s // self.settings.communication_period_s
        if self.settings.learning and self.settings.communication and periods > self.met:
            self.met = periods
            for s, members in enumerate(self.agents.members):
                self.meet(self.classes[s], members.tolist())
        return actions


class SarsaTwin(Twin):
    def start(self, prior):
        tables = []
        for s, classes in enumerate(self.classes):
            tables.append([])
            for state, values in prior[s] if prior else []:
                row, image = classes.find_or_append(tables[s], classes.key(state), {"q": {}})
                if not row["q"]:
                    row["q"] = {}
                row["q"].update({image[a]: q for a, q in values.items()})
        self.shared = self.settings.shared
        if self.shared:
            self.owner = self.shape
            self.tables = tables
        else:
            self.owner = list(range(len(self.shape)))
            self.tables = [copied(tables[s]) for s in self.shape]

    def choose(self, i, classes, key, draws):
        rows = self.tables[self.owner[i]]
        row, image = classes.find([r["key"] for r in rows], key)
        if row is None or draws[0] < self.epsilon:
            return pick(draws[1], range(classes.action_count))
        values = [rows[row]["q"].get(image[a], 0.0) for a in range(classes.action_count)]
        return pick(draws[2], [a for a, q in enumerate(values) if q == max(values)])

    def value(self, i, classes, key, action):
        rows = self.tables[self.owner[i]]
        row, image = classes.find([r["key"] for r in rows], key)
        return 0.0 if row is None else rows[row]["q"].get(image[action], 0.0)

    def learn(self, i, classes, key, action, value):
        row, image = classes.find_or_append(self.tables[self.owner[i]], key, {"q": {}})
        row["q"] = {**row["q"], image[action]: value}

    def meet(self, classes, members):
        if self.shared:
            return
        union = union_of_values(classes, [self.tables[member] for member in members])
        for member in members:
            self.tables[member] = copied(union)

    def memory(self):
        return [[(row["key"], row["q"]) for row in table] for table in self.tables]


class DualTwin(Twin):
    def start(self, prior):
        long = []
        for s, classes in enumerate(self.classes):
            long.append([])
            rows = []
            for state, values in prior[s] if prior else []:
                action = best_of(values)
                rows.append((state, action, values[action]))
            rows.sort(key=lambda row: -row[2])
            for state, action, q in rows[: self.part(len(rows))]:
                self.consolidate(long[s], classes, classes.key(state), action, q)
        self.short = [[] for _ in self.shape]
        self.long = [copied(long[s]) for s in self.shape]

    def part(self, size):
        return math.ceil(Fraction(str(self.settings.staged_ratio)) * size)

    def is_better(self, q, than):
        return q > than + self.settings.significance * abs(than)

    def choose(self, i, classes, key, draws):
        if draws[0] >= self.epsilon:
            best = None
            row, image = classes.find([r["key"] for r in self.long[i]], key)
            if row is not None:
                best, best_q = image.index(self.long[i][row]["a"]), self.long[i][row]["q"]
            row, image = classes.find([r["key"] for r in self.short[i]], key)
            if row is not None:
                values = self.short[i][row]["q"]
                action = best_of(values)
                if best is None or self.is_better(values[action], best_q):
                    best = image.index(action)
            if best is not None:
                return best
        return pick(draws[1], range(classes.action_count))

    def value(self, i, classes, key, action):
        row, image = classes.find([r["key"] for r in self.short[i]], key)
        if row is not None and image[action] in self.short[i][row]["q"]:
            return self.short[i][row]["q"][image[action]]
        row, image = classes.find([r["key"] for r in self.long[i]], key)
        if row is not None and self.long[i][row]["a"] == image[action]:
            return self.long[i][row]["q"]
        return 0.0

    def learn(self, i, classes, key, action, value):
        short = self.short[i]
        row, image = classes.find_or_append(short, key, {"q": {}, "n": 0})
        row["q"] = {**row["q"], image[action]: value}
        row["n"] += 1
        self.stage_when_due(i, classes)

    def stage_when_due(self, i, classes):
        short, period = self.short[i], self.settings.stage_period
        written = sum(row["n"] for row in short)
        if len(short) >= self.settings.short_capacity or 0 < period <= written:
            # Python's sort is stable: of equal rows the older comes first.
            by_merit = sorted(short, key=lambda row: -max(row["q"].values()))
            if self.settings.staging == "visits":
                by_merit = sorted(short, key=lambda row: -row["n"])
            for row in by_merit[: self.part(len(short))]:
                action = best_of(row["q"])
                self.consolidate(self.long[i], classes, row["key"], action, row["q"][action])
            short.clear()

    def consolidate(self, long, classes, key, action, q):
        row, image = classes.find_or_append(long, key, {"a": None})
        if row["a"] is None or self.is_better(q, row["q"]):
            row["a"], row["q"] = image[action], q

    def meet(self, classes, members):
        union = union_of_bests(classes, [self.long[member] for member in members])
        for member in members:
            self.long[member] = copied(union)

    def memory(self):
        short = [[(row["key"], row["q"]) for row in rows] for rows in self.short]
        return short, [[(row["key"], {row["a"]: row["q"]}) for row in rows] for rows in self.long]


def table_of(table, sizes):
    """Read a compiled table of values or best actions as the twins hold theirs."""
    owners = []
    for owner, size in enumerate(table.rows.size.tolist()):
        rows = []
        for row in range(size):
            places, actions = sizes[owner]
            parts = np.split(table.rows.keys[owner, row], table.rows.parts)
            assert not any(part[places:].any() for part in parts)
            key = tuple(value for part in parts for value in part[:places].tolist())
            if hasattr(table, "tried"):
                assert not table.tried[owner, row, actions:].any()
                tried = np.flatnonzero(table.tried[owner, row]).tolist()
                values = {a: float(table.value[owner, row, a]) for a in tried}
            else:
                values = {int(table.action[owner, row]): float(table.value[owner, row])}
            rows.append((key, values))
        owners.append(rows)
    return owners


def sizes_of(nodes):
    return [(len(node.movements), len(node.phases)) for node in nodes]


def observed(queue, time_s):
    empty = np.zeros(len(queue), np.int32)
    return Observation(
        queue.copy(), np.zeros_like(queue), empty, empty, time_s, np.zeros(queue.shape)
    )


def same_decisions(controller, twin, network, walk, decisions):
    rng, plain_rng = stream(5, "exploration"), stream(5, "exploration")
    controller.reset(RunContext(network, SignalTiming(decision_interval_s=INTERVAL_S), rng))
    queue, step = walk(network, 5)
    reward = None
    for k in range(decisions):
        observation = observed(queue, k * INTERVAL_S)
        actions = controller.decide(observation, reward)
        expected = twin.decide(observation, reward, plain_rng.random((len(queue), 3)).tolist())
        assert actions.tolist() == expected, f"decision {k}"
        reward = step(actions)
    sizes = sizes_of(network.intersections)
    if isinstance(controller, SarsaController):
        if controller.settings.shared:
            sizes = [sizes[members[0]] for members in agents_of(network).members]
        assert table_of(controller.table, sizes) == twin.memory()
    else:
        found = tuple(table_of(part, sizes) for part in controller.memory[:2])
        assert found == twin.memory()


KINDS = {
    "sarsa": (SarsaSettings, SarsaController, SarsaTwin, {}),
    "sarsa-shared": (SarsaSettings, SarsaController, SarsaTwin, {"shared": True}),
    "dual-memory": (DualMemorySettings, DualMemoryController, DualTwin, {"short_capacity": 6}),
}


@pytest.fixture(scope="module")
def compare(plain_classes, walk):
    """Return a function that runs a learner and its twin on a network."""

    def run(kind, network, *, prior=None, plain_prior=None, decisions=60, **options):
        make_settings, make_controller, make_twin, more = KINDS[kind]
        settings = make_settings(**{"epsilon": 0.3, **more, **options})
        controller = make_controller(settings, prior=prior)
        twin = make_twin(settings, network, plain_prior, plain_classes)
        same_decisions(controller, twin, network, walk, decisions)
        return controller

    return run


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    ("name", "embedding"),
    [*(("mixed", each) for each in EMBEDDINGS), ("grid", "exact"), ("grid", "complex")],
)
@pytest.mark.parametrize("communication", [False, True], ids=["alone", "communicating"])
def test_a_learner_is_its_twin(compare, networks, kind, name, embedding, communication):
    compare(kind, networks[name], embedding=embedding, communication=communication)


@pytest.mark.parametrize(
    "options",
    [
        {"staging": "visits", "epsilon": 0.1},
        {"stage_period": 5},
        {"stage_period": 9, "staging": "visits"},
        {"staged_ratio": 1.0, "short_capacity": 3},
        {"staged_ratio": 0.1, "significance": 0.0},
        {"short_capacity": 1},
        {"embedding": "cells", "decisions": 200, "learning_rate": 0.5, "discount": 0.2},
        {"epsilon": 0.0},
        {"epsilon": 0.8, "epsilon_decay": 0.9, "discount": 0.5, "learning_rate": 0.5},
        {"communication": True, "communication_period_s": 30, "staging": "visits"},
    ],
    ids=str,
)
def test_dual_memory_is_its_twin_by_other_rules(compare, networks, options):
    compare("dual-memory", networks["mixed"], **{"embedding": "complex", **options})


@pytest.fixture(scope="module")
def dummy(compare, networks):
    """Return a learner whose table is a prior."""
    return compare("sarsa-shared", networks["mixed"], embedding="exact", decisions=40)


EXCHANGING = {"communication": True, "epsilon": 0.5, "epsilon_decay": 0.95}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    ("options", "embedding"),
    [
        *(({}, each) for each in EMBEDDINGS),
        ({"learning": False}, "simple"),
        ({"learning": False}, "complex-scaled"),
        (EXCHANGING, "complex"),
        (EXCHANGING, "cells"),
    ],
    ids=str,
)
def test_a_learner_that_starts_from_a_prior_is_its_twin(
    compare, dummy, networks, kind, embedding, options
):
    network = networks["mixed"]
    shown = [network.intersections[members[0]] for members in agents_of(network).members]
    compare(
        kind,
        network,
        prior=Prior(dummy.table),
        plain_prior=table_of(dummy.table, sizes_of(shown)),
        embedding=embedding,
        **options,
    )
