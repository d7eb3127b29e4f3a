"""What is measured in a run of SUMO."""

import importlib.util
from dataclasses import replace

import numpy as np
import pytest

from dmil.demand import Vehicles
from dmil.errors import InputError
from dmil.scenarios import scenario
from dmil.simulation.sumo.survey import Survey
from dmil.training.agreement import CALIBRATED, JUDGE, PLAIN, agreement
from dmil.training.calibration import Passages, calibrate, discharge, link_times

with_sumo = pytest.mark.skipif(
    importlib.util.find_spec("libsumo") is None or importlib.util.find_spec("sumo_rl") is None,
    reason="needs the extra sumo",
)
GREEN_FROM_S, HEADWAYS_S = 50, (3.0, 2.5, 2.0, 2.0, 2.0, 2.0)


def straight_ahead(depart_s, crossed_s):
    """Vehicles of a grid's only intersection, all on one way with red before GREEN_FROM_S."""
    made = scenario("grid:1x1", horizon_s=100)
    network = made.network
    j = next(j for j, m in enumerate(network.intersections[0].movements) if m.turn == "straight")
    movement = network.intersections[0].movements[j]
    links = [network.link_index[movement.from_link], network.link_index[movement.to_link]]
    count = len(depart_s)
    vehicles = Vehicles(
        depart_s=np.array(depart_s, np.int32),
        route_offset=np.arange(0, 2 * count + 1, 2, dtype=np.int32),
        route_links=np.array(links * count, np.int32),
    )
    crossed = np.full(2 * count, np.nan)
    crossed[::2] = crossed_s
    left = crossed.copy()
    left[1::2] = crossed[::2] + 30
    lane = np.where(np.isnan(crossed), -1, 0)
    green = np.zeros((100, 1, len(network.intersections[0].movements)), np.bool_)
    green[GREEN_FROM_S:, 0, j] = True
    survey = Survey(np.array(depart_s, np.float64), left, crossed, lane, green)
    return Passages(made, vehicles, survey), links


def queue():
    crossed = GREEN_FROM_S + 0.5 + np.concatenate([[0.0], np.cumsum(HEADWAYS_S)])
    return straight_ahead(list(range(len(crossed))), crossed)[0]


def test_a_queue_tells_headway_and_lost_time():
    headway_s, lost_s, count = discharge(queue())
    # With fewer headways than are asked for, all count: the mean of the six.
    assert headway_s == pytest.approx(np.mean(HEADWAYS_S))
    assert lost_s == pytest.approx(0.5)
    assert count == 6


def test_with_enough_headways_those_of_the_first_vehicles_do_not_count(monkeypatch):
    monkeypatch.setattr("dmil.training.calibration.FEWEST", 3)
    headway_s, lost_s, _ = discharge(queue())
    assert headway_s == pytest.approx(2.0)
    # The fifth vehicle crosses 10 s after green, as if all four headways before it were of 2 s.
    assert lost_s == pytest.approx(10.0 - 4 * 2.0)


def test_without_a_queue_there_is_nothing_to_measure():
    passages, _ = straight_ahead([60], [60.0])
    with pytest.raises(InputError, match="no queue discharged"):
        discharge(passages)


def test_links_take_what_undisturbed_vehicles_need():
    # Three meet green and nobody, one stood at red.
    flow_s = scenario("grid:1x1").network.free_flow_time_s
    passages, (first, last) = straight_ahead([20, 40, 50, 60], [50.4, 70.0, 80.0, 90.0])
    time_s, _ = link_times(passages)
    assert time_s[first] == pytest.approx(30.0)
    # What nobody drives on undisturbed gets what the others need beyond free flow.
    unknown = np.setdiff1d(np.arange(time_s.size), [first, last])
    np.testing.assert_allclose(time_s[unknown], flow_s[unknown] + 30.0 - flow_s[first])


@with_sumo
def test_a_run_of_sumo_is_measured_and_brings_the_simulators_together():
    made = scenario("resco/cologne1", horizon_s=900)
    found = calibrate(made, 1000)
    assert (found.scenario, found.controller, found.seed) == ("resco/cologne1", "program", 1000)
    # Drivers of SUMO's default model: a headway of two seconds, about three are lost.
    assert 0.4 < found.saturation_flow_veh_per_s < 0.65
    assert 1 <= found.startup_lost_s <= 4
    flow_s = made.network.free_flow_time_s
    assert flow_s.mean() < np.mean(found.link_free_s) < np.mean(found.link_time_s)
    assert calibrate(made, 1000) == found
    compared = agreement(made, found, ["program", "max-pressure"], range(1))
    for each in compared:
        judged = each.travel_time_s[JUDGE]
        before, after = (abs(each.travel_time_s[name] - judged) for name in (PLAIN, CALIBRATED))
        assert after < before


@with_sumo
def test_without_programs_max_pressure_drives():
    made = scenario("grid:2x2", horizon_s=300, load=3.0)
    timing = made.timing.model_copy(update={"clearance_s": 3})
    found = calibrate(replace(made, timing=timing), 1000)
    assert found.controller == "max-pressure"
    assert found.headways > 10
    assert found.applied_to(made).link_time_s == found.link_time_s
