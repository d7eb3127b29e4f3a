"""Both memories of lanes: who yields, who has waited for long, what is kept."""

from dataclasses import replace

import numpy as np
import pytest

from dmil.controllers import RunContext, make_controller
from dmil.errors import PolicyError
from dmil.network import grid
from dmil.rewards import make_reward
from dmil.scenarios import QueueDynamics, SignalTiming, scenario
from dmil.seeding import stream
from dmil.simulation import Observation, QueueSimulator
from dmil.training import evaluate, vehicles_of_seed

STRAIGHT, LEFT, ONCOMING, SIDE = 1, 2, 7, 4
"""Movements at the intersection of a grid, from East, East, West and North."""
NAMES = ("factored", "lookahead", "combined")


def one_intersection(*phases, gives_way=()):
    network = grid(1, 1)
    node = replace(
        network.intersections[0],
        phases=tuple(map(frozenset, phases)),
        phase_names=(),
        gives_way=tuple(tuple(gives_way) if j == LEFT else () for j in range(12)),
    )
    return replace(network, intersections=(node,))


def begun(name, network, timing=None, **options):
    controller = make_controller(name, {"learning": False, **options})
    dynamics = QueueDynamics(saturation_flow_veh_per_s=0.5)
    timing = timing or SignalTiming(clearance_s=3)
    controller.reset(RunContext(network, timing, stream(0), dynamics=dynamics))
    return controller


def seen(queues, phase=0, time_s=0):
    """What is seen of one intersection; ``queues`` maps movements to vehicles queued."""
    queue_veh = np.zeros((1, 12), np.int32)
    for movement, vehicles in queues.items():
        queue_veh[0, movement] = vehicles
    shown = np.array([phase], np.int32)
    none = np.zeros_like(queue_veh)
    return Observation(queue_veh, none, shown, shown, time_s, queue_veh.astype(float))


@pytest.mark.parametrize("name", NAMES)
def test_a_turn_that_finds_no_gap_gets_a_phase_of_its_own(name):
    network = one_intersection({STRAIGHT, LEFT, ONCOMING}, {LEFT}, gives_way=(ONCOMING,))
    busy = seen({LEFT: 12, ONCOMING: 6}, phase=-1)
    assert begun(name, network, yields=True).decide(busy, None) == [1]
    assert begun(name, network, yields=False).decide(busy, None) == [0]
    free = seen({LEFT: 12, ONCOMING: 0, STRAIGHT: 1}, phase=-1)
    assert begun(name, network, yields=True).decide(free, None) == [0]


@pytest.mark.parametrize("name", NAMES)
def test_one_vehicle_beside_a_busy_road_gets_its_turn(name):
    network, turns = one_intersection({STRAIGHT}, {SIDE}), {}
    for age in (0.0, 0.025):
        controller = begun(name, network, age=age, expected=0.0)
        chosen = [
            int(controller.decide(seen({STRAIGHT: 2, SIDE: 1}, time_s=10 * k), None)[0])
            for k in range(40)
        ]
        turns[age] = sum(chosen)
    assert turns[0.0] == 0
    assert turns[0.025] > 0


@pytest.mark.parametrize("name", NAMES)
def test_if_all_must_stop_a_phase_that_shares_lanes_is_no_cheaper(name):
    # Who stays has the whole interval, who changes half of it.
    network = one_intersection({STRAIGHT}, {STRAIGHT, LEFT})
    queues = seen({STRAIGHT: 6, LEFT: 2})
    for kind, best in (("kept", 1), ("all-stop", 0)):
        timing = SignalTiming(clearance_s=5, clearance_kind=kind)
        assert begun(name, network, timing).decide(queues, None) == [best], kind


def test_memory_is_small_and_all_of_it_is_kept():
    made = scenario("grid:5x5", horizon_s=600)
    controller = make_controller("combined")
    simulator, reward = QueueSimulator(made), make_reward("queue")
    evaluate(simulator, controller, vehicles_of_seed(made, 0), reward, 0)
    use, arrays = controller.memory_use(), controller.arrays()
    assert set(arrays) == {"residual", "times", "model_residual", "model_times"}
    groups, movements = 8 * 25, 12 * 25
    short = (17 + 4) * groups + 4 * movements + 4 * 25
    assert use.bytes_total == sum(array.nbytes for array in arrays.values()) + short
    assert use.bytes_total < 10_000
    learned = np.count_nonzero(arrays["times"]) + np.count_nonzero(arrays["model_times"])
    assert use.long_term_entries == learned > 100
    other = make_controller("combined")
    other.reset(RunContext(made.network, made.timing, stream(0)))
    other.restore(arrays)
    for name, array in other.arrays().items():
        np.testing.assert_array_equal(array, arrays[name])
    with pytest.raises(PolicyError, match="model_times"):
        other.restore({name: arrays[name] for name in arrays if name != "model_times"})
