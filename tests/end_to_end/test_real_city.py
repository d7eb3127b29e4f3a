"""A real network with recorded demand: train on it, and judge the policy beside the baselines."""

import os
from pathlib import Path

import pytest

JINAN = Path(os.environ.get("DMIL_DATA", "")) / "cityflow" / "jinan_3x4"

QUEUE, PRESSURE = "longest-queue-first,approaching=true", "max-pressure,approaching=true"

pytestmark = pytest.mark.skipif(
    not os.environ.get("DMIL_DATA") or not JINAN.is_dir(),
    reason="DMIL_DATA does not name a folder with cityflow/jinan_3x4",
)


@pytest.fixture(scope="module")
def judged(dmil, tmp_path_factory):
    policy = tmp_path_factory.mktemp("jinan") / "policy.npz"
    name = f"cityflow:{JINAN}"
    setting = ("--controller", "dual-memory", "--set", "epsilon=0.1")
    dmil("train", "--scenario", name, *setting, "--episodes", 4, "--out", policy, "--no-compare")
    run = ("evaluate", "--scenario", name, "--policy", policy, "--controller", "fixed-cycle")
    return dmil(*run, "--seeds", 3, "--jobs", 1, "--json").json


def row(judged, controller):
    return next(each for each in judged["controllers"] if each["controller"].endswith(controller))


def test_every_controller_is_judged_on_the_same_vehicles_and_three_seeds(judged):
    assert judged["same_demand"] is True
    assert len(judged["seeds"]) == 3
    names = {each["controller"] for each in judged["controllers"]}
    learning = {"combined", "factored", "lookahead"}
    assert names == {"policy.npz", "program", "fixed-cycle", QUEUE, PRESSURE} | learning


def test_travel_times_lie_between_free_flow_and_the_fixed_cycle(judged):
    # Free flow on the recorded routes takes 237.6 s.
    times = {
        each["controller"]: each["measures"]["travel_time_s"]["mean"]
        for each in judged["controllers"]
    }
    assert 237.6 < times[QUEUE] < times["policy.npz"] < times["fixed-cycle"]
    assert 237.6 < times[PRESSURE] < times["policy.npz"]


def test_the_policy_remembers_and_the_baselines_do_not(judged):
    memory = row(judged, "policy.npz")["measures"]
    assert memory["entries_per_agent"]["mean"] > 10
    assert memory["bytes_per_intersection"]["mean"] > 1000
    assert row(judged, PRESSURE)["measures"]["entries_per_agent"]["mean"] == 0


def test_one_recorded_day_has_no_interval(judged):
    time = row(judged, PRESSURE)["measures"]["travel_time_s"]
    assert time["low"] is time["high"] is None
    assert 237.6 < time["mean"] < 400
