"""Actuated control, decision by decision, and against queues that follow from arithmetic."""

import numpy as np
import pytest

from dmil.controllers import RunContext, make_controller
from dmil.demand import Vehicles
from dmil.network import grid
from dmil.scenarios import SignalTiming, scenario
from dmil.seeding import stream
from dmil.simulation import Observation, QueueSimulator

EW_F, EW_L, NS_F, NS_L = range(4)


def actuated(network, timing=None, **options):
    controller = make_controller("gap-out", options)
    controller.reset(RunContext(network, timing or SignalTiming(), stream(0, "none")))
    return controller


def decide(controller, shown, elapsed_s=10, queue=(), approaching=()):
    queue_veh, approaching_veh = np.zeros((2, 1, 12), np.int32)
    np.add.at(queue_veh[0], list(queue), 1)
    np.add.at(approaching_veh[0], list(approaching), 1)
    phase, elapsed = np.array([[shown], [elapsed_s]], np.int32)
    seen = Observation(queue_veh, approaching_veh, phase, elapsed, 0, np.zeros((1, 12)))
    return int(controller.decide(seen, None)[0])


def test_the_first_phase_of_the_sequence_with_demand_begins():
    assert decide(actuated(grid(1, 1)), -1) == EW_F
    assert decide(actuated(grid(1, 1)), -1, queue=[5, 4]) == NS_F
    assert decide(actuated(grid(1, 1)), -1, approaching=[11]) == NS_L


def test_phases_without_demand_are_skipped_in_a_circle():
    controller = actuated(grid(1, 1), extend_veh=1)
    assert decide(controller, -1, queue=[1]) == EW_F
    assert decide(controller, EW_F, queue=[4, 5]) == NS_F
    assert decide(controller, NS_F, queue=[2, 7]) == EW_F
    assert decide(controller, EW_F, queue=[11]) == NS_L


def test_who_always_may_go_is_no_demand():
    controller = actuated(grid(1, 1))
    assert decide(controller, -1, queue=[0, 3, 6, 9], approaching=[0, 3]) == EW_F
    assert decide(controller, EW_F, queue=[0, 3, 6, 9], approaching=[0, 3]) == EW_F


@pytest.mark.parametrize(
    ("queue", "approaching", "phase"),
    [([1], [], NS_F), ([], [7], NS_F), ([1], [7], EW_F), ([], [1, 1], EW_F), ([7, 7], [], EW_F)],
)
def test_enough_vehicles_extend_the_green(queue, approaching, phase):
    controller = actuated(grid(1, 1), extend_veh=2)
    decide(controller, -1, queue=[1])
    assert decide(controller, EW_F, queue=[4, *queue], approaching=approaching) == phase


def test_green_is_kept_for_its_minimum_even_without_vehicles():
    controller = actuated(grid(1, 1), min_green_s=20)
    decide(controller, -1, queue=[1])
    assert decide(controller, EW_F, 10, queue=[4]) == EW_F
    assert decide(controller, EW_F, 20, queue=[4]) == NS_F


def test_green_ends_before_it_exceeds_its_maximum_if_others_wait():
    for elapsed_s, waiting, phase in ((20, [4], EW_F), (21, [4], NS_F), (90, [], EW_F)):
        controller = actuated(grid(1, 1), max_green_s=30, extend_veh=1)
        decide(controller, -1, queue=[1])
        assert decide(controller, EW_F, elapsed_s, queue=[1, 7, *waiting]) == phase


def test_a_phase_that_was_refused_is_asked_for_again():
    controller = actuated(grid(1, 1))
    decide(controller, -1, queue=[1])
    assert decide(controller, EW_F, queue=[4]) == NS_F
    # The signals still show the one before; meanwhile somebody came to it.
    assert decide(controller, EW_F, queue=[1, 1, 1, 1, 4]) == NS_F


def first_green_s(decision_s, arrival_gap_s, standing_veh, **options):
    """Return how long a queue holds the green, and when it was empty in truth.

    West straight on has vehicles standing at 0 s and one more every ``arrival_gap_s``; one vehicle
    from the North waits for its end. Saturation flow is 1 vehicle per second.
    """
    made = scenario("grid:1x1", horizon_s=400, timing=SignalTiming(decision_interval_s=decision_s))
    index = made.network.link_index
    west = index["W0>0,0"], index["0,0>E0"]
    north = index["N0>0,0"], index["0,0>S0"]
    depart_s = [0] * standing_veh + list(range(arrival_gap_s, 400, arrival_gap_s))
    routes = [west] * len(depart_s) + [north]
    order = np.argsort([*depart_s, 1], kind="stable")
    links = np.array(routes, np.int32)[order].ravel()
    departures = np.array([*depart_s, 1], np.int32)[order]
    vehicles = Vehicles(departures, np.arange(0, links.size + 1, 2, dtype=np.int32), links)
    simulator, controller = QueueSimulator(made), actuated(made.network, made.timing, **options)
    seen = simulator.reset(vehicles)
    while seen.phase[0] in (-1, EW_F):
        seen = simulator.advance(controller.decide(seen, None))
    return seen.time_s - decision_s


@pytest.mark.parametrize(("gap_s", "standing_veh"), [(2, 20), (3, 20), (4, 30), (5, 8)])
def test_green_lasts_until_the_queue_of_even_arrivals_is_served(gap_s, standing_veh):
    # D/D/1: n + t / gap = t. With decisions every second the green ends when the queue is empty.
    empty_s = standing_veh / (1 - 1 / gap_s)
    green_s = first_green_s(1, gap_s, standing_veh, extend_veh=1, max_green_s=1000)
    assert abs(green_s - empty_s) <= 2
    # With coarser ones it ends at the first decision that finds nobody.
    coarse_s = first_green_s(10, gap_s, standing_veh, extend_veh=1, max_green_s=1000)
    assert coarse_s % 10 == 0
    assert green_s <= coarse_s < empty_s + 20


@pytest.mark.parametrize("max_green_s", [10, 15, 30])
def test_a_long_queue_gets_the_maximum_in_whole_intervals(max_green_s):
    assert first_green_s(5, 2, 100, max_green_s=max_green_s) == max_green_s
