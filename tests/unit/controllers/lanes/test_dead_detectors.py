"""Detectors that die in a run: what they would count is filled in from memory."""

import numpy as np
import pytest

from dmil.controllers import RunContext, make_controller
from dmil.controllers.lanes.lane_arrivals import DEAD, LEAST_SILENCE
from dmil.network import grid
from dmil.rewards import make_reward
from dmil.scenarios import SignalTiming, scenario
from dmil.seeding import stream
from dmil.simulation import DisturbedSimulator, Observation, QueueSimulator, Sensors
from dmil.training import evaluate, vehicles_of_seed

ALONG, ACROSS = 1, 4
"""Movements of one intersection of a grid that go straight on, from East and North."""


def seen(queue_veh, phase, time_s):
    none = np.zeros_like(queue_veh)
    return Observation(queue_veh, none, phase, none[:, 0], time_s, queue_veh.astype(float))


def drive(controller, decisions, across_until):
    """Let two vehicles come along the road all the time, one across it while its detector lives.

    A queue grows at red and is gone after green. Returns the phases shown.
    """
    network, timing = grid(1, 1), SignalTiming()
    controller.reset(RunContext(network, timing, stream(0)))
    phases, phase = [], np.zeros(1, np.int32)
    queue_veh = np.zeros((1, 12), np.int32)
    for k in range(decisions):
        served = network.intersections[0].phases[phase[0]]
        for movement, joined in ((ALONG, 2), (ACROSS, 1)):
            queue_veh[0, movement] = 0 if movement in served else queue_veh[0, movement] + joined
        if k >= across_until:
            queue_veh[0, ACROSS] = 0
        phase = controller.decide(seen(queue_veh.copy(), phase.copy(), 10 * k), None)
        phases.append(ACROSS in network.intersections[0].phases[phase[0]])
    return phases


@pytest.mark.parametrize("name", ["factored", "lookahead", "combined"])
def test_a_lane_whose_detector_died_still_gets_green(name):
    alive, died = 100, 300
    for recall in (False, True):
        controller = make_controller(name, {"recall": recall})
        green = drive(controller, died, alive)
        assert any(green[:alive])
        # Long after it was noticed.
        assert any(green[alive + 60 :]) == recall
    assert np.count_nonzero(controller._short.silent == DEAD) == 1


def test_a_detector_that_never_saw_anybody_is_left_alone():
    controller = make_controller("combined")
    green = drive(controller, 300, 0)
    assert not any(green)
    assert not controller._short.silent.any()


def test_a_false_alarm_makes_it_wait_longer_the_next_time():
    controller = make_controller("combined")
    drive(controller, 40 + LEAST_SILENCE * 3, 40)
    short = controller._short
    (lane,) = np.flatnonzero(short.silent == DEAD)
    longest = int(short.longest[lane])
    queue_veh = np.zeros((1, 12), np.int32)
    queue_veh[0, ACROSS] = 3
    controller.decide(seen(queue_veh, np.zeros(1, np.int32), 5000), None)
    assert short.silent[lane] == 0
    assert short.longest[lane] == 3 * longest


def test_a_network_with_dying_detectors_flows_on():
    made = scenario("grid:3x3", load=2, horizon_s=3600)
    dying = Sensors(dead_share=0.1, dead_from_s=900)
    waits = {}
    for recall in (False, True):
        simulator = DisturbedSimulator(QueueSimulator(made), sensors=dying)
        controller = make_controller("combined", {"recall": recall})
        vehicles = vehicles_of_seed(made, 1)
        found = evaluate(simulator, controller, vehicles, make_reward("queue"), 1)
        waits[recall] = found.measures.wait_per_spawned_s
    assert waits[True] < 0.6 * waits[False]
