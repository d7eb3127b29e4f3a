"""What CityFlow is given: light phases, switches, vehicles; none of it needs CityFlow itself."""

import importlib.util
import json
from pathlib import Path

import numpy as np
import pytest

from dmil.errors import InputError
from dmil.network import read_cityflow_roadnet
from dmil.scenarios import SignalTiming, cityflow_scenario, scenario
from dmil.simulation import make_simulator
from dmil.simulation.cityflow import process
from dmil.simulation.cityflow.files import FLOW, find_lights, write_configuration, write_flow
from dmil.simulation.cityflow.signals import LightHeads
from dmil.simulation.timing import PROGRAM

ALL_STOP, KEPT = np.array([True]), np.array([False])


@pytest.fixture
def network(crossing, write):
    return read_cityflow_roadnet(write(crossing()[0], "roadnet.json"))


def served(document, phase):
    node = document["intersections"][0]
    links = [(each["startRoad"], each["endRoad"]) for each in node["roadLinks"]]
    available = node["trafficLight"]["lightphases"][phase]["availableRoadLinks"]
    return {links[k] for k in available}


def test_every_phase_is_found_again_in_the_file(crossing, network):
    document, _ = crossing()
    lights = find_lights(network, document, ALL_STOP)
    item = network.intersections[0]
    pairs = [(each.from_link, each.to_link) for each in item.movements]
    for phase, number in zip(item.phases, lights.phases[0], strict=True):
        assert served(document, number) == {pairs[j] for j in phase | item.unsignalled}
    assert lights.phases[0] == [1, 2, 3, 4]


def test_all_stop_shows_the_clearance_phase_of_the_file(crossing, network):
    document, _ = crossing()
    lights = find_lights(network, document, ALL_STOP)
    assert set(lights.clearances[0].values()) == {0}
    assert document == crossing()[0]


def test_kept_clearance_serves_who_has_green_before_and_after(crossing, write):
    document, links = crossing()
    phases = document["intersections"][0]["trafficLight"]["lightphases"]
    rights = set(phases[0]["availableRoadLinks"])
    east = {k for k, (arm, turn) in enumerate(links) if arm == "E"}
    phases.append({"time": 20, "availableRoadLinks": sorted(east | rights)})
    network = read_cityflow_roadnet(write(document, "roadnet.json"))
    lights = find_lights(network, document, KEPT)
    shared = served(document, lights.clearances[0][0, 4])
    assert shared == served(document, 1) & served(document, 5)
    assert ("E_in", "W_out") in shared
    assert ("W_in", "E_out") not in shared


def test_a_changed_phase_begins_with_its_clearance(crossing, network):
    lights = find_lights(network, crossing()[0], ALL_STOP)
    timing = SignalTiming(decision_interval_s=10, clearance_s=4, clearance_kind="all-stop")
    heads = LightHeads(network, timing, lights, begins=False)
    assert heads.first() == []
    assert heads.request(np.array([1], np.int32), 0) == [(0, "c", 2)]
    assert heads.request(np.array([1], np.int32), 10) == []
    assert heads.request(np.array([3], np.int32), 20) == [(0, "c", 0), (4, "c", 4)]


def test_signals_that_begin_in_the_first_phase_clear_before_another(crossing, network):
    lights = find_lights(network, crossing()[0], ALL_STOP)
    timing = SignalTiming(decision_interval_s=10, clearance_s=4, clearance_kind="all-stop")
    heads = LightHeads(network, timing, lights, begins=True)
    assert heads.first() == [(0, "c", 1)]
    assert heads.request(np.array([1], np.int32), 0) == [(0, "c", 0), (4, "c", 2)]


def test_the_own_program_is_followed_stage_by_stage(crossing, network):
    lights = find_lights(network, crossing()[0], ALL_STOP)
    heads = LightHeads(network, SignalTiming(decision_interval_s=30), lights, begins=False)
    follow = np.array([PROGRAM], np.int32)
    assert heads.request(follow, 0) == [(0, "c", 0), (3, "c", 1), (23, "c", 2)]
    assert heads.request(follow, 30) == [(0, "c", 2), (13, "c", 3)]


def test_vehicles_keep_the_kinds_of_their_file(crossing, write, tmp_path):
    bus = {"length": 12.0, "maxSpeed": 8.0}
    flows = [
        {"route": ["E_in", "W_out"], "interval": 1, "startTime": second, "endTime": second}
        | ({"vehicle": bus} if second == 2 else {})
        for second in (1, 2)
    ]
    made = cityflow_scenario(write(crossing()[0], "roadnet.json"), write(flows, "flow.json"))
    vehicles = made.demand.vehicles(made.network, 100, np.random.default_rng(0))
    assert write_flow(made.cityflow, made.network, vehicles, tmp_path) == [11.111, 8.0]
    written = json.loads((tmp_path / FLOW).read_text())
    assert [each["vehicle"]["length"] for each in written] == [5.0, 12.0]
    assert [(each["startTime"], each["endTime"]) for each in written] == [(1, 1), (2, 2)]
    config = json.loads(Path(write_configuration(tmp_path, seed=7, lane_changes=True)).read_text())
    assert config["laneChange"] is True
    assert config["seed"] == 7


def test_a_missing_module_is_told_with_its_source(monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    assert not process.has_cityflow()
    with pytest.raises(InputError, match=r"cityflow-project/CityFlow.*README"):
        make_simulator(scenario("grid:1x1"), "cityflow")
