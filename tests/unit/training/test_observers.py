"""Whoever watches a run hears all of it, in order, and changes nothing."""

import numpy as np

from dmil.controllers import make_controller
from dmil.rewards import make_reward
from dmil.scenarios import scenario
from dmil.seeding import stream
from dmil.simulation import QueueSimulator
from dmil.training import evaluate, run, vehicles_of_seed
from dmil.training.observers import MemoryRecorder, Observer

SCENARIO = scenario("grid:1x2", horizon_s=120)
REWARD = make_reward("diffusion")


class Diary(Observer):
    """Writes down all that it hears."""

    def begin(self, simulator, controller, seen):
        self.heard = [("begin", seen.time_s)]
        self.phases = []

    def decided(self, seen, phases):
        self.heard.append(("decided", seen.time_s))
        self.phases.append(phases)

    def advanced(self, phases, seen):
        self.heard.append(("advanced", seen.time_s))
        assert phases is self.phases[-1]


def evaluated(*observers):
    controller = make_controller("sarsa", {"epsilon": 0.3})
    vehicles = vehicles_of_seed(SCENARIO, 0)
    return evaluate(QueueSimulator(SCENARIO), controller, vehicles, REWARD, 0, observers=observers)


def test_a_run_is_told_in_order():
    diary = Diary()
    evaluated(diary)
    times = range(0, 120, 10)
    expected = [("begin", 0)]
    for time_s in times:
        expected += [("decided", time_s), ("advanced", time_s + 10)]
    assert diary.heard == expected


def test_one_observer_watches_several_runs_and_several_watch_one():
    diary, other = Diary(), Diary()
    evaluated(diary)
    evaluated(diary, other)
    assert diary.heard == other.heard
    assert len(diary.heard) == 25


def test_who_watches_changes_nothing():
    watched, alone = evaluated(Diary(), MemoryRecorder()), evaluated()
    assert watched.measures.wait_veh_s == alone.measures.wait_veh_s
    np.testing.assert_array_equal(watched.measures.queued_at, alone.measures.queued_at)
    assert watched.memory == alone.memory


def test_the_memory_is_noted_at_every_decision_of_a_test_and_else_at_the_end():
    tested = evaluated()
    assert tested.time_s == (*range(0, 120, 10), 120)
    entries = [use.entries for use in tested.memory]
    assert entries == sorted(entries)
    assert entries[0] < entries[-1]
    controller = make_controller("sarsa", {"epsilon": 0.3})
    vehicles = vehicles_of_seed(SCENARIO, 0)
    alone = run(QueueSimulator(SCENARIO), controller, vehicles, REWARD, stream(0, "exploration"))
    assert alone.time_s == (120,)
    assert np.isclose(alone.memory[0].entries, entries[-1])
