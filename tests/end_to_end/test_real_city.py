"""A real network with recorded demand: train on it, and judge the policy beside the baselines."""

import os
from pathlib import Path

import pytest

JINAN = Path(os.environ.get("DMIL_DATA", "")) / "cityflow" / "jinan_3x4"

pytestmark = pytest.mark.skipif(
    not os.environ.get("DMIL_DATA") or not JINAN.is_dir(),
    reason="DMIL_DATA does not name a folder with cityflow/jinan_3x4",
)


@pytest.fixture(scope="module")
def judged(dmil, tmp_path_factory):
    policy = tmp_path_factory.mktemp("jinan") / "policy.npz"
    name = f"cityflow:{JINAN}"
    setting = ("--set", "epsilon=0.1")
    dmil("train", "--scenario", name, *setting, "--episodes", 4, "--out", policy)
    done = dmil("evaluate", "--scenario", name, "--policy", policy, "--seeds", 10, "--json")
    return done.json


def row(judged, controller):
    return next(each for each in judged["controllers"] if each["controller"].endswith(controller))


def test_every_controller_is_judged_on_the_same_vehicles_and_ten_seeds(judged):
    assert judged["same_demand"] is True
    assert len(judged["seeds"]) == 10
    names = {each["controller"] for each in judged["controllers"]}
    assert names == {"policy.npz", "fixed-cycle", "longest-queue-first", "max-pressure"}


def test_travel_times_lie_between_free_flow_and_the_fixed_cycle(judged):
    # Free flow on the recorded routes takes 237.6 s.
    times = {
        each["controller"]: each["measures"]["travel_time_s"]["mean"]
        for each in judged["controllers"]
    }
    assert 237.6 < times["longest-queue-first"] < times["policy.npz"] < times["fixed-cycle"]
    assert 237.6 < times["max-pressure"] < times["policy.npz"]


def test_the_policy_remembers_and_the_baselines_do_not(judged):
    memory = row(judged, "policy.npz")["measures"]
    assert memory["entries_per_agent"]["mean"] > 10
    assert memory["bytes_per_intersection"]["mean"] > 1000
    assert row(judged, "max-pressure")["measures"]["entries_per_agent"]["mean"] == 0


def test_what_draws_nothing_has_an_exact_interval(judged):
    time = row(judged, "max-pressure")["measures"]["travel_time_s"]
    assert time["low"] == time["mean"] == time["high"]
