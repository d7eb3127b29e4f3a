"""From requested phases to what SUMO's signals are told."""

import numpy as np
import pytest

from dmil.network.sumo import SumoSignals
from dmil.scenarios import SignalTimes
from dmil.simulation.sumo.signals import SignalHeads, cleared
from dmil.simulation.timing import ACTUATED, PROGRAM, Signals

# Movements 0 and 1 in phase 0, 1 and 2 in phase 1; 3 always may go. Two intersections alike.
SERVED = np.array([[[1, 1, 0, 1], [0, 1, 1, 1]]] * 2, np.bool_)
UNSIGNALLED = np.array([[0, 0, 0, 1]] * 2, np.bool_)
SIGNALS = Signals(np.array([2, 2], np.int32), SERVED, UNSIGNALLED)
STATES = tuple(
    SumoSignals(name, ("GGrg", "rgGg"), tuple((j,) for j in range(4))) for name in ("a", "b")
)


def heads(walks=None, **timing):
    """Heads that are asked every 10 s; numbers hold for all phases, lists say each one's."""
    shapes = {"clearance_s": (2, 2, 2), "all_red_s": (2, 2, 2), "all_stop": (2,)}
    times = SignalTimes(
        *(
            np.broadcast_to(np.int32(timing.get(name, 0)), shapes.get(name, (2, 2))).copy()
            for name in SignalTimes._fields
        )
    )
    return SignalHeads(SIGNALS, STATES, times, 10, walks or [((), ())] * 2)


def ask(signals, phases, time_s):
    return signals.request(np.array(phases, np.int32), time_s)


@pytest.mark.parametrize(
    ("before", "after", "yellow", "red"),
    [
        ("Gr", "rG", "yr", "rr"),
        ("GG", "Gr", "Gy", "Gr"),
        ("Gg", "gG", "gg", "gg"),
        ("sG", "sr", "sy", "sr"),
        ("sg", "gs", "ss", "ss"),
        ("rs", "sr", "rr", "rr"),
    ],
)
def test_between_two_phases(before, after, yellow, red):
    assert cleared(before, after, "y") == yellow
    assert cleared(before, after, "r") == red


def test_an_all_stop_clearance_leaves_green_to_those_alone_who_always_have_it():
    signals = heads(clearance_s=4, all_red_s=1, all_stop=[1, 0])
    ask(signals, [0, 0], 0)
    switches = ask(signals, [1, 1], 10).switches
    assert [each[1:] for each in switches if each[1] == "a"] == [
        ("a", "yyrg"),
        ("a", "rrrg"),
        ("a", "rgGg"),
    ]
    assert ("b", "ygrg") in [each[1:] for each in switches]
    assert cleared("GsGr", "GsrG", "y", frozenset()) == "ysyr"


def test_the_first_phase_is_shown_at_once():
    orders = ask(heads(clearance_s=4, all_red_s=1), [0, 1], 0)
    assert orders.switches == [(0, "a", "GGrg"), (0, "b", "rgGg")]
    assert orders.programs == []


def test_a_change_goes_through_yellow_and_all_red():
    signals = heads(clearance_s=4, all_red_s=1)
    ask(signals, [0, 0], 0)
    orders = ask(signals, [1, 0], 10)
    assert orders.switches == [(0, "a", "ygrg"), (3, "a", "rgrg"), (4, "a", "rgGg")]
    assert signals.green_from_s.tolist() == [14, 0]


def test_switches_of_several_signals_come_in_the_order_of_time():
    signals = heads(clearance_s=3)
    ask(signals, [0, 0], 0)
    assert [(s, name) for s, name, _ in ask(signals, [1, 1], 10).switches] == [
        (0, "a"),
        (0, "b"),
        (3, "a"),
        (3, "b"),
    ]


def test_a_phase_that_stays_needs_no_order():
    signals = heads(clearance_s=3)
    ask(signals, [0, 0], 0)
    assert ask(signals, [0, 0], 10) == ([], [])


def test_a_request_that_the_rules_refuse_changes_nothing():
    signals = heads(min_green_s=15)
    ask(signals, [0, 0], 0)
    assert ask(signals, [1, 0], 10) == ([], [])
    assert signals.phase.tolist() == [0, 0]
    assert signals.overruled == 1
    assert ask(signals, [1, 0], 20).switches == [(0, "a", "rgGg")]


def test_longest_green_ends_without_being_asked():
    signals = heads(max_green_s=20)
    ask(signals, [0, 1], 0)
    ask(signals, [0, 0], 10)
    assert ask(signals, [0, 0], 20).switches == [(0, "a", "rgGg")]
    assert signals.overruled == 1


def test_programs_begin_once_and_mix_with_phases():
    signals = heads(clearance_s=3)
    first = ask(signals, [PROGRAM, 0], 0)
    assert first.programs == [("a", False)]
    assert first.switches == [(0, "b", "GGrg")]
    second = ask(signals, [PROGRAM, ACTUATED], 10)
    assert second == ([("b", True)], [])
    assert ask(signals, [ACTUATED, ACTUATED], 20) == ([("a", True)], [])
    assert signals.phase.tolist() == [-1, -1]
    # What the program shows is not known here: a phase after it comes at once.
    assert ask(signals, [1, ACTUATED], 30).switches == [(0, "a", "rgGg")]
    assert signals.green_from_s[0] == 30


def test_each_change_has_its_own_yellow_and_all_red():
    signals = heads(clearance_s=[[0, 3], [6, 0]], all_red_s=[[0, 0], [2, 0]])
    ask(signals, [0, 1], 0)
    assert ask(signals, [1, 0], 10).switches == [
        (0, "a", "ygrg"),
        (0, "b", "rgyg"),
        (3, "a", "rgGg"),
        (4, "b", "rgrg"),
        (6, "b", "GGrg"),
    ]


def test_a_clearance_longer_than_the_time_between_requests_goes_on_in_the_next():
    signals = heads(clearance_s=13, all_red_s=2)
    ask(signals, [0, 0], 0)
    assert ask(signals, [1, 0], 10).switches == [(0, "a", "ygrg")]
    assert ask(signals, [0, 0], 20).switches == [(1, "a", "rgrg"), (3, "a", "rgGg")]
    assert signals.overruled == 1
    assert ask(signals, [1, 0], 30).switches == []


def test_a_program_takes_over_from_a_clearance():
    signals = heads(clearance_s=13)
    ask(signals, [0, 0], 0)
    ask(signals, [1, 0], 10)
    assert ask(signals, [PROGRAM, 0], 20) == ([("a", False)], [])
