"""Triggers, delays, losses and what is sent, against twins made of dicts and lists.

The twins merge and hand out in the plainest way; actions must be the same and values equal to the
last bit, as in `test_learners`.
"""

import numpy as np
import pytest

from dmil.controllers.tabular.agents import classes_of as network_classes
from dmil.controllers.tabular.dual_memory import DualMemoryController
from dmil.controllers.tabular.sarsa import SarsaController
from dmil.controllers.tabular.settings import DualMemorySettings, SarsaSettings
from dmil.memory import ABSENT
from dmil.seeding import stream
from dmil.symmetry import EMBEDDINGS
from tests.differential.plain_merges import copied, union_of_bests, union_of_values
from tests.differential.test_learner_options import CappedTwin, drive
from tests.differential.test_learners import DualTwin, SarsaTwin


class Exchanging:
    """A twin whose agents write letters to the central unit."""

    def __init__(self, settings, network, prior, plain_classes):
        # The twins' own meetings are those of the paper.
        alone = settings.model_copy(update={"communication": False})
        super().__init__(alone, network, prior, plain_classes)
        self.rules = settings
        self.loss = stream(5, "exploration").spawn(1)[0]
        self.letters, self.held, self.met_at = {}, {}, []
        self.messages = self.bytes = 0
        self.forget(range(len(self.shape)))
        rows = network_classes(network, EMBEDDINGS[settings.embedding])
        self.key_bytes = 4 * rows.movement_image.shape[2] // rows.parts
        self.value_bytes = 9 * rows.phase_image.shape[2]

    def forget(self, members):
        if not hasattr(self, "entered"):
            self.entered, self.change, self.has_staged = {}, {}, {}
        for member in members:
            self.entered[member], self.change[member], self.has_staged[member] = 0, 0.0, False

    def decide(self, observation, reward, draws):
        self.receive(observation.time_s)
        actions = super().decide(observation, reward, draws)
        for s, members in enumerate(self.agents.members):
            if s not in self.letters and self.is_due(s, members.tolist(), observation.time_s):
                self.met_at.append(observation.time_s)
                self.send(s, members.tolist(), observation.time_s)
        if not self.rules.communication_delay_s:
            self.receive(observation.time_s)
        return actions

    def is_due(self, s, members, time_s):
        rules = self.rules
        if rules.trigger == "entries":
            mean = sum(self.entered[m] for m in members) / len(members)
            return mean >= rules.trigger_entries
        if rules.trigger == "values":
            return sum(self.change[m] for m in members) / len(members) >= rules.trigger_change
        if rules.trigger == "staging":
            return sum(self.has_staged[m] for m in members) / len(members) >= rules.trigger_share
        over = time_s // rules.communication_period_s
        due, self.held[s] = over > self.held.get(s, 0), over
        return due

    def send(self, s, members, time_s):
        self.forget(members)
        heard = reached = members
        if self.rules.message_loss:
            lost = self.loss.random((2, len(members))) < self.rules.message_loss
            heard, reached = (
                [m for m, gone in zip(members, each, strict=True) if not gone] for each in lost
            )
        self.messages += len(members)
        self.bytes += sum(self.size(self.sent(m)) for m in members)
        if heard:
            answer = self.merged(s, heard)
            self.messages += len(members)
            self.bytes += len(members) * self.size(answer)
            self.letters[s] = (time_s + self.rules.communication_delay_s, answer, reached)

    def receive(self, time_s):
        for s, (due_s, answer, reached) in list(self.letters.items()):
            if due_s <= time_s:
                del self.letters[s]
                for member in reached:
                    self.take_over(member, self.classes[s], answer)

    def size(self, parts):
        values, bests = parts
        return len(values) * (self.key_bytes + self.value_bytes) + len(bests) * (
            self.key_bytes + 12
        )

    def learn(self, i, classes, key, action, value):
        self.change[i] += abs(value - self.value(i, classes, key, action))
        rows = self.short[i] if hasattr(self, "short") else self.tables[i]
        self.entered[i] += classes.find([row["key"] for row in rows], key)[0] is None
        super().learn(i, classes, key, action, value)
        self.has_staged[i] |= hasattr(self, "short") and not self.short[i]


def values_taken_over(classes, mine, answer):
    rows = [{**row, "q": dict(row["q"]), "n": 0} for row in answer]
    keys = [row["key"] for row in answer]
    for row in mine:
        place, _ = classes.find(keys, row["key"])
        if place is None:
            rows.append({**row, "n": 0})
        rows[-1 if place is None else place]["n"] += row.get("n", 0)
    return rows


class SarsaByPost(Exchanging, SarsaTwin):
    def sent(self, member):
        return self.tables[member], []

    def merged(self, s, heard):
        return union_of_values(self.classes[s], [self.tables[m] for m in heard]), []

    def take_over(self, member, classes, answer):
        rows = values_taken_over(classes, self.tables[member], answer[0])
        self.tables[member] = [{"key": row["key"], "q": row["q"]} for row in rows]


class DualByPost(Exchanging, DualTwin):
    def sent(self, member):
        kind = self.rules.sent
        return (
            self.short[member] if kind != "long" else [],
            self.long[member] if kind != "short" else [],
        )

    def merged(self, s, heard):
        parts = [self.sent(member) for member in heard]
        return (
            union_of_values(self.classes[s], [short for short, _ in parts]),
            self.union_of_long(s, heard),
        )

    def union_of_long(self, s, heard):
        return union_of_bests(self.classes[s], [self.sent(member)[1] for member in heard])

    def take_over(self, member, classes, answer):
        short, long = answer
        if self.rules.sent != "short":
            self.take_long(member, classes, long)
        if self.rules.sent != "long":
            rows = values_taken_over(classes, self.short[member], short)
            self.short[member].clear()
            for row in rows:
                self.short[member].append({**row, "n": max(1, row["n"])})
                self.stage_when_due(member, classes)

    def take_long(self, member, classes, long):
        keys = [row["key"] for row in long]
        kept = [r for r in self.long[member] if classes.find(keys, r["key"])[0] is None]
        self.long[member] = copied(long) + kept


class CappedByPost(DualByPost, CappedTwin):
    def union_of_long(self, s, heard):
        return self.cut_union(self.classes[s], heard)

    def take_long(self, member, classes, long):
        mine, keys = list(self.long[member]), [row["key"] for row in long]
        self.take(member, long)
        if not (self.rules.communication_delay_s or self.rules.message_loss):
            # At a meeting without post what the central unit has cut is gone.
            return
        rows = self.long[member]
        for row in mine:
            if classes.find(keys, row["key"])[0] is None:
                place = rows.admission.admit(self.padded(classes, row["key"]))
                if place == len(rows):
                    rows.append(row)
                elif place != ABSENT:
                    rows[place] = row
                    self.replaced += 1


MEETING = {"communication": True, "communication_period_s": 30, "epsilon": 0.3}
POSTS = [
    {"communication_delay_s": 10},
    {"communication_delay_s": 25},
    {"communication_delay_s": 70},
    {"message_loss": 0.3},
    {"message_loss": 0.6, "communication_delay_s": 45},
    {"trigger": "entries", "trigger_entries": 1.5},
    {"trigger": "entries", "trigger_entries": 2.0, "communication_delay_s": 20},
    {"trigger": "values", "trigger_change": 0.3},
    {"trigger": "values", "trigger_change": 0.1, "message_loss": 0.2},
]


def same(kind, twin_kind, settings, network, walk, plain_classes, decisions=50):
    twin, controller = twin_kind(settings, network, None, plain_classes), kind(settings)
    drive(controller, twin, network, walk, decisions)
    use = controller.memory_use()
    assert twin.met_at
    assert use.messages == twin.messages > 0
    # What is known to be common is.
    for members, common in zip(twin.agents.members, controller._common, strict=True):
        rows = (controller.table if kind is SarsaController else controller.memory.long).rows
        keys = rows.keys[members, :common]
        assert (keys == keys[:1]).all() and common <= rows.size[members].min()
    return controller, twin


# Every way of the post meets one embedding, every embedding delays, losses and triggers.
@pytest.mark.parametrize(
    ("options", "embedding"),
    [
        *zip(POSTS, 3 * ["exact", "simple", "complex"], strict=True),
        (POSTS[3], "complex"),
        (POSTS[5], "complex"),
        (POSTS[7], "exact"),
    ],
    ids=str,
)
def test_sarsa_by_post_is_its_twin(networks, walk, plain_classes, embedding, options):
    settings = SarsaSettings(embedding=embedding, **{**MEETING, **options})
    controller, twin = same(
        SarsaController, SarsaByPost, settings, networks["mixed"], walk, plain_classes
    )
    assert controller.memory_use().exchanged_bytes == twin.bytes


# All that is sent with every kind of post: at once, late, with losses, by each trigger.
@pytest.mark.parametrize(
    ("options", "sent"),
    [
        ({}, "long"),
        ({}, "short"),
        ({}, "both"),
        *zip(POSTS, ["long", "short", "both", *2 * ["both", "long", "short"]], strict=True),
        (POSTS[5], "both"),
        (POSTS[7], "both"),
        ({"trigger": "staging", "trigger_share": 0.6}, "both"),
        ({"trigger": "staging", "trigger_share": 0.6}, "long"),
        ({"trigger": "staging", "trigger_share": 0.1, "message_loss": 0.4}, "short"),
        ({"staging": "visits", "stage_period": 9, "message_loss": 0.3}, "short"),
        ({"embedding": "simple", "communication_delay_s": 50}, "both"),
    ],
    ids=str,
)
def test_dual_memory_by_post_is_its_twin(networks, walk, plain_classes, sent, options):
    settings = DualMemorySettings(**{**MEETING, "short_capacity": 6, "sent": sent, **options})
    controller, twin = same(
        DualMemoryController, DualByPost, settings, networks["mixed"], walk, plain_classes
    )
    assert controller.memory_use().exchanged_bytes == twin.bytes


@pytest.mark.parametrize("sent", ["long", "short", "both"])
@pytest.mark.parametrize(
    "options",
    [{}, {"communication_delay_s": 40}, {"message_loss": 0.4, "communication_delay_s": 20}],
    ids=str,
)
def test_a_capped_dual_memory_by_post_is_its_twin(networks, walk, plain_classes, sent, options):
    own = {"short_capacity": 4, "long_capacity": 6, "sent": sent, "embedding": "complex"}
    settings = DualMemorySettings(**{**MEETING, **own, **options})
    _, twin = same(
        DualMemoryController, CappedByPost, settings, networks["mixed"], walk, plain_classes, 80
    )
    assert twin.replaced


def test_whoever_shares_a_short_term_memory_ends_up_with_the_same(networks, walk, plain_classes):
    """Nothing is lost or late: after a meeting all of a shape have one short-term memory."""
    settings = DualMemorySettings(**{**MEETING, "sent": "both", "short_capacity": 5})
    controller, twin = same(
        DualMemoryController, DualByPost, settings, networks["grid"], walk, plain_classes, 61
    )
    assert twin.met_at[-1] == 600
    short, long = (
        [[row["key"] for row in rows] for rows in part] for part in (twin.short, twin.long)
    )
    assert short.count(short[0]) == long.count(long[0]) == len(short)
    sizes = controller.memory.long.rows.size
    assert (sizes == sizes[0]).all() and np.ptp(controller.memory.short.rows.size) == 0
