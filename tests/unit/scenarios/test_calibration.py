"""Calibrations: files, and what they change about a scenario."""

import json

import numpy as np
import pytest

from dmil.errors import InputError
from dmil.network import grid
from dmil.scenarios import scenario
from dmil.scenarios.calibration import Calibration, digest_of, load_calibration
from dmil.scenarios.recipe import ScenarioRecipe
from dmil.simulation import QueueSimulator
from dmil.training import vehicles_of_seed


def calibration(network, *, slower_s=3.0, free_s=1.0):
    flow_s = network.free_flow_time_s
    return Calibration(
        scenario="grid:1x1",
        links_digest=digest_of(network),
        controller="max-pressure",
        seed=1,
        saturation_flow_veh_per_s=0.5,
        startup_lost_s=2,
        start_wave_veh_per_s=1.0,
        link_time_s=tuple((flow_s + slower_s).tolist()),
        link_free_s=tuple((flow_s + free_s).tolist()),
        headways=10,
        passages=20,
    )


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "c.json"
    calibration(grid(1, 1)).save(path)
    return path


def test_a_file_gives_back_what_was_saved(file):
    assert load_calibration(file) == calibration(grid(1, 1))


def test_the_queue_simulator_uses_what_was_measured(file):
    made = scenario("grid:1x1")
    changed = load_calibration(file).applied_to(made)
    assert changed.dynamics.saturation_flow_veh_per_s == 0.5
    assert (changed.timing.startup_lost_s, changed.dynamics.start_wave_veh_per_s) == (2, 1.0)
    np.testing.assert_array_equal(changed.link_time_s, made.network.free_flow_time_s + 3)
    recipe = ScenarioRecipe(scenario="grid:1x1", calibration=file)
    assert recipe.build() == changed
    faster = ScenarioRecipe(**recipe.model_dump() | {"timing": {"startup_lost_s": 0}}).build()
    assert (faster.timing.startup_lost_s, faster.link_time_s) == (0, changed.link_time_s)


def test_only_what_is_above_free_flow_is_lost():
    made = scenario("grid:1x1", horizon_s=300)
    drivers = vehicles_of_seed(made, 3)
    lost = []
    for free_s in (1.0, 3.0):
        changed = calibration(made.network, free_s=free_s).applied_to(made)
        simulator = QueueSimulator(changed)
        simulator.reset(drivers)
        seen = simulator.advance(np.zeros(1, np.int32))
        while seen.time_s < simulator.horizon_s:
            seen = simulator.advance(np.zeros(1, np.int32))
        lost.append(simulator.measures())
    slow, free = lost
    assert slow.travel_veh_s == free.travel_veh_s
    links = sum(drivers.route_offset[v + 1] - drivers.route_offset[v] for v in range(len(drivers)))
    assert 0 < slow.time_loss_veh_s - free.time_loss_veh_s <= 2 * links


def test_that_of_another_network_is_refused(file):
    with pytest.raises(
        InputError, match=r"links of 'grid:1x1'.*dmil calibrate --scenario grid:2x2"
    ):
        load_calibration(file).applied_to(scenario("grid:2x2"))


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        ({"version": 2}, "version"),
        ({"seed": None}, "seed"),
        ({"saturation_flow_veh_per_s": 0}, "saturation_flow_veh_per_s: .*greater than 0"),
        ({"of_another_program": 1}, "no such field"),
    ],
)
def test_what_is_no_calibration_is_refused(file, change, problem):
    file.write_text(json.dumps(json.loads(file.read_text()) | change))
    with pytest.raises(InputError, match=problem):
        load_calibration(file)


def test_a_file_that_cannot_be_read_is_refused(tmp_path):
    path = tmp_path / "c.json"
    with pytest.raises(InputError, match=r"no such file.*dmil calibrate"):
        load_calibration(path)
    path.write_text('{"version": 1')
    with pytest.raises(InputError, match="no JSON"):
        load_calibration(path)
    with pytest.raises(InputError, match="cannot be read"):
        load_calibration(tmp_path)
