"""Train, resume and evaluate the factored memory from the command line."""

import numpy as np
import pytest

from dmil.training import load_policy

TRAIN = ("train", "--scenario", "grid:2x2", "--controller", "factored", "--set", "trust=0.1")
TRAIN += ("--no-compare",)


@pytest.fixture(scope="module")
def trained(dmil, tmp_path_factory):
    path = tmp_path_factory.mktemp("factored") / "whole.npz"
    dmil(*TRAIN, "--episodes", 4, "--out", path)
    return path


def test_a_resumed_training_equals_an_uninterrupted_one(trained, dmil, tmp_path):
    parts = tmp_path / "parts.npz"
    dmil(*TRAIN, "--episodes", 1, "--out", parts)
    dmil("train", "--resume", parts, "--episodes", 4, "--no-compare")
    assert parts.read_bytes() == trained.read_bytes()


def test_a_policy_is_evaluated_beside_the_controller_itself(trained, dmil):
    judged = dmil(
        *("evaluate", "--scenario", "grid:2x2", "--policy", trained, "--controller", "factored"),
        *("--seeds", 3, "--jobs", 1, "--json"),
    )
    found = {each["controller"]: each for each in judged.json["controllers"]}
    assert {"whole.npz", "factored", "max-pressure"} <= set(found)
    policy = load_policy(trained)
    assert np.count_nonzero(policy.arrays["times"]) > 50


def test_a_policy_of_other_signals_is_refused(trained, dmil):
    done = dmil("evaluate", "--policy", trained, "--clearance", 3, "--seeds", 1, code=2)
    assert "Traceback" not in done.err
    assert "knows 2 of 3 ways to treat a lane" in done.err


def test_a_policy_of_signals_that_lose_time(dmil, tmp_path):
    path = tmp_path / "slow.npz"
    slow = ("--clearance", 3)
    dmil("train", "--scenario", "grid:1x2", "--controller", "factored", *slow, "--out", path)
    judged = dmil("evaluate", "--policy", path, *slow, "--seeds", 1, "--jobs", 1, "--json")
    assert judged.json["controllers"][0]["controller"] == "slow.npz"
