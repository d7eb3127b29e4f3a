"""Scenarios from CityFlow's files."""

import numpy as np
import pytest

from dmil.errors import InputError, UnknownNameError
from dmil.scenarios import (
    PLAN,
    QueueDynamics,
    SignalTiming,
    cityflow_scenario,
    scenario,
    signal_times,
)
from dmil.seeding import stream


def vehicles_at(*seconds):
    return [
        {"route": ["E_in", "W_out"], "interval": 1, "startTime": second, "endTime": second}
        for second in seconds
    ]


@pytest.fixture
def roadnet(crossing, write):
    return write(crossing()[0], "roadnet_1_1.json")


def clearances_s(made):
    """All clearances between two phases of a scenario whose intersections are alike."""
    clearance_s = signal_times(made.timing, made.network).clearance_s
    return set(clearance_s[:, ~np.eye(clearance_s.shape[1], dtype=bool)].ravel().tolist())


def test_the_defaults_are_those_of_recorded_networks(roadnet, write):
    made = cityflow_scenario(roadnet, write(vehicles_at(3, 700), "city.json"))
    assert made.name == "cityflow:city"
    assert made.timing == SignalTiming(decision_interval_s=15, **PLAN)
    assert clearances_s(made) == {3}
    assert made.dynamics == QueueDynamics(saturation_flow_veh_per_s=0.5, storage=True)
    assert made.horizon_s == 1200
    assert len(made.demand.vehicles(made.network, made.horizon_s, stream(0))) == 2


@pytest.mark.parametrize(
    ("last", "horizon_s"), [(0, 600), (599, 600), (600, 1200), (3597, 3600), (None, 600)]
)
def test_the_horizon_is_the_last_departure_rounded_up(roadnet, write, last, horizon_s):
    flow = write(vehicles_at(*[] if last is None else [last]), "city.json")
    assert cityflow_scenario(roadnet, flow).horizon_s == horizon_s


def test_a_clearance_phase_with_parts_of_a_second_is_rounded_up(crossing, write):
    document, _ = crossing()
    document["intersections"][0]["trafficLight"]["lightphases"][0]["time"] = 2.5
    made = cityflow_scenario(write(document), write(vehicles_at(0), "city.json"))
    assert clearances_s(made) == {3}


def test_options_override_the_defaults(roadnet, write):
    flow = write(vehicles_at(0, 50), "city.json")
    timing, dynamics = SignalTiming(decision_interval_s=20), QueueDynamics()
    made = cityflow_scenario(
        roadnet, flow, horizon_s=40, timing=timing, dynamics=dynamics, name="mine"
    )
    assert (made.name, made.timing, made.dynamics) == ("mine", timing, dynamics)
    vehicles = made.demand.vehicles(made.network, made.horizon_s, stream(0))
    assert (len(vehicles), vehicles.dropped) == (1, 1)
    assert cityflow_scenario(roadnet, flow, decision_interval_s=5).timing.decision_interval_s == 5


def test_a_folder_with_one_flow_file_is_enough(roadnet, write, tmp_path):
    write(vehicles_at(0), "city.json")
    write({"interval": 1.0, "roadnetFile": "roadnet_1_1.json"}, "config.json")
    made = scenario(f"cityflow:{tmp_path}")
    assert made.name == f"cityflow:{tmp_path}"
    assert made.network.name == "roadnet_1_1"


def test_of_variants_the_one_whose_name_the_others_continue_is_meant(roadnet, write, tmp_path):
    for count, name in enumerate(["city_2000", "city", "city_2500"], start=1):
        write(vehicles_at(*range(count)), f"{name}.json")
    assert len(scenario(f"cityflow:{tmp_path}").demand.recorded) == 2
    chosen = scenario(f"cityflow:{tmp_path}#city_2500.json")
    assert len(chosen.demand.recorded) == 3


def test_several_flow_files_are_listed_and_not_guessed(roadnet, write, tmp_path):
    write(vehicles_at(0), "east.json")
    write(vehicles_at(0), "west.json")
    message = "there are 2 flow files: east.json, west.json.*Choose one, such as cityflow:.*#east"
    with pytest.raises(InputError, match=message):
        scenario(f"cityflow:{tmp_path}")


def test_a_folder_with_a_number_sign_in_its_name(crossing, write, tmp_path):
    folder = tmp_path / "run#3"
    folder.mkdir()
    write(crossing()[0], "run#3/roadnet.json")
    write(vehicles_at(0), "run#3/a.json")
    write(vehicles_at(0, 1), "run#3/b.json")
    assert len(scenario(f"cityflow:{folder}#b.json").demand.recorded) == 2
    (folder / "b.json").unlink()
    assert len(scenario(f"cityflow:{folder}").demand.recorded) == 1


def test_a_flow_file_that_is_not_there_is_named_with_the_nearest(roadnet, write, tmp_path):
    write(vehicles_at(0), "city.json")
    with pytest.raises(UnknownNameError, match=r"no flow file named 'cty\.json'.*'city\.json'\?"):
        scenario(f"cityflow:{tmp_path}#cty.json")


def test_folders_that_hold_no_scenario(crossing, write, tmp_path):
    with pytest.raises(InputError, match="there is no such folder"):
        scenario(f"cityflow:{tmp_path / 'none'}")
    with pytest.raises(InputError, match="no road network; expected exactly one"):
        scenario(f"cityflow:{tmp_path}")
    write(crossing()[0], "roadnet_a.json")
    with pytest.raises(InputError, match="there is no flow file"):
        scenario(f"cityflow:{tmp_path}")
    write(crossing()[0], "roadnet_b.json")
    with pytest.raises(InputError, match=r"2 road networks: roadnet_a\.json, roadnet_b\.json"):
        scenario(f"cityflow:{tmp_path}")


def test_more_or_less_of_recorded_demand(roadnet, write, tmp_path):
    write(vehicles_at(*range(400)), "city.json")
    name = f"cityflow:{tmp_path}"

    def count(load, seed):
        made = scenario(name, load=load)
        return len(made.demand.vehicles(made.network, made.horizon_s, stream(seed)))

    assert count(1.0, 0) == 400
    assert count(2.0, 0) == 800
    assert count(0.0, 0) == 0
    assert abs(count(0.5, 0) - 200) < 5 * (400 * 0.25) ** 0.5
    assert count(0.5, 0) == count(0.5, 0)
    assert abs(count(1.25, 1) - 500) < 5 * (400 * 0.1875) ** 0.5


@pytest.mark.data
def test_recorded_scenarios_run_for_an_hour(data):
    made = scenario(f"cityflow:{data / 'jinan_3x4'}")
    assert made.horizon_s == 3600
    assert made.timing == SignalTiming(decision_interval_s=15, **PLAN)
    assert clearances_s(made) == {5}
    assert len(made.demand.vehicles(made.network, made.horizon_s, stream(0))) == 6295
    made = scenario(f"cityflow:{data / 'hangzhou_4x4'}#anon_4_4_hangzhou_real_5816.json")
    assert len(made.demand.vehicles(made.network, made.horizon_s, stream(0))) == 6984
