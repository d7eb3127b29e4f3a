"""Self-organising lights, decision by decision."""

import numpy as np

from dmil.controllers import RunContext, make_controller
from dmil.network import grid
from dmil.scenarios import SignalTiming
from dmil.seeding import stream
from dmil.simulation import Observation

EW_F, EW_L, NS_F, NS_L = range(4)


def organised(interval_s=10, **options):
    controller = make_controller("sotl", options)
    timing = SignalTiming(decision_interval_s=interval_s)
    controller.reset(RunContext(grid(1, 1), timing, stream(0, "none")))
    return controller


def decide(controller, shown, elapsed_s=10, queue=(), approaching=()):
    queue_veh, approaching_veh = np.zeros((2, 1, 12), np.int32)
    np.add.at(queue_veh[0], list(queue), 1)
    np.add.at(approaching_veh[0], list(approaching), 1)
    phase, elapsed = np.array([[shown], [elapsed_s]], np.int32)
    seen = Observation(queue_veh, approaching_veh, phase, elapsed, 0, np.zeros((1, 12)))
    return int(controller.decide(seen, None)[0])


def test_a_run_begins_with_the_phase_that_most_come_to():
    assert decide(organised(), -1) == EW_F
    assert decide(organised(), -1, queue=[1, 5], approaching=[11]) == NS_L


def test_a_phase_gets_green_once_enough_vehicle_seconds_are_counted():
    controller = organised(theta_veh_s=50)
    decide(controller, -1)
    # 10 s × 1, 2 and 2 vehicles: 10, 30 and 50 vehicle-seconds.
    assert decide(controller, EW_F, queue=[4]) == EW_F
    assert decide(controller, EW_F, queue=[4], approaching=[10]) == EW_F
    assert decide(controller, EW_F, queue=[4, 10]) == NS_F


def test_counts_are_in_seconds():
    controller = organised(interval_s=5, theta_veh_s=50)
    shown = [decide(controller, EW_F, queue=[4, 10]) for _ in range(5)]
    assert shown == [EW_F] * 4 + [NS_F]


def test_green_sets_a_count_to_zero():
    controller = organised(theta_veh_s=20)
    assert decide(controller, EW_F, queue=[4]) == EW_F
    assert decide(controller, EW_F, queue=[4]) == NS_F
    assert decide(controller, NS_F, queue=[]) == NS_F
    assert decide(controller, EW_F, queue=[4]) == EW_F  # 10 and not 30 vehicle-seconds


def test_of_several_phases_the_one_with_the_highest_count_follows():
    controller = organised(theta_veh_s=10)
    assert decide(controller, EW_F, queue=[4, 5, 11]) == NS_L


def test_a_red_light_before_which_nobody_was_never_gets_green():
    controller = organised(theta_veh_s=0)
    assert [decide(controller, NS_F) for _ in range(3)] == [NS_F] * 3


def test_green_is_kept_for_its_minimum():
    controller = organised(theta_veh_s=10, min_green_s=20)
    assert decide(controller, EW_F, 10, queue=[4, 4]) == EW_F
    assert decide(controller, EW_F, 20, queue=[4, 4]) == NS_F


def test_the_end_of_a_platoon_is_let_through_and_a_long_column_is_cut():
    for coming, phase in (([], NS_F), ([1], EW_F), ([1, 7], EW_F), ([1, 1, 7], NS_F)):
        controller = organised(theta_veh_s=10, mu_veh=3)
        assert decide(controller, EW_F, queue=[4, 4, 4, 4], approaching=coming) == phase


def test_a_new_run_counts_from_zero():
    controller = organised(theta_veh_s=50)
    for _ in range(2):
        decide(controller, EW_F, queue=[4, 10])
    controller.reset(RunContext(grid(1, 1), SignalTiming(), stream(0, "none")))
    assert decide(controller, EW_F, queue=[4, 10]) == EW_F
