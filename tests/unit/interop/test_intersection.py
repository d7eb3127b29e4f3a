"""The Gymnasium environment: Gymnasium's own checker, names, seeds."""

import importlib.util

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from dmil import REWARDS, QueueSimulator, evaluate, make_controller, scenario, vehicles_of_seed
from dmil.errors import InputError
from dmil.interop import ENVIRONMENTS, ControllerPolicy, IntersectionEnv, register_environments

CHECKED = ("dmil/Queue1x1-v0", "dmil/SumoCologne1-v0", "dmil/QueueIngolstadt1-v0")
"""Both simulators and all scenarios; each is made three times, and reset 13 times."""


@pytest.mark.parametrize("name", ENVIRONMENTS)
def test_gymnasiums_checker_passes(name):
    if name != "dmil/Queue1x1-v0" and importlib.util.find_spec("libsumo") is None:
        pytest.skip("needs the extra sumo")
    with gymnasium.make(name) as made:
        if name in CHECKED:
            check_env(made.unwrapped)
        else:  # Gymnasium watches these, too
            made.reset(seed=0)
            assert made.step(0)[4]["time_s"] == 10


def test_names_are_registered_once_and_found_through_the_module():
    register_environments()
    assert set(ENVIRONMENTS) <= set(gymnasium.registry)
    made = gymnasium.make("dmil.interop:dmil/Queue1x1-v0", horizon_s=60, reward="queue")
    made.reset(seed=0)
    *_, truncated, info = made.step(0)
    for _ in range(5):
        assert not truncated
        _, _, terminated, truncated, info = made.step(0)
        assert not terminated
    assert truncated
    assert info["measures"]["mean_queue_veh"] > 0
    with pytest.raises(InputError, match=r"the run is over.*Call reset"):
        made.step(0)


def test_a_seed_brings_the_vehicles_of_an_evaluation():
    ground = scenario("grid:1x1")
    made = gymnasium.make("dmil/Queue1x1-v0")
    _, info = made.reset(seed=5)
    policy = ControllerPolicy(made, make_controller("longest-queue-first"))
    truncated = False
    while not truncated:
        _, _, _, truncated, info = made.step(policy.actions())
    controller = make_controller("longest-queue-first")
    vehicles = vehicles_of_seed(ground, 5)
    run = evaluate(QueueSimulator(ground), controller, vehicles, REWARDS["diffusion"], 5)
    assert info["measures"]["travel_time_s"] == run.measures.travel_time_s
    _, first = made.reset()
    _, second = made.reset()
    assert len({5, first["seed"], second["seed"]}) == 3


def test_actions_may_be_numpy_numbers():
    made = IntersectionEnv()
    made.reset(seed=0)
    for action in (3, np.int64(3), np.array(3)):
        assert made.step(action)[4]["phase"] == 3


def test_the_names_are_stable():
    assert set(ENVIRONMENTS) == {
        f"dmil/{simulator}{scenario}-v0"
        for simulator in ("Queue", "Sumo")
        for scenario in ("1x1", "Cologne1", "Ingolstadt1")
    }


def test_several_intersections_are_a_clear_error():
    with pytest.raises(InputError, match=r"grid:2x2: it has 4 intersections.*parallel_env"):
        IntersectionEnv("grid:2x2")


def test_vector_environments_run():
    made = gymnasium.make_vec("dmil/Queue1x1-v0", num_envs=3)
    vectors, infos = made.reset(seed=0)
    assert vectors.shape == (3, 34)
    assert infos["seed"].tolist() == [0, 1, 2]
    for _ in range(30):
        vectors, _, _, truncated, infos = made.step(made.action_space.sample())
    assert truncated.all()
    assert (infos["measures"]["travel_time_s"] > 0).all()
    made.close()
