"""What a switch costs, and which vehicles count."""

import numpy as np
import pytest

from dmil.controllers import RunContext, make_controller
from dmil.controllers.rules.phase_choice import PhaseChoice
from dmil.network import grid
from dmil.scenarios import SignalTiming
from dmil.seeding import stream
from dmil.simulation import Observation

EW_F, EW_L, NS_F, NS_L, E_FL, N_FL, W_FL, S_FL = range(8)
WITH_CLEARANCE = SignalTiming(decision_interval_s=10, clearance_s=3, startup_lost_s=1)


def counts(network, given):
    array = np.zeros((len(network.intersections), 12), np.int32)
    for (i, j), count in given.items():
        array[i, j] = count
    return array


def decide(name, options, network, queue, approaching, shown, timing=WITH_CLEARANCE):
    controller = make_controller(name, options)
    controller.reset(RunContext(network, timing, stream(0, "none")))
    queue_veh, approaching_veh = counts(network, queue), counts(network, approaching)
    phase = np.full(len(network.intersections), shown, np.int32)
    zeros = np.zeros_like(phase)
    seen = Observation(queue_veh, approaching_veh, phase, zeros, 0, np.zeros(queue_veh.shape))
    before = queue_veh.copy()
    phases = controller.decide(seen, None)
    assert (queue_veh == before).all()
    return phases.tolist()


def choice(hysteresis, queue, shown, timing=WITH_CLEARANCE):
    network = grid(1, 1)
    weight = counts(network, {(0, j): count for j, count in queue.items()})
    chosen = PhaseChoice(network, timing, hysteresis)
    return int(chosen.best(weight, np.array([shown], np.int32))[0])


@pytest.mark.parametrize(("elsewhere", "phase"), [(9, EW_F), (10, EW_F), (11, NS_F)])
def test_a_switch_must_serve_more_in_what_is_left_than_staying_in_all(elsewhere, phase):
    # 6 vehicles for 10 s are worth as much as 10 vehicles for the 6 s that a switch leaves.
    assert choice(1.0, {1: 6, 4: elsewhere}, shown=EW_F) == phase


@pytest.mark.parametrize(("elsewhere", "phase"), [(8, EW_F), (9, NS_F)])
def test_half_the_hysteresis_is_half_the_margin(elsewhere, phase):
    # 6 vehicles lose 4 s of 6 s: 4 vehicles, and half of that is 2.
    assert choice(0.5, {1: 6, 4: elsewhere}, shown=EW_F) == phase


@pytest.mark.parametrize("hysteresis", [0.0, 1.0, 100.0])
def test_without_lost_time_a_switch_costs_nothing(hysteresis):
    assert choice(hysteresis, {1: 6, 4: 7}, EW_F, SignalTiming()) == NS_F


def test_without_hysteresis_a_switch_costs_nothing():
    assert choice(0.0, {1: 6, 4: 7}, EW_F) == NS_F


def test_a_phase_with_nobody_left_never_stays():
    assert choice(1e9, {4: 1}, EW_F) == NS_F


def test_movements_that_stay_green_lose_nothing():
    # From E/W straight to E straight and left: movement 1 goes on, so only movement 7 is lost.
    queue = {1: 50, 7: 6}
    assert choice(1.0, {**queue, 2: 10}, EW_F) == EW_F
    assert choice(1.0, {**queue, 2: 11}, EW_F) == E_FL


def test_the_first_phase_of_a_run_costs_nothing():
    assert choice(1.0, {1: 6, 4: 7}, shown=-1) == NS_F


def test_negative_weights_are_not_a_reason_to_stay_or_to_leave():
    network = grid(1, 1)
    weight = counts(network, {(0, 1): -3, (0, 7): -3, (0, 4): -2, (0, 10): -4})
    rest = {(0, j): -9 for j in (2, 5, 8, 11)}
    weight = (weight + counts(network, rest)).astype(float)
    chosen = PhaseChoice(network, WITH_CLEARANCE, 1.0)
    for shown in (EW_F, NS_F):
        # Both are worth −6; all others less.
        assert chosen.best(weight, np.array([shown], np.int32)).tolist() == [shown]


@pytest.mark.parametrize("name", ["longest-queue-first", "max-pressure"])
def test_vehicles_that_come_soon_count_only_if_asked_for(name):
    queue, approaching = {(0, 1): 3}, {(0, 4): 2, (0, 10): 2}
    arguments = grid(1, 1), queue, approaching, -1
    assert decide(name, {}, *arguments) == [EW_F]
    assert decide(name, {"approaching": True}, *arguments) == [NS_F]


def test_vehicles_that_drive_towards_the_next_intersection_do_not_lower_a_pressure():
    network = grid(1, 2)
    # Left: 3 from the West straight on, 2 from the North. Right: many come from the West.
    queue, approaching = {(0, 7): 3, (0, 4): 2}, {(1, 6): 9, (1, 7): 9, (1, 8): 9}
    options = {"approaching": True}
    assert decide("max-pressure", options, network, queue, approaching, -1)[0] == EW_F
    assert decide("max-pressure", options, network, {**queue, **approaching}, {}, -1)[0] == NS_F


@pytest.mark.parametrize("name", ["longest-queue-first", "max-pressure"])
def test_hysteresis_is_passed_on(name):
    arguments = grid(1, 1), {(0, 1): 6, (0, 4): 10}, {}, EW_F
    assert decide(name, {}, *arguments) == [NS_F]
    assert decide(name, {"hysteresis": 1.0}, *arguments) == [EW_F]
