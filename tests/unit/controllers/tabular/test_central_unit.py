"""Communication with the central unit: when, what, how late, what is lost, and what it costs."""

from dataclasses import replace

import numpy as np
import pytest

from dmil.controllers import NO_MEMORY, RunContext, make_controller
from dmil.controllers.tabular.announcements import Announcements
from dmil.controllers.tabular.meetings import CHANGE, NEWS, ROWS, STAGED, Meetings, Post
from dmil.controllers.tabular.settings import DualMemorySettings, SarsaSettings
from dmil.errors import InputError
from dmil.rewards import make_reward
from dmil.scenarios import SignalTiming, scenario
from dmil.seeding import stream
from dmil.simulation import Observation, QueueSimulator
from dmil.testing import check_controller
from dmil.testing.proving_grounds import proving_grounds
from dmil.training import evaluate, train, vehicles_of_seed

SCENARIO = scenario("grid:2x2", horizon_s=300)
SIMULATOR, REWARD = QueueSimulator(SCENARIO), make_reward("entropy")
VEHICLES = vehicles_of_seed(SCENARIO, 1)
MEETING = {"communication": True, "communication_period_s": 50, "embedding": "complex"}
NEVER = {"message_loss": 1 - 1e-12}
EACH = pytest.mark.parametrize("name", ["sarsa", "dual-memory"])
OWN = [
    ("sarsa", {}),
    ("dual-memory", {"short_capacity": 4}),
    ("dual-memory", {"short_capacity": 4, "sent": "short"}),
    ("dual-memory", {"short_capacity": 4, "sent": "both"}),
    ("dual-memory", {"short_capacity": 4, "sent": "both", "long_capacity": 8}),
]
OF_OWN = pytest.mark.parametrize(("name", "own"), OWN, ids=str)


def after_a_run(name, options, seed=1):
    controller = make_controller(name, options)
    return controller, evaluate(SIMULATOR, controller, VEHICLES, REWARD, seed)


def same_arrays(first, second, *, but=()):
    found, expected = first.arrays(), second.arrays()
    assert found.keys() == expected.keys()
    for key in found.keys() - set(but):
        assert found[key].tobytes() == expected[key].tobytes(), key


@OF_OWN
def test_what_never_arrives_changes_nothing(name, own):
    """A delay longer than the run, or hardly any message that arrives: independent agents."""
    alone, run = after_a_run(name, {**MEETING, **own, "communication": False})
    for options in ({"communication_delay_s": 300}, NEVER):
        controller, same = after_a_run(name, {**MEETING, **own, **options})
        assert same.measures.wait_veh_s == run.measures.wait_veh_s
        same_arrays(controller, alone)
        sent = controller.memory_use().messages
        # Five meetings of four agents; or one, whose answer is still under way at the end.
        assert sent == (20 if options is NEVER else 8)
    assert run.memory[-1].messages == run.memory[-1].exchanged_bytes == 0


@pytest.mark.parametrize(("name", "own"), OWN[:-1], ids=str)
def test_an_answer_before_the_next_decision_is_not_late(name, own):
    """Nobody looks at the memory between two decisions. (Visits stay with other rows.)"""
    prompt, run = after_a_run(name, {**MEETING, **own})
    for delay_s in (1, 10):
        late, same = after_a_run(name, {**MEETING, **own, "communication_delay_s": delay_s})
        assert same.measures.wait_veh_s == run.measures.wait_veh_s
        assert late.memory_use() == prompt.memory_use()
        same_arrays(late, prompt, but=["visits"])
    _, later = after_a_run(name, {**MEETING, **own, "communication_delay_s": 20})
    assert later.memory != run.memory


def test_while_an_answer_is_under_way_nobody_meets():
    _, run = after_a_run("sarsa", {**MEETING, "communication_delay_s": 70})
    messages = {time_s: use.messages for time_s, use in zip(run.time_s, run.memory, strict=True)}
    # At 50; its answer comes at 120, when the meeting of 100 is overdue; the next at 190.
    assert [messages[t] for t in (40, 50, 110, 120, 180, 190, 250, 260)] == [
        0, 8, 8, 16, 16, 24, 24, 32,
    ]  # fmt: skip


@EACH
def test_messages_and_bytes_by_hand(name):
    """The memory at a meeting is sent by four, and what they have in common goes to four."""
    controller = make_controller(
        name, {**MEETING, "short_capacity": 3} if name != "sarsa" else MEETING
    )
    controller.reset(RunContext(SCENARIO.network, SCENARIO.timing, stream(1)))
    rng, reward, expected, met = stream(2, "queues"), None, 0, 0
    # Keys of 12 counts; of a table Q and a flag for 8 actions, of long-term memory action and Q.
    row_bytes = 48 + (8 * 9 if name == "sarsa" else 12)
    for k in range(30):
        queue = rng.poisson(1.0, (4, 12)).astype(np.int32)
        controller.decide(observed(queue, 10 * k), reward)
        reward = rng.standard_normal(4)
        use = controller.memory_use()
        if k and k % 5 == 0:
            met += 1
            # What all have now went to each of them; before, each had sent a part of it.
            in_common = use.table_entries + use.long_term_entries
            sent, rest = divmod(use.exchanged_bytes - expected, row_bytes)
            assert rest == 0 and 5 * in_common <= sent <= 8 * in_common
            expected = use.exchanged_bytes
        assert (use.messages, use.exchanged_bytes) == (8 * met, expected)
    controller.reset(RunContext(SCENARIO.network, SCENARIO.timing, stream(1)))
    assert controller.memory_use().messages == controller.memory_use().exchanged_bytes == 0


def observed(queue, time_s):
    nothing = np.zeros(len(queue), np.int32)
    return Observation(queue, 0 * queue, nothing, nothing, time_s, np.zeros(queue.shape))


def decided(controller, seen, reward):
    return controller.decide(seen, reward).tolist()


def test_two_agents_exchange_what_can_be_counted():
    """One row each at the first meeting, of two classes: 2 rows sent, 2 · 2 rows returned."""
    made = scenario("grid:1x2", horizon_s=300)
    controller = make_controller("sarsa", {"communication": True, "communication_period_s": 10})
    controller.reset(RunContext(made.network, made.timing, stream(1)))
    queue = np.zeros((2, 12), np.int32)
    queue[1, 3] = 2
    controller.decide(observed(queue, 0), None)
    assert controller.memory_use().messages == 0
    controller.decide(observed(queue, 10), np.ones(2))
    use = controller.memory_use()
    assert use.messages == 4 and use.exchanged_bytes == (2 + 4) * (48 + 72)
    assert use.table_entries == use.entries_total == 2


@pytest.mark.parametrize(
    "options", [{"shared": True}, {"learning": False}, {"communication": False}]
)
def test_whoever_does_not_communicate_sends_nothing(options):
    controller, run = after_a_run("sarsa", {**MEETING, **NEVER, **options})
    assert {(use.messages, use.exchanged_bytes) for use in run.memory} == {(0, 0)}
    # Settings of what is not used change nothing.
    plain, same = after_a_run("sarsa", {"embedding": "complex", **options})
    assert run.measures.wait_veh_s == same.measures.wait_veh_s
    same_arrays(controller, plain)
    assert (NO_MEMORY.messages, NO_MEMORY.exchanged_bytes) == (0, 0)


@OF_OWN
def test_the_same_seed_loses_the_same_messages(name, own):
    options = {**MEETING, **own, "message_loss": 0.4, "communication_delay_s": 15}
    (first, run), (second, again) = (after_a_run(name, options) for _ in range(2))
    assert run.memory == again.memory
    same_arrays(first, second)
    _, other = after_a_run(name, options, seed=2)
    assert other.memory != run.memory


def test_losses_have_a_stream_of_their_own():
    rng, untouched = stream(3, "exploration"), stream(3, "exploration")
    members = np.arange(4000, dtype=np.int32)
    heard, reached = Post(0.25, rng).arrived(members)
    assert rng.random(9).tolist() == untouched.random(9).tolist()
    assert abs(heard.size - 3000) < 120 and abs(reached.size - 3000) < 120
    # Independently: nine of sixteen pairs are whole.
    assert abs(np.intersect1d(heard, reached).size - 2250) < 140
    assert [each.tolist() for each in Post(0.0, rng).arrived(members)] == 2 * [members.tolist()]


def test_triggers_by_hand():
    news = np.zeros((4, NEWS))
    news[:, ROWS], news[:, CHANGE], news[:, STAGED] = (2, 0, 1, 1), (0.5, 0, 0, 0.25), (0, 2, 0, 0)

    def due(**options):
        return Meetings(DualMemorySettings(**options), 1).due(0, 0, news, np.arange(len(news)))

    assert due(trigger="entries", trigger_entries=1.0)
    assert not due(trigger="entries", trigger_entries=1.01)
    assert due(trigger="values", trigger_change=0.1875)
    assert not due(trigger="values", trigger_change=0.19)
    assert due(trigger="staging", trigger_share=0.25)
    assert not due(trigger="staging", trigger_share=0.26)
    assert not due(trigger="period")
    sarsa = Meetings(SarsaSettings(trigger="entries"), 1)
    assert sarsa.due(0, 0, news, np.arange(len(news))) and not sarsa.due(
        0, 0, 0 * news, np.arange(len(news))
    )


@pytest.mark.parametrize("trigger", ["entries", "values", "staging"])
def test_agents_meet_when_they_have_something_to_tell(trigger):
    thresholds = {"trigger_entries": 2.0, "trigger_change": 2.0, "trigger_share": 0.5}
    options = {**MEETING, "short_capacity": 4, "trigger": trigger, **thresholds}
    _, run = after_a_run("dual-memory", options)
    messages = [use.messages for use in run.memory]
    assert messages[0] == messages[1] == 0
    # The period says nothing any more; not every decision is a meeting.
    assert 2 < len(set(messages)) < len(messages) - 2


@pytest.mark.parametrize(
    ("name", "options", "said"),
    [
        ("sarsa", {"trigger": "staging"}, "'period', 'entries' or 'values'"),
        ("sarsa", {"sent": "both"}, "there is no option named 'sent'"),
        ("dual-memory", {"trigger": "queue"}, "'staging'"),
        ("dual-memory", {"message_loss": 1.0}, "less than 1"),
        ("dual-memory", {"communication_delay_s": -1}, "greater than or equal to 0"),
        ("dual-memory", {"trigger_share": 0}, "greater than 0"),
        ("sarsa", {"trigger_change": float("inf")}, "finite"),
    ],
    ids=str,
)
def test_what_cannot_be_is_refused(name, options, said):
    with pytest.raises(InputError, match=said):
        make_controller(name, options)


@OF_OWN
def test_a_policy_does_not_hold_what_is_under_way(name, own):
    options = {**MEETING, **own, "communication_delay_s": 100, "message_loss": 0.2}
    alone, _ = after_a_run(name, {**options, "communication": False})
    # A meeting at 250 s: its answer would come at 350 s, and the one of 150 s has come.
    controller, _ = after_a_run(name, options)
    copy = make_controller(name, options)
    copy.reset(RunContext(SCENARIO.network, SCENARIO.timing, stream(9)))
    copy.restore(controller.arrays())
    again, same = (evaluate(SIMULATOR, each, VEHICLES, REWARD, 4) for each in (controller, copy))
    assert again.memory == same.memory
    same_arrays(copy, controller)
    assert alone.arrays().keys() == copy.arrays().keys()


def test_what_is_restored_in_a_run_waits_for_no_answer():
    options = {**MEETING, "communication_delay_s": 100}
    learned, _ = after_a_run("sarsa", MEETING)
    controller = make_controller("sarsa", options)
    controller.reset(RunContext(SCENARIO.network, SCENARIO.timing, stream(1)))
    rng = stream(4, "queues")
    for k in range(20):
        queue = rng.poisson(1.0, (4, 12)).astype(np.int32)
        controller.decide(observed(queue, 10 * k), np.ones(4) if k else None)
        if k == 6:
            # Sent at 50 s, due at 150 s: an average of tables that are no more.
            assert controller._answers
            controller.restore(learned.arrays())
            assert not controller._answers
    assert controller.memory_use().messages == 16


OPTIONS = [
    {"communication_delay_s": 30, "message_loss": 0.3},
    {"trigger": "entries", "trigger_entries": 2.0, "communication_delay_s": 20},
    {"trigger": "values", "trigger_change": 0.5},
    {"announced": True},
]
DUAL = [
    {"sent": "short", "short_capacity": 3},
    {"sent": "both", "short_capacity": 3, "staging": "visits", "message_loss": 0.5},
    {"sent": "both", "short_capacity": 4, "long_capacity": 7, "communication_delay_s": 30},
    {"sent": "long", "short_capacity": 2, "long_capacity": 7, "message_loss": 0.4},
    {"trigger": "staging", "short_capacity": 3, "stage_period": 5, "sent": "both"},
]
TRIED = [("sarsa", each) for each in OPTIONS] + [("dual-memory", each) for each in OPTIONS + DUAL]


@pytest.mark.parametrize(("name", "options"), TRIED, ids=str)
def test_our_controllers_conform_however_they_communicate(name, options):
    # Where no two intersections are alike, and where all are.
    grounds = proving_grounds()[-1], scenario("grid:1x2")
    for each in grounds:
        check_controller(
            lambda: make_controller(name, {**MEETING, "epsilon": 0.2, **options}),
            replace(each, horizon_s=150),
        )


@pytest.mark.parametrize(("name", "options"), TRIED, ids=str)
def test_resumed_training_is_uninterrupted_training(name, options):
    whole, first, second = (make_controller(name, {**MEETING, **options}) for _ in range(3))
    train(SCENARIO, whole, REWARD, 1, episodes=range(4), simulator=SIMULATOR)
    train(SCENARIO, first, REWARD, 1, episodes=range(2), simulator=SIMULATOR)
    second.reset(RunContext(SCENARIO.network, SCENARIO.timing, stream(9)))
    second.restore({key: array.copy() for key, array in first.arrays().items()})
    train(SCENARIO, second, REWARD, 1, episodes=range(2, 4), simulator=SIMULATOR)
    same_arrays(second, whole)
    assert second.memory_use() == whole.memory_use()


@EACH
def test_announced_vehicles_count_as_queued(name):
    """What is looked up and learned on is the queue with those that will join it."""
    options = {"embedding": "exact", "epsilon": 0.3}
    told, plain = (make_controller(name, {**options, "announced": on}) for on in (True, False))
    network, timing = SCENARIO.network, SignalTiming()
    for each in (told, plain):
        each.reset(RunContext(network, timing, stream(1)))
    announcements = Announcements(RunContext(network, timing, stream(1)))
    rng, reward, more = stream(3, "queues"), None, 0
    for k in range(60):
        queue, coming = (rng.poisson(mean, (4, 12)).astype(np.int32) for mean in (1.0, 0.3))
        shown = rng.integers(0, 8, 4).astype(np.int32)
        seen = Observation(queue, coming, shown, 0 * shown, 10 * k, queue.astype(float))
        full = announcements.queue_with_inflow(seen, shown)
        more += int((full - queue).sum())
        as_queue = Observation(full, coming, shown, 0 * shown, 10 * k, queue.astype(float))
        assert decided(told, seen, reward) == decided(plain, as_queue, reward)
        reward = rng.standard_normal(4)
    assert more > 100
    same_arrays(told, plain)
