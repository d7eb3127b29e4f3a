"""CityFlow behind our protocol; it needs CityFlow's own module."""

from dataclasses import replace

import numpy as np
import pytest

from dmil.errors import InputError, SimulationError
from dmil.scenarios import SignalTiming, cityflow_scenario, scenario
from dmil.simulation import make_simulator
from dmil.simulation.cityflow import CityflowSimulator
from dmil.simulation.cityflow.process import has_cityflow
from dmil.simulation.timing import PROGRAM
from dmil.testing import check_simulator

pytestmark = pytest.mark.skipif(
    not has_cityflow(), reason="the module cityflow is not installed (built from its repository)"
)


@pytest.fixture
def made(crossing, write):
    flows = [
        {"route": [f"{a}_in", f"{b}_out"], "interval": 6, "startTime": k, "endTime": 150 + k}
        for k, (a, b) in enumerate((("E", "W"), ("N", "S"), ("W", "N"), ("S", "E")))
    ]
    timing = SignalTiming(decision_interval_s=10, clearance_s=3, clearance_kind="all-stop")
    files = write(crossing()[0], "roadnet.json"), write(flows, "flow.json")
    return cityflow_scenario(*files, horizon_s=205, timing=timing)


def vehicles_of(made):
    return made.demand.vehicles(made.network, made.horizon_s, np.random.default_rng(0))


@pytest.mark.parametrize("kind", ["all-stop", "kept"])
def test_it_conforms(made, kind):
    timing = made.timing.model_copy(update={"clearance_kind": kind})
    changed = replace(made, timing=timing)
    check_simulator(lambda: CityflowSimulator(changed), vehicles_of(made))


def test_the_own_program_lets_everybody_arrive(made):
    simulator = make_simulator(made, "cityflow")
    seen = simulator.reset(vehicles_of(made))
    while seen.time_s < made.horizon_s:
        seen = simulator.advance(np.array([PROGRAM]))
    measured = simulator.measures()
    assert measured.arrived_veh > measured.spawned_veh / 2
    times = simulator.intersection_times()
    # Who is still there has been seen in one second more than lie between first and last.
    assert 0 < times.entering_lanes_s <= times.last_minus_first_s + 1
    assert simulator.passed_veh()[0] >= measured.arrived_veh
    simulator.close()


def test_a_vehicle_alone_is_counted_to_the_second(made, write):
    """Its time on the entering lane is what it needs for it: nobody is in its way."""
    simulator = CityflowSimulator(made)
    seen = simulator.reset(vehicles_of(made).take(np.array([0])))
    while seen.time_s < 60:
        seen = simulator.advance(np.array([0]))  # E and W straight on
    times = simulator.intersection_times()
    lane_m, limit = 200 - 15, 10.0
    assert times.entering_lanes_s == times.last_minus_first_s
    assert lane_m / limit - 2 <= times.entering_lanes_s <= lane_m / limit + 10
    assert simulator.measures().arrived_veh == 1


def test_what_is_not_from_its_files_is_refused():
    with pytest.raises(InputError, match="not from CityFlow's files"):
        make_simulator(scenario("grid:1x1"), "cityflow")


def test_a_file_that_the_engine_refuses_is_told(made):
    broken = replace(made, cityflow=replace(made.cityflow, kinds=({"length": "long"},)))
    simulator = CityflowSimulator(broken)
    with pytest.raises(SimulationError, match="loading flow file error"):
        simulator.reset(vehicles_of(made))
