"""Learners with a cap and a prior for unseen states against their twins, decision by decision."""

import copy

import numpy as np
import pytest

from dmil.controllers import Prior, RunContext
from dmil.controllers.tabular.agents import agents_of
from dmil.controllers.tabular.dual_memory import DualMemoryController
from dmil.controllers.tabular.sarsa import SarsaController
from dmil.controllers.tabular.settings import DualMemorySettings, SarsaSettings
from dmil.memory import ABSENT
from dmil.scenarios import SignalTiming
from dmil.seeding import stream
from dmil.simulation import Observation
from dmil.symmetry import EMBEDDINGS
from tests.differential.plain_merges import best_of, copied, union_of_bests
from tests.differential.test_learners import (
    DualTwin,
    SarsaTwin,
    pick,
    sizes_of,
    table_of,
)
from tests.differential.test_memory_admission import PlainAdmission

INTERVAL_S = 10


class WithFallback:
    """A twin that does in an unseen state what longest-queue-first does."""

    def decide(self, observation, reward, draws):
        self.seen = observation
        return super().decide(observation, reward, draws)

    def choose(self, i, classes, key, draws):
        explores = draws[0] < self.epsilon
        if explores or self.settings.unseen == "random" or self.knows(i, classes, key):
            return super().choose(i, classes, key, draws)
        if self.settings.unseen == "nearest":
            return self.nearest(i, classes, key, draws)
        self.fell_back += 1
        queue, shown = self.seen.queue_veh[i], self.seen.phase[i]
        queued = [int(queue[sorted(phase)].sum()) for phase in self.nodes[i].phases]
        return shown if queued[shown] == max(queued) else queued.index(max(queued))

    def nearest(self, i, classes, key, draws):
        rows = self.long[i] if hasattr(self, "long") else self.tables[self.owner[i]]
        if not rows:
            return pick(draws[1], range(classes.action_count))
        self.fell_back += 1
        far = []
        for variant, image in enumerate(classes.places):
            moved = dict(zip(image, classes.parts(key)[-1], strict=True))
            for place, row in enumerate(rows):
                known = classes.parts(row["key"])[-1]
                off = sum(abs(known[j] - moved[j]) for j in moved)
                far.append((off, place, variant))
        _, place, variant = min(far)
        image = classes.actions[variant]
        if hasattr(self, "long"):
            return image.index(rows[place]["a"])
        values = [rows[place]["q"].get(image[a], 0.0) for a in range(classes.action_count)]
        return pick(draws[2], [a for a, q in enumerate(values) if q == max(values)])


class FallbackSarsaTwin(WithFallback, SarsaTwin):
    """SARSA; nothing else differs."""

    def knows(self, i, classes, key):
        return classes.find([row["key"] for row in self.tables[self.owner[i]]], key)[0] is not None


class Capped(list):
    """Rows of a long-term memory with their admission."""

    def __init__(self, rows, admission):
        super().__init__(rows)
        self.admission = admission


class CappedTwin(WithFallback, DualTwin):
    """Dual memory under a cap."""

    def start(self, prior):
        self.refused = self.replaced = self.staged = 0
        self.wide = max(len(classes.places[0]) for classes in self.classes)
        starts = []
        for s, classes in enumerate(self.classes):
            images = [image + list(range(len(image), self.wide)) for image in classes.places]
            tolerance = classes.embedding.tolerance
            admission = PlainAdmission(images, tolerance, self.settings.long_capacity)
            starts.append(Capped([], admission))
            rows = prior[s] if prior else []
            for state, _, visits in rows:
                for _ in range(visits):
                    admission.record(self.padded(classes, classes.key(state)))
            best = sorted(rows, key=lambda row: -max(row[1].values()))
            for state, values, _ in best[: self.part(len(rows))]:
                action = best_of(values)
                self.consolidate(starts[s], classes, classes.key(state), action, values[action])
        self.short = [[] for _ in self.shape]
        self.long = [copy.deepcopy(starts[s]) for s in self.shape]

    def padded(self, classes, key):
        last = classes.parts(key)[-1]
        return [*last, *[0] * (self.wide - len(last))]

    def told(self, i, classes, key):
        """Return best action and Q of the short-term row of a key, None if it has none to tell."""
        row, image = classes.find([r["key"] for r in self.short[i]], key)
        if row is None or len(self.short[i][row]["q"]) < self.settings.least_tried:
            return None
        values = self.short[i][row]["q"]
        return image.index(best_of(values)), values[best_of(values)]

    def knows(self, i, classes, key):
        known = classes.find([row["key"] for row in self.long[i]], key)[0] is not None
        return known or self.told(i, classes, key) is not None

    def choose(self, i, classes, key, draws):
        knows, random = self.knows(i, classes, key), self.settings.unseen == "random"
        if draws[0] < self.epsilon or (random and not knows):
            return pick(draws[1], range(classes.action_count))
        if not knows:
            return super().choose(i, classes, key, draws)
        row, image = classes.find([r["key"] for r in self.long[i]], key)
        told = self.told(i, classes, key)
        if row is None or (told and self.is_better(told[1], self.long[i][row]["q"])):
            return told[0]
        return image.index(self.long[i][row]["a"])

    def learn(self, i, classes, key, action, value):
        short = self.short[i]
        self.long[i].admission.record(self.padded(classes, key))
        row, image = classes.find_or_append(short, key, {"q": {}, "n": 0})
        row["q"] = {**row["q"], image[action]: value}
        row["n"] += 1
        self.stage_when_due(i, classes)

    def stage_when_due(self, i, classes):
        short, settings = self.short[i], self.settings
        if len(short) < settings.short_capacity:
            return
        staged = []
        for row in short:
            best = best_of(row["q"])
            value = row["q"][best]
            if len(row["q"]) >= settings.least_tried:
                merit = row["n"] if settings.staging == "visits" else value
                staged.append((merit, row["key"], best, value))
        staged.sort(key=lambda each: -each[0])
        self.staged += len(staged)
        for _, staged_key, best, q in staged[: self.part(len(short))]:
            self.consolidate(self.long[i], classes, staged_key, best, q)
        short.clear()

    def consolidate(self, long, classes, key, action, q):
        row, image = classes.find([r["key"] for r in long], key)
        if row is not None:
            if self.is_better(q, long[row]["q"]):
                long[row].update(a=image[action], q=q)
            return
        place = long.admission.admit(self.padded(classes, key))
        if place == len(long):
            long.append({"key": key, "a": action, "q": q})
        elif place != ABSENT:
            long[place] = {"key": key, "a": action, "q": q}
            self.replaced += 1
        else:
            self.refused += 1

    def meet(self, classes, members):
        union = self.cut_union(classes, members)
        for member in members:
            self.take(member, union)

    def take(self, member, union):
        admission, classes = self.long[member].admission, self.classes[self.shape[member]]
        admission.keys = [self.padded(classes, row["key"]) for row in union]
        self.long[member] = Capped(copied(union), admission)

    def cut_union(self, classes, members):
        union = union_of_bests(classes, [self.long[member] for member in members])

        def met(row):
            key = self.padded(classes, union[row]["key"])
            return sum(self.long[member].admission.frequency(key) for member in members)

        kept = sorted(range(len(union)), key=lambda row: -met(row))[: self.settings.long_capacity]
        return [union[row] for row in sorted(kept)]


FEW = {"complex": 2}
"""A cap that is reached by classes so wide that few of them are met."""


def drive(controller, twin, network, walk, decisions):
    """Let both decide on what their decisions lead to; the last actions are shown."""
    rng, plain_rng = stream(5, "exploration"), stream(5, "exploration")
    controller.reset(RunContext(network, SignalTiming(decision_interval_s=INTERVAL_S), rng))
    twin.nodes, twin.fell_back = network.intersections, 0
    queue, step = walk(network, 5)
    reward, shown = None, np.zeros(len(queue), np.int32)
    for k in range(decisions):
        counts = np.zeros_like(queue)
        observation = Observation(
            queue.copy(), counts, shown, 0 * shown, k * INTERVAL_S, counts.astype(float)
        )
        actions = controller.decide(observation, reward)
        draws = plain_rng.random((len(queue), 3)).tolist()
        assert actions.tolist() == twin.decide(observation, reward, draws), f"decision {k}"
        reward, shown = step(actions), actions
    sizes = sizes_of(network.intersections)
    if isinstance(twin, SarsaTwin):
        assert table_of(controller.table, sizes) == twin.memory()
    else:
        assert tuple(table_of(part, sizes) for part in controller.memory[:2]) == twin.memory()


@pytest.mark.parametrize("unseen", ["longest-queue", "nearest"])
@pytest.mark.parametrize("embedding", EMBEDDINGS)
def test_an_unseen_state_acts_as_it_is_told(networks, walk, plain_classes, embedding, unseen):
    network = networks["mixed"]
    options = {"embedding": embedding, "epsilon": 0.1, "unseen": unseen}
    for settings, kind, make in (
        (SarsaSettings(**options), SarsaController, FallbackSarsaTwin),
        (
            DualMemorySettings(**options, long_capacity=30, short_capacity=4),
            DualMemoryController,
            CappedTwin,
        ),
    ):
        twin = make(settings, network, None, plain_classes)
        drive(kind(settings), twin, network, walk, 60)
        assert twin.fell_back


OFTEN = {"communication": True, "communication_period_s": 30, "unseen": "longest-queue"}


@pytest.mark.parametrize(
    ("options", "embedding"),
    [
        *(({}, each) for each in EMBEDDINGS),
        ({"long_capacity": 1, "short_capacity": 2, "staging": "visits"}, "exact"),
        ({"long_capacity": 1, "short_capacity": 2, "staging": "visits"}, "complex"),
        ({"communication": True, "communication_period_s": 70}, "simple"),
        ({"communication": True, "communication_period_s": 70}, "complex"),
        (OFTEN, "exact"),
        (OFTEN, "complex-scaled"),
        ({"unseen": "nearest", "least_tried": 2}, "complex"),
        ({"unseen": "nearest", "least_tried": 2}, "cells"),
    ],
    ids=str,
)
def test_a_capped_dual_memory_is_its_twin(networks, walk, plain_classes, embedding, options):
    network = networks["mixed"]
    cap = FEW.get(embedding, 6)
    options = {"epsilon": 0.3, "short_capacity": 4, "long_capacity": cap, **options}
    settings = DualMemorySettings(embedding=embedding, **options)
    twin = CappedTwin(settings, network, None, plain_classes)
    drive(DualMemoryController(settings), twin, network, walk, 120)
    assert twin.replaced and twin.refused


@pytest.mark.parametrize(
    "options",
    [
        {"staging": "visits"},
        {"least_tried": 2},
        {"least_tried": 3, "unseen": "longest-queue"},
    ],
    ids=str,
)
def test_what_is_staged_and_told_is_what_the_twin_says(networks, walk, plain_classes, options):
    options = {"epsilon": 0.5, "short_capacity": 5, "long_capacity": 50, **options}
    settings = DualMemorySettings(embedding="cells", **options)
    twin = CappedTwin(settings, networks["mixed"], None, plain_classes)
    drive(DualMemoryController(settings), twin, networks["mixed"], walk, 100)
    assert twin.staged


@pytest.mark.parametrize("embedding", EMBEDDINGS)
def test_a_start_table_is_cut_to_the_cap(networks, walk, plain_classes, embedding):
    network = networks["mixed"]
    settings = SarsaSettings(shared=True, epsilon=0.3)
    dummy, twin = (
        SarsaController(settings),
        FallbackSarsaTwin(settings, network, None, plain_classes),
    )
    dummy.reset(RunContext(network, SignalTiming(), stream(1)))
    queue, step = walk(network, 3)
    reward = None
    for k in range(60):
        counts = np.zeros_like(queue)
        empty = np.zeros(len(queue), np.int32)
        seen = Observation(queue.copy(), counts, empty, empty, 10 * k, counts.astype(float))
        reward = step(dummy.decide(seen, reward))
    shown = [network.intersections[members[0]] for members in agents_of(network).members]
    rows = [
        [(*row, int(dummy.table.visits[s, r])) for r, row in enumerate(table)]
        for s, table in enumerate(table_of(dummy.table, sizes_of(shown)))
    ]
    cap = FEW.get(embedding, 5)
    settings = DualMemorySettings(
        embedding=embedding, long_capacity=cap, short_capacity=4, epsilon=0.2, staged_ratio=0.9
    )
    twin = CappedTwin(settings, network, rows, plain_classes)
    assert all(len(long) == cap for long in twin.long)
    controller = DualMemoryController(settings, prior=Prior(dummy.table))
    drive(controller, twin, network, walk, 60)
