import numpy as np
import pytest

from dmil.simulation.timing import (
    NEVER_S,
    PROGRAM,
    Programs,
    Rules,
    Signals,
    follow_programs,
    grant,
)

# One intersection, four movements: 0 and 1 in phase 0, 1 and 2 in phase 1; 3 always may go.
SERVED = np.array([[[1, 1, 0, 1], [0, 1, 1, 1]]], np.bool_)
UNSIGNALLED = np.array([[0, 0, 0, 1]], np.bool_)
SIGNALS = Signals(np.array([2], np.int32), SERVED, UNSIGNALLED)
RED = NEVER_S


def rules(
    count=1, *, min_green_s=0, max_green_s=0, clearance_s=0, startup_lost_s=0, all_stop=False
):
    """Rules of some intersections; numbers hold for all phases, lists say each one's."""

    def of_phases(times, *shape):
        found = np.broadcast_to(np.array(times, np.int32), (count, *shape)).copy()
        found.flags.writeable = False  # as from a scenario
        return found

    return Rules(
        10,
        startup_lost_s,
        of_phases(clearance_s, 2, 2),
        of_phases(min_green_s, 2),
        of_phases(max_green_s, 2),
        np.full(count, all_stop),
    )


class Signal:
    """One signal under fixed rules."""

    def __init__(self, **times):
        self.rules = rules(**times)
        self.phase = np.array([-1], np.int32)
        self.green_from_s = np.array([0], np.int32)
        self.go_from_s = np.full((1, 4), NEVER_S, np.int32)
        self.switch_s = np.full(1, NEVER_S, np.int32)

    def ask(self, phase, time_s):
        """Ask for a phase; return whether that was overruled."""
        wanted = np.array([phase], np.int32)
        arrays = wanted, self.phase, self.green_from_s, self.go_from_s, self.switch_s
        return grant(SIGNALS, *arrays, time_s, self.rules) == 1

    @property
    def go(self):
        return self.go_from_s[0].tolist()


def test_the_first_phase_needs_no_clearance():
    signal = Signal(clearance_s=4)
    assert not signal.ask(0, 0)
    assert signal.phase.tolist() == [0]
    assert signal.green_from_s.tolist() == [0]
    assert signal.go == [0, 0, RED, 0]


def test_a_change_turns_others_green_and_red():
    signal = Signal()
    signal.ask(0, 0)
    assert not signal.ask(1, 10)
    assert signal.green_from_s.tolist() == [10]
    assert signal.go == [RED, 0, 10, 0]


def test_clearance_delays_only_movements_that_had_red():
    signal = Signal(clearance_s=4)
    signal.ask(0, 0)
    signal.ask(1, 10)
    assert signal.green_from_s.tolist() == [14]
    assert signal.go == [RED, 0, 14, 0]


def test_an_all_stop_clearance_stops_those_too_who_keep_their_green():
    signal = Signal(clearance_s=4, startup_lost_s=2, all_stop=True)
    signal.ask(0, 0)
    assert signal.go == [2, 2, RED, 0]
    signal.ask(0, 10)
    assert signal.go == [2, 2, RED, 0], "nobody stops while the phase stays"
    signal.ask(1, 20)
    assert signal.go == [RED, 26, 26, 0]


def test_start_up_lost_time_comes_after_the_clearance_and_at_the_first_green():
    signal = Signal(clearance_s=4, startup_lost_s=2)
    signal.ask(0, 0)
    assert signal.go == [2, 2, RED, 0]
    signal.ask(1, 10)
    assert signal.green_from_s.tolist() == [14]
    assert signal.go == [RED, 2, 16, 0]


def test_a_movement_that_loses_its_green_starts_anew():
    signal = Signal(startup_lost_s=3)
    for phase, time_s in ((0, 0), (1, 10), (0, 20)):
        signal.ask(phase, time_s)
    assert signal.go == [23, 3, RED, 0]


def test_the_phase_shown_goes_on_when_it_is_asked_for_again():
    signal = Signal(min_green_s=30, startup_lost_s=3)
    signal.ask(0, 0)
    assert not signal.ask(0, 10)
    assert signal.green_from_s.tolist() == [0]
    assert signal.go == [3, 3, RED, 0]


@pytest.mark.parametrize(("time_s", "refused"), [(10, True), (24, True), (25, False), (30, False)])
def test_a_green_lasts_its_least_time(time_s, refused):
    signal = Signal(min_green_s=25)
    signal.ask(0, 0)
    assert signal.ask(1, time_s) is refused
    assert signal.phase.tolist() == [0 if refused else 1]
    assert signal.go == ([0, 0, RED, 0] if refused else [RED, 0, time_s, 0])


def test_least_green_counts_from_the_end_of_the_clearance():
    signal = Signal(min_green_s=10, clearance_s=4)
    signal.ask(0, 0)
    signal.ask(1, 10)
    assert signal.ask(0, 20)
    assert signal.ask(0, 23)
    assert not signal.ask(0, 24)


def test_a_clearance_that_runs_is_not_cut_short():
    signal = Signal(clearance_s=9)
    signal.ask(0, 0)
    signal.ask(1, 5)
    assert signal.ask(0, 13)
    assert not signal.ask(0, 14)


def test_refusals_are_counted_over_all_intersections():
    signals = Signals(*(np.repeat(array, 3, axis=0) for array in SIGNALS))
    phase, green_from_s = np.array([0, 0, 0], np.int32), np.array([0, 8, 9], np.int32)
    go_from_s, switch_s = np.zeros((3, 4), np.int32), np.full(3, NEVER_S, np.int32)
    wanted = np.array([1, 1, 1], np.int32)
    arrays = wanted, phase, green_from_s, go_from_s, switch_s
    assert grant(signals, *arrays, 10, rules(3, min_green_s=5)) == 2
    assert phase.tolist() == [1, 0, 0]


@pytest.mark.parametrize(("time_s", "ended"), [(10, False), (29, False), (30, True), (45, True)])
def test_the_longest_green_is_ended_by_the_next_phase(time_s, ended):
    signal = Signal(max_green_s=30, clearance_s=4)
    signal.ask(1, 0)
    assert signal.ask(1, time_s) is ended
    assert signal.phase.tolist() == [0 if ended else 1]
    assert signal.green_from_s.tolist() == [time_s + 4 if ended else 0]


def test_a_change_in_time_is_not_overruled_by_the_longest_green():
    signal = Signal(max_green_s=30)
    signal.ask(1, 0)
    assert not signal.ask(0, 40)
    assert signal.phase.tolist() == [0]


def test_a_single_phase_may_last_for_ever():
    signals = Signals(np.array([1], np.int32), SERVED[:, :1], UNSIGNALLED)
    phase, green_from_s = np.array([0], np.int32), np.array([0], np.int32)
    go_from_s, switch_s = np.zeros((1, 4), np.int32), np.full(1, NEVER_S, np.int32)
    arrays = np.array([0], np.int32), phase, green_from_s, go_from_s, switch_s
    assert grant(signals, *arrays, 100, rules(max_green_s=20)) == 0


# Stages of the own program: 10 s movements 0 and 1, 3 s nobody, 7 s movement 2; 3 always may go.
GREEN = np.array([[1, 1, 0, 1], [0, 0, 0, 1], [0, 0, 1, 1]], np.bool_)


def programs(begin_s=0):
    offset, end_s = np.array([0, 3], np.int32), np.array([10, 13, 20], np.int32)
    return Programs(offset, end_s, GREEN, np.array([begin_s], np.int32))


def follow(signal, time_s, begin_s=0, startup_lost_s=0):
    arrays = signal.go_from_s, signal.switch_s
    return follow_programs(programs(begin_s), *arrays, time_s, startup_lost_s)


def test_the_own_program_shows_its_stages_in_turn():
    signal = Signal()
    assert not signal.ask(PROGRAM, 0)
    assert signal.phase.tolist() == [-1]
    assert follow(signal, 0) == 10
    assert signal.go == [0, 0, RED, 0]
    assert follow(signal, 10) == 13
    assert signal.go == [RED, RED, RED, 0]
    assert follow(signal, 13, startup_lost_s=2) == 20
    assert signal.go == [RED, RED, 15, 0]
    assert follow(signal, 20) == 30
    assert signal.go == [20, 20, RED, 0]


def test_the_own_program_begins_where_its_offset_says():
    signal = Signal()
    signal.ask(PROGRAM, 0)
    assert follow(signal, 0, begin_s=12) == 1
    assert signal.go == [RED, RED, RED, 0]


def test_a_program_that_goes_on_is_not_begun_again():
    signal = Signal()
    signal.ask(PROGRAM, 0)
    follow(signal, 0)
    signal.ask(PROGRAM, 7)
    assert signal.switch_s.tolist() == [10]


def test_a_phase_after_the_own_program_takes_over_at_once():
    signal = Signal(clearance_s=4)
    signal.ask(PROGRAM, 0)
    follow(signal, 0)
    assert not signal.ask(1, 5)
    assert signal.go == [RED, 0, 5, 0]
    assert signal.switch_s.tolist() == [NEVER_S]
    assert follow(signal, 5) == NEVER_S


def test_who_does_not_follow_a_program_is_left_alone():
    signal = Signal()
    signal.ask(0, 0)
    assert follow(signal, 0) == NEVER_S
    assert signal.go == [0, 0, RED, 0]


def test_clearance_and_greens_are_those_of_the_phases_in_question():
    signal = Signal(
        clearance_s=[[0, 3], [6, 0]], min_green_s=[5, 20], max_green_s=[0, 30], startup_lost_s=1
    )
    signal.ask(0, 0)
    assert signal.ask(1, 4)
    assert not signal.ask(1, 10)
    assert signal.green_from_s.tolist() == [13]
    assert signal.go == [RED, 1, 14, 0]
    assert signal.ask(0, 30)  # 17 s of 20
    assert signal.ask(1, 50)  # 37 s are too many
    assert signal.phase.tolist() == [0]
    assert signal.green_from_s.tolist() == [56]
    assert not signal.ask(0, 200)
