"""Vehicles that SUMO sends elsewhere during a run are counted where they are."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

from dmil.controllers import make_controller
from dmil.rewards import make_reward
from dmil.scenarios import SumoConfiguration, sumo_scenario
from dmil.simulation import SumoSimulator
from dmil.training import evaluate, vehicles_of_seed

pytestmark = pytest.mark.skipif(
    importlib.util.find_spec("libsumo") is None, reason="needs the extra sumo"
)

CASE = Path(__file__).parents[2] / "cases/rerouting-device"
EVERYBODY = ["--device.rerouting.probability", "1"]


@pytest.fixture(scope="module")
def detour():
    """180 vehicles by way of D, where way B is faster, and 45 that cross each of the two."""
    files = SumoConfiguration(CASE / "net.net.xml", (CASE / "r0.rou.xml",))
    return sumo_scenario(files, horizon_s=1200)


@pytest.fixture(scope="module")
def rerouting(detour):
    """A simulator where everybody looks for another way."""
    made = SumoSimulator(detour, further_options=lambda files: EVERYBODY)
    yield made
    made.close()


def test_a_controller_sees_those_that_reroute(detour, rerouting):
    controller, vehicles = make_controller("max-pressure"), vehicles_of_seed(detour, 0)
    measures = evaluate(rerouting, controller, vehicles, make_reward("default"), 0).measures
    assert (measures.spawned_veh, measures.arrived_veh) == (270, 270)
    assert measures.time_loss_veh_s / 270 < 20  # blind to them: 563 s, 63 arrive
    assert measures.visits == 270  # one signal on either way


def test_queues_stand_where_sumo_has_them(detour, rerouting):
    at = {item.id: i for i, item in enumerate(detour.network.intersections)}
    by_file = SumoSimulator(detour)

    def longest(simulator):
        phases = np.zeros(len(at), np.int32)
        simulator.reset(vehicles_of_seed(detour, 0))
        seen = [simulator.advance(phases) for _ in range(40)]
        return [max(each.queue_veh[at[node]].sum() for each in seen) for node in "BD"]

    (by_file_b, by_file_d), (b, d) = longest(by_file), longest(rerouting)
    by_file.close()
    assert b > by_file_b
    assert d < by_file_d


def test_the_next_run_begins_with_the_routes_of_the_file(detour, rerouting):
    vehicles = vehicles_of_seed(detour, 0)
    phases = np.zeros(len(detour.network.intersections), np.int32)
    runs = []
    for _ in range(2):
        first = rerouting.reset(vehicles)
        runs.append([first, *(rerouting.advance(phases) for _ in range(20))])
    for before, after in zip(*runs, strict=True):
        assert np.array_equal(before.queue_veh, after.queue_veh)
        assert np.array_equal(before.approaching_veh, after.approaching_veh)
