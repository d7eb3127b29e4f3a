"""What the signals did: events, and the mean cycle that follows from them."""

import numpy as np
import pytest

from dmil.network import grid
from dmil.rewards import make_reward
from dmil.scenarios import SignalTiming, scenario
from dmil.simulation import QueueSimulator
from dmil.training import evaluate, vehicles_of_seed
from dmil.training.mean_cycle import LONGEST_GREEN_S, SHORT_GREEN_S, mean_cycles
from dmil.training.signal_events import EventRecorder, SignalEvent, signal_table

ONE = grid(1, 1)


def record(wanted, **timing):
    made = scenario("grid:1x1", horizon_s=10 * len(wanted), timing=SignalTiming(**timing))
    recorder, wishes = EventRecorder(), iter(wanted)

    class AsWanted:
        def reset(self, context):
            pass

        def decide(self, observation, reward):
            return np.array([next(wishes)], np.int32)

    vehicles = vehicles_of_seed(made, 0)
    reward = make_reward("queue")
    evaluate(QueueSimulator(made), AsWanted(), vehicles, reward, 0, observers=[recorder])
    return recorder.events


def test_every_change_is_one_event():
    events = record([0, 0, 2, 1, 1], clearance_s=3)
    assert events == [
        SignalEvent(0, 0, 0, -1, 0, 0, 0),
        SignalEvent(20, 0, 2, 0, 23, 20, 0),
        SignalEvent(30, 0, 1, 2, 33, 7, 0),
    ]


def test_what_was_not_granted_is_counted_until_the_next_change():
    events = record([0, 1, 2, 2, 2], min_green_s=25)
    assert [(event.time_s, event.phase, event.overruled) for event in events] == [
        (0, 0, 0),
        (30, 2, 2),
    ]
    forced = record([0, 0, 0, 0], max_green_s=30)
    assert [(event.time_s, event.phase, event.overruled) for event in forced] == [
        (0, 0, 0),
        (30, 1, 1),
    ]


def test_the_table_has_one_row_per_event():
    first, second = signal_table(record([0, 2], clearance_s=3), ONE).rows(named=True)
    assert (first["from_phase"], first["phase"]) == (None, 0)
    assert (second["time_s"], second["intersection"]) == (10, ONE.intersections[0].id)
    assert (second["phase"], second["from_phase"]) == (2, 0)
    assert (second["green_from_s"], second["green_before_s"]) == (13, 10)
    assert second["phase_name"] == ONE.intersections[0].phase_names[2]


def cycle(wanted, **window):
    window = {"begin_s": 0, "end_s": 10 * len(wanted)} | window
    return mean_cycles(record(wanted, clearance_s=3), ONE, **window)[0]


def test_the_mean_cycle_has_the_order_and_the_mean_greens_that_were_driven():
    found = cycle([0, 0, 3, 1, 2] * 4 + [0, 0, 0, 0])
    assert found.phases == (0, 3, 1, 2)
    # The first green has no clearance before it: 20 s; three of 17 s, the last of 37 s.
    assert found.green_s == (round((20 + 3 * 17 + 37) / 5), 7, 7, 7)
    assert found.left_out == tuple(range(4, len(ONE.intersections[0].phases)))
    assert (found.added, found.never_served) == ((), ())


def test_who_would_have_no_green_gets_a_short_one():
    found = cycle([0] * 30 + [1])
    served = ONE.intersections[0].unsignalled.union(
        *(ONE.intersections[0].phases[phase] for phase in found.phases)
    )
    assert len(served) == len(ONE.intersections[0].movements)
    assert found.phases[:2] == (0, 1)
    assert found.added == found.phases[2:] != ()
    assert found.green_s[0] == LONGEST_GREEN_S < 300
    assert set(found.green_s[2:]) == {SHORT_GREEN_S}


def test_phases_that_were_hardly_shown_are_left_out():
    found = cycle([0, 1, 2, 3] * 11 + [5])
    assert (found.phases, found.green_s) == ((0, 1, 2, 3), (7, 7, 7, 7))
    assert 5 in found.left_out


@pytest.mark.parametrize(("begin_s", "phases"), [(0, (0, 1)), (80, (2, 3))])
def test_a_part_of_a_run_has_a_plan_of_its_own(begin_s, phases):
    found = cycle([0, 1] * 4 + [2, 3] * 4, begin_s=begin_s, end_s=begin_s + 80)
    assert set(found.phases) - set(found.added) == set(phases)


def test_a_green_that_outlasts_a_part_is_its_plan():
    found = cycle([4] * 20, begin_s=100, end_s=200)
    assert found.phases[0] == 4
