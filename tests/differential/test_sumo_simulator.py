"""The queue simulator and SUMO on the same roads, vehicles and signals: what must be alike."""

import importlib.util

import numpy as np
import pytest

from dmil.scenarios import scenario
from dmil.simulation import make_simulator
from dmil.training import vehicles_of_seed

pytestmark = pytest.mark.skipif(
    importlib.util.find_spec("libsumo") is None or importlib.util.find_spec("sumo_rl") is None,
    reason="needs the extra sumo",
)

HORIZON_S = 600


@pytest.fixture(scope="module", params=["grid:2x2", "resco/cologne1", "resco/cologne8"])
def place(request):
    # Below capacity of SUMO's drivers: what they would do beyond it is another question.
    load = 0.3 if request.param.startswith("grid") else 1.0
    made = scenario(request.param, horizon_s=HORIZON_S, load=load)
    return made, vehicles_of_seed(made, 0)


@pytest.fixture(scope="module")
def runs(place):
    """Simulator to what was seen in a run with a fixed cycle of 20 s per phase."""
    made, drivers = place
    counts = np.array([len(item.phases) for item in made.network.intersections])
    found = {}
    for name in ("queue", "sumo", "sumo-meso"):
        simulator = make_simulator(made, name)
        observation, seen = simulator.reset(drivers, 1), []
        while observation.time_s < HORIZON_S:
            phases = (observation.time_s // 20 % counts).astype(np.int32)
            observation = simulator.advance(phases)
            seen.append(observation)
        found[name] = seen, simulator.measures()
    return found


def test_the_same_vehicles_come_in_all_of_them(runs, place):
    spawned = {name: measures.spawned_veh for name, (_, measures) in runs.items()}
    assert set(spawned.values()) == {len(place[1])}


def test_the_same_phases_are_shown(runs):
    queue, *others = (seen for seen, _ in runs.values())
    for seen in others:
        for mine, theirs in zip(seen, queue, strict=True):
            assert mine.phase.tolist() == theirs.phase.tolist()
            assert mine.phase_elapsed_s.tolist() == theirs.phase_elapsed_s.tolist()


def test_most_vehicles_arrive_and_nobody_doubles(runs):
    for seen, measures in runs.values():
        assert 0.7 * measures.spawned_veh < measures.arrived_veh <= measures.spawned_veh
        assert measures.arrived_veh == measures.arrived_at[-1]
        inside = measures.spawned_veh - measures.arrived_veh
        last = seen[-1]
        assert last.queue_veh.sum() + last.approaching_veh.sum() <= inside


def test_travel_times_are_of_one_order(runs):
    queue = runs["queue"][1]
    for name in ("sumo", "sumo-meso"):
        assert 0.5 < runs[name][1].travel_time_s / queue.travel_time_s < 2.5, name


def test_queues_stand_at_the_same_stop_lines(runs):
    mean = {
        name: np.mean([each.queue_veh for each in seen], axis=0).ravel()
        for name, (seen, _) in runs.items()
    }
    for name in ("sumo", "sumo-meso"):
        assert np.corrcoef(mean["queue"], mean[name])[0, 1] > 0.7, name
