import numpy as np
import pytest

from dmil.simulation.timing import NEVER_S, Rules, grant

# One intersection, four movements: 0 and 1 in phase 0, 1 and 2 in phase 1; 3 always may go.
SERVED = np.array([[[1, 1, 0, 1], [0, 1, 1, 1]]], np.bool_)
UNSIGNALLED = np.array([[0, 0, 0, 1]], np.bool_)
RED = NEVER_S


class Signal:
    """One signal under fixed rules."""

    def __init__(self, *, min_green_s=0, clearance_s=0, startup_lost_s=0):
        self.rules = Rules(10, clearance_s, min_green_s, startup_lost_s)
        self.phase = np.array([-1], np.int32)
        self.green_from_s = np.array([0], np.int32)
        self.go_from_s = np.full((1, 4), NEVER_S, np.int32)

    def ask(self, phase, time_s):
        """Ask for a phase; return whether it was refused."""
        wanted = np.array([phase], np.int32)
        arrays = wanted, self.phase, self.green_from_s, self.go_from_s
        return grant(SERVED, UNSIGNALLED, *arrays, time_s, self.rules) == 1

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
    served, unsignalled = np.repeat(SERVED, 3, axis=0), np.repeat(UNSIGNALLED, 3, axis=0)
    phase, green_from_s = np.array([0, 0, 0], np.int32), np.array([0, 8, 9], np.int32)
    go_from_s = np.zeros((3, 4), np.int32)
    wanted = np.array([1, 1, 1], np.int32)
    assert (
        grant(served, unsignalled, wanted, phase, green_from_s, go_from_s, 10, Rules(10, 0, 5, 0))
        == 2
    )
    assert phase.tolist() == [1, 0, 0]
