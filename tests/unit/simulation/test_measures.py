import math
from dataclasses import replace

import numpy as np
import pytest

from dmil.demand import Vehicles
from dmil.network import grid
from dmil.scenarios import scenario
from dmil.simulation import Measures, QueueSimulator

MEASURES = Measures(
    time_s=300,
    spawned_veh=40,
    arrived_veh=20,
    wait_veh_s=600,
    visits=50,
    arrived_wait_veh_s=90,
    travel_veh_s=2000,
    time_loss_veh_s=700,
    departure_delay_veh_s=100,
    stops=60,
    overruled=0,
    arrived_at=np.zeros(300, np.int32),
    queued_at=np.zeros(300, np.int32),
)


@pytest.mark.parametrize(
    ("metric", "value"),
    [
        ("wait_per_spawned_s", 15.0),
        ("w_over_vc", 0.75),
        ("wait_per_visit_s", 12.0),
        ("wait_per_arrived_s", 4.5),
        ("mean_queue_veh", 2.0),
        ("travel_time_s", 50.0),
        ("throughput_veh_per_h", 240.0),
        ("delay_s", 20.0),
        ("stops_per_spawned", 1.5),
    ],
)
def test_metrics_by_hand(metric, value):
    assert getattr(MEASURES, metric) == value


@pytest.mark.parametrize(
    ("field", "metric"),
    [
        ("spawned_veh", "wait_per_spawned_s"),
        ("spawned_veh", "travel_time_s"),
        ("arrived_veh", "w_over_vc"),
        ("arrived_veh", "wait_per_arrived_s"),
        ("visits", "wait_per_visit_s"),
        ("time_s", "mean_queue_veh"),
    ],
)
def test_a_mean_over_nothing_is_not_a_number(field, metric):
    assert math.isnan(getattr(replace(MEASURES, **{field: 0}), metric))


def test_a_run_by_hand():
    # Three vehicles straight on from the East: at 2 s, 2 s and 17 s; red until 10 s.
    made = scenario("grid:1x1", horizon_s=20)
    network = grid(1, 1)
    route = [network.link_index["E0>0,0"], network.link_index["0,0>W0"]]
    vehicles = Vehicles(
        np.array([2, 2, 17], np.int32),
        np.array([0, 2, 4, 6], np.int32),
        np.array(route * 3, np.int32),
    )
    simulator = QueueSimulator(made)
    simulator.reset(vehicles)
    simulator.advance(np.array([2]))
    halfway = simulator.measures()
    assert (halfway.time_s, halfway.spawned_veh, halfway.arrived_veh) == (10, 2, 0)
    assert halfway.wait_veh_s == halfway.travel_veh_s == 16
    simulator.advance(np.array([0]))
    end = simulator.measures()
    # They leave at 10, 11 and 17: waits of 8, 9 and 0.
    assert (end.time_s, end.spawned_veh, end.arrived_veh, end.visits) == (20, 3, 3, 3)
    assert end.wait_veh_s == end.arrived_wait_veh_s == end.travel_veh_s == 17
    assert end.arrived_at.tolist() == [0] * 10 + [1] + [2] * 6 + [3] * 3
    assert end.queued_at.tolist() == [0] * 2 + [2] * 8 + [1] + [0] * 9
    # The third one went through without a halt; everything was waited inside the network.
    assert (halfway.stops, end.stops) == (2, 2)
    assert (end.time_loss_veh_s, end.departure_delay_veh_s) == (17, 0)
    assert halfway.queued_at.tolist() == [0] * 2 + [2] * 8
