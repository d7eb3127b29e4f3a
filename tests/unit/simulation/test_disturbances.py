"""Sensors that fail or err, and lanes that are closed."""

import numpy as np
import pytest

from dmil.controllers import make_controller
from dmil.demand import PoissonDemand
from dmil.errors import InputError
from dmil.rewards import make_reward
from dmil.scenarios import scenario
from dmil.seeding import stream
from dmil.simulation import ClosedLane, DisturbedSimulator, QueueSimulator, Sensors
from dmil.testing import check_simulator
from dmil.training import evaluate

MADE = scenario("grid:1x2", horizon_s=900, load=3)
VEHICLES = MADE.demand.vehicles(MADE.network, MADE.horizon_s, stream(0, "demand"))
LANE = "W0>0,0", 1


def drive(simulator, seed=0, vehicles=VEHICLES):
    """Run with phases in turn; return what is seen at every decision."""
    seen = [simulator.reset(vehicles, seed)]
    phases = np.zeros(len(MADE.network.intersections), np.int32)
    while seen[-1].time_s < simulator.horizon_s:
        phases[:] = len(seen) // 3 % 4
        seen.append(simulator.advance(phases))
    return seen


def same(one, other):
    return all(
        np.array_equal(getattr(a, name), getattr(b, name))
        for a, b in zip(one, other, strict=True)
        for name in ("queue_veh", "approaching_veh", "waiting_veh")
    )


def test_without_disturbances_nothing_changes():
    assert same(drive(DisturbedSimulator(QueueSimulator(MADE))), drive(QueueSimulator(MADE)))


def test_a_disturbed_simulator_is_a_simulator():
    sensors = Sensors(dead_share=0.2, missed_share=0.1, false_veh=0.1)
    closed = [ClosedLane(*LANE, 100, 300)]
    # What sensors err about is not checked here: counts have to be the vehicles that are there.
    check_simulator(lambda: DisturbedSimulator(QueueSimulator(scenario("grid:1x1")), closed=[]))
    made = DisturbedSimulator(QueueSimulator(MADE), sensors=sensors, closed=closed)
    assert (made.scenario, made.network) == (MADE, MADE.network)
    assert (made.horizon_s, made.decision_interval_s) == (900, 10)
    run = evaluate(made, make_controller("factored"), VEHICLES, make_reward("queue"), 0)
    assert run.measures.spawned_veh == len(VEHICLES)


def test_one_seed_errs_alike_and_another_otherwise():
    sensors = Sensors(dead_share=0.25, missed_share=0.3, false_veh=0.5)
    runs = [
        drive(DisturbedSimulator(QueueSimulator(MADE), sensors=sensors), seed) for seed in (1, 1, 2)
    ]
    assert same(runs[0], runs[1])
    assert not same(runs[0], runs[2])


def test_a_dead_detector_reads_0_and_the_others_the_truth():
    simulator = DisturbedSimulator(QueueSimulator(MADE), sensors=Sensors(dead_share=0.25))
    found, true = drive(simulator, 3), drive(QueueSimulator(MADE))
    dead = simulator.dead
    assert dead.sum() == round(0.25 * sum(len(i.movements) for i in MADE.network.intersections))
    assert sum(each.queue_veh[dead].sum() for each in true) > 0
    for seen, truth in zip(found, true, strict=True):
        for name in ("queue_veh", "approaching_veh", "waiting_veh"):
            assert not getattr(seen, name)[dead].any()
            assert np.array_equal(getattr(seen, name)[~dead], getattr(truth, name)[~dead])


def test_a_larger_share_of_dead_detectors_includes_a_smaller_one():
    dead = []
    for share in (0.1, 0.5, 1.0):
        simulator = DisturbedSimulator(QueueSimulator(MADE), sensors=Sensors(dead_share=share))
        simulator.reset(VEHICLES, 5)
        dead.append(simulator.dead)
    assert (dead[0] <= dead[1]).all() and (dead[1] <= dead[2]).all()
    assert dead[0].sum() < dead[1].sum() < dead[2].sum()


def test_counts_miss_and_add_in_the_mean_what_was_said():
    sensors = Sensors(missed_share=0.2, false_veh=0.5)
    true = drive(QueueSimulator(MADE))
    found = [
        drive(DisturbedSimulator(QueueSimulator(MADE), sensors=sensors), seed) for seed in range(20)
    ]
    real = np.array([each.queue_veh for each in true], float)
    noisy = np.array([[each.queue_veh for each in run] for run in found], float)
    assert noisy.mean() == pytest.approx(0.8 * real.mean() + 0.5, rel=0.02)
    # No vehicle is seen twice: where nobody errs upwards, counts are at most the truth.
    thinned = drive(DisturbedSimulator(QueueSimulator(MADE), sensors=Sensors(missed_share=0.2)))
    assert all((a.queue_veh <= b.queue_veh).all() for a, b in zip(thinned, true, strict=True))
    waiting = np.array([each.waiting_veh for each in found[0]])
    assert np.allclose(waiting, 0.8 * np.array([each.waiting_veh for each in true]) + 0.5)


def test_measures_stay_the_truth():
    noisy, plain = QueueSimulator(MADE), QueueSimulator(MADE)
    disturbed = DisturbedSimulator(noisy, sensors=Sensors(dead_share=1.0, false_veh=3.0))
    drive(disturbed)
    drive(plain)
    assert disturbed.measures().wait_veh_s == plain.measures().wait_veh_s
    assert np.array_equal(disturbed.passed_veh(), plain.passed_veh())


def discharge(simulator, until_s):
    """Let everybody through the first intersection who comes from the west."""
    vehicles = PoissonDemand({"W": 14.0}).vehicles(MADE.network, 900, stream(1, "demand"))
    seen = drive(simulator, vehicles=vehicles)
    return [each for each in seen if each.time_s <= until_s]


def test_a_closed_lane_discharges_nobody_and_the_others_as_before():
    closed = ClosedLane(*LANE, 100, 500)
    plain = discharge(QueueSimulator(MADE), 500)
    shut = discharge(DisturbedSimulator(QueueSimulator(MADE), closed=[closed]), 500)
    item = MADE.network.intersections[0]
    here = [
        j for j, m in enumerate(item.movements) if m.from_link == LANE[0] and LANE[1] in m.lanes
    ]
    assert len(here) == 1
    column = [each.queue_veh[0, here[0]] for each in shut if each.time_s >= 100]
    assert (np.diff(column) >= 0).all() and column[-1] > 20
    assert max(each.queue_veh[0, here[0]] for each in plain) < column[-1]
    others = [j for j in range(len(item.movements)) if j != here[0]]
    for one, other in zip(shut, plain, strict=True):
        assert np.array_equal(one.queue_veh[0, others], other.queue_veh[0, others])


def test_it_opens_again():
    closed = ClosedLane(*LANE, 100, 300)
    seen = discharge(DisturbedSimulator(QueueSimulator(MADE), closed=[closed]), 900)
    item = MADE.network.intersections[0]
    (here,) = [
        j for j, m in enumerate(item.movements) if (m.from_link, m.lanes) == ("W0>0,0", (1,))
    ]
    course = {each.time_s: each.queue_veh[0, here] for each in seen}
    assert course[300] > 2 * course[100] + 10
    assert course[600] < course[300] / 2


def test_bad_input_is_one_clear_error():
    simulator = QueueSimulator(MADE)
    with pytest.raises(InputError, match="an end after"):
        ClosedLane("W0>0,0", 0, 300, 300)
    with pytest.raises(InputError, match="dead_share"):
        Sensors(dead_share=1.5)
    with pytest.raises(InputError, match="no lane 7 before an intersection"):
        DisturbedSimulator(simulator, closed=[ClosedLane("W0>0,0", 7, 0, 10)]).reset(VEHICLES)
    with pytest.raises(InputError, match="expected a link that ends"):
        DisturbedSimulator(simulator, closed=[ClosedLane("0,0>W0", 0, 0, 10)]).reset(VEHICLES)
    unable = DisturbedSimulator(simulator)  # itself a simulator, but one that closes no lanes
    with pytest.raises(InputError, match="cannot close a lane"):
        DisturbedSimulator(unable, closed=[ClosedLane("W0>0,0", 0, 0, 10)])
