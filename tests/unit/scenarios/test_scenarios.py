"""Scenarios by name, and the settings of a scenario."""

import math
import pickle
import re

import numpy as np
import pytest

from dmil.demand import FileDemand, PoissonDemand
from dmil.errors import DmilError, InputError, NetworkError, UnknownNameError
from dmil.network import grid
from dmil.scenarios import QueueDynamics, Scenario, SignalTiming, scenario, scenario_names
from dmil.seeding import stream


def test_a_grid_has_the_papers_setting():
    made = scenario("grid:5x5")
    assert made == Scenario(
        "grid:5x5", grid(5, 5), PoissonDemand(), SignalTiming(), QueueDynamics(), 300
    )
    assert made.timing.model_dump() == {
        "decision_interval_s": 10,
        "clearance_s": 0,
        "all_red_s": 0,
        "clearance_kind": "kept",
        "min_green_s": 0,
        "max_green_s": 0,
        "startup_lost_s": 0,
    }
    assert made.dynamics.model_dump() == {
        "saturation_flow_veh_per_s": 1.0,
        "storage": False,
        "vehicle_space_m": 7.5,
        "gap_wait_s": 20,
        "start_wave_veh_per_s": 0.0,
    }


def test_names_that_name_a_grid_work():
    grids = [name for name in scenario_names() if re.fullmatch(r"grid:[0-9x]+", name)]
    assert len(grids) == 3
    for name in grids:
        assert scenario(name).name == name
    assert len(scenario("grid:2x7").network.intersections) == 14
    assert all(line and "\n" not in line for line in scenario_names().values())


def test_a_grid_may_have_another_demand_than_the_papers():
    unequal = scenario("grid:3x3/unequal", horizon_s=3600)
    paper = scenario("grid:3x3", horizon_s=3600)
    assert unequal.network == paper.network
    found = [
        made.demand.vehicles(made.network, 3600, stream(0, "unequal")) for made in (unequal, paper)
    ]
    assert len(found[0]) == pytest.approx(len(found[1]), rel=0.1)  # as many, elsewhere
    varying = scenario("grid:3x3/time-varying", horizon_s=3600, load=2.0).demand
    assert varying.at(np.array([0, 900, 1800, 2700, 3600])).tolist() == [0.5, 1.25, 2, 1.25, 0.5]
    assert varying.base == PoissonDemand().scaled(2.0)
    with pytest.raises(UnknownNameError, match=r"'unequl'.*Did you mean 'unequal'"):
        scenario("grid:3x3/unequl")
    with pytest.raises(UnknownNameError):
        scenario("grid:3x3/")


def test_options_override():
    timing = SignalTiming(decision_interval_s=5, min_green_s=5)
    dynamics = QueueDynamics(storage=True)
    made = scenario("grid:1x2", horizon_s=3600, load=2.0, timing=timing, dynamics=dynamics)
    assert (made.horizon_s, made.timing, made.dynamics) == (3600, timing, dynamics)
    assert made.demand == PoissonDemand().scaled(2.0)
    demand = PoissonDemand({"E": 1.0})
    assert scenario("grid:1x2", demand=demand).demand is demand


def test_a_scenario_survives_the_way_to_another_process():
    made = scenario("grid:2x2")
    made.demand.vehicles(made.network, 10, stream(0))
    copy = pickle.loads(pickle.dumps(made))
    assert copy == made
    ours = made.demand.vehicles(made.network, 100, stream(0))
    theirs = copy.demand.vehicles(copy.network, 100, stream(0))
    assert ours.route_links.tobytes() == theirs.route_links.tobytes()


@pytest.mark.parametrize("name", ["gird:5x5", "paper", "", "cityflow:", "cityflow"])
def test_an_unknown_name_is_refused_with_those_that_exist(name):
    with pytest.raises(UnknownNameError, match="expected one of cityflow:FOLDER"):
        scenario(name)


@pytest.mark.parametrize("name", ["grid:5", "grid:axb", "grid:5x5x5", "grid:-1x2", "grid:"])
def test_a_grid_without_a_size_is_refused(name):
    with pytest.raises(InputError, match=r"not the name of a grid.*Write for example grid:5x5"):
        scenario(name)


def test_a_grid_without_intersections_is_refused():
    with pytest.raises(NetworkError, match="rows is 0"):
        scenario("grid:0x3")


@pytest.mark.parametrize("horizon_s", [0, -1, 9, 12.5, True])
def test_a_horizon_must_hold_a_decision(horizon_s):
    with pytest.raises(InputError, match=r"horizon is .*at least one decision interval \(10 s\)"):
        scenario("grid:1x1", horizon_s=horizon_s)


@pytest.mark.parametrize("load", [-1.0, math.nan])
def test_a_load_must_be_a_number_of_0_or_more(load):
    with pytest.raises(DmilError, match="load: the load is"):
        scenario("grid:1x1", load=load)


def test_a_demand_of_ones_own_that_cannot_be_scaled_is_refused_with_a_load():
    class Nobody:
        def vehicles(self, network, horizon_s, rng):
            return FileDemand.from_routes(network, [], []).vehicles(network, horizon_s, rng)

    assert scenario("grid:1x1", demand=Nobody()).horizon_s == 300
    with pytest.raises(InputError, match="a Nobody cannot be scaled"):
        scenario("grid:1x1", demand=Nobody(), load=2.0)


@pytest.mark.parametrize(
    ("kind", "values", "message"),
    [
        (
            SignalTiming,
            {"decision_interval_s": 0},
            "SignalTiming.decision_interval_s: .*but it is 0",
        ),
        (SignalTiming, {"decision_interval_s": 2.5}, "decision_interval_s: .*integer"),
        (SignalTiming, {"clearance_s": -1}, "clearance_s: .*greater than or equal to 0"),
        (SignalTiming, {"clearance_s": 10}, r"clearance_s \(10\) must be less than decision_in"),
        (SignalTiming, {"min_green_s": -1}, "min_green_s: .*greater than or equal to 0"),
        (SignalTiming, {"startup_lost_s": math.nan}, "startup_lost_s: .*finite"),
        (
            SignalTiming,
            {"yellow_s": 3},
            r"yellow_s: there is no such field.*has the fields decision",
        ),
        (QueueDynamics, {"saturation_flow_veh_per_s": 0}, "greater than 0"),
        (QueueDynamics, {"saturation_flow_veh_per_s": math.inf}, "finite number"),
        (QueueDynamics, {"vehicle_space_m": -7.5}, "vehicle_space_m: .*greater than 0"),
        (QueueDynamics, {"vehicle_space_m": math.nan}, "vehicle_space_m: .*finite number"),
        (QueueDynamics, {"storage": "perhaps"}, "storage: .*'perhaps'"),
    ],
)
def test_a_wrong_setting_is_named(kind, values, message):
    with pytest.raises(InputError, match=message):
        kind(**values)
    with pytest.raises(InputError, match=message):
        kind.model_validate(values)


def test_settings_cannot_be_changed():
    with pytest.raises(ValueError, match="frozen"):
        SignalTiming().clearance_s = 3


@pytest.mark.parametrize("kind", [SignalTiming, QueueDynamics])
def test_every_setting_is_described(kind):
    assert all(field.description for field in kind.model_fields.values())
