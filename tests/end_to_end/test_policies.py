"""Train, save, go on, evaluate: as a user does it, and the numbers are those of the library."""

import os
import re
import signal
import subprocess
import sys

import numpy as np
import polars as pl
import pytest

from dmil.controllers import make_controller
from dmil.demand import PoissonDemand
from dmil.importing import only
from dmil.rewards import make_reward
from dmil.scenarios import scenario
from dmil.simulation import QueueSimulator
from dmil.training import controller_of, evaluate, load_policy, vehicles_of_seed

TRAIN = ("train", "--scenario", "grid:1x2", "--controller", "dual-memory")
TRAIN += ("--set", "embedding=complex")
TRAIN += ("--set", "communication=true", "--seed", "4")
MINE = """
import numpy as np


class Patient:
    def __init__(self, hold=3):
        self.hold = hold

    def reset(self, context):
        self.phases = np.array([len(i.phases) for i in context.network.intersections])
        self.decided = 0

    def decide(self, observation, reward):
        self.decided += 1
        return (self.decided // self.hold % self.phases).astype(np.int32)


def calm(before, after, network):
    return -np.square(after.queue_veh).sum(axis=1).astype(float)
"""


def travel_times(controller, name, seeds):
    """What the library gives for a controller made anew in each seed."""
    made = scenario(name)
    found = []
    for seed in seeds:
        vehicles = vehicles_of_seed(made, seed)
        reward = make_reward("diffusion")
        run = evaluate(QueueSimulator(made), controller(made.network), vehicles, reward, seed)
        found.append(run.measures.travel_time_s)
    return found


@pytest.fixture(scope="module")
def trained(dmil, tmp_path_factory):
    path = tmp_path_factory.mktemp("trained") / "whole.npz"
    done = dmil(*TRAIN, "--episodes", 6, "--out", path, "--json")
    assert [row["episode"] for row in done.json["episodes"]] == [1, 2, 3, 4, 5, 6]
    return path


def test_a_resumed_training_equals_an_uninterrupted_one(trained, dmil, tmp_path):
    path, log = tmp_path / "parts.npz", tmp_path / "log.csv"
    dmil(*TRAIN, "--episodes", 2, "--out", path, "--log", log)
    done = dmil("train", "--resume", path, "--episodes", 6, "--log", log)
    assert pl.read_csv(log)["episode"].to_list() == [1, 2, 3, 4, 5, 6]
    assert [line.split()[0] for line in done.out.splitlines()[1:5]] == ["3", "4", "5", "6"]
    assert path.read_bytes() == trained.read_bytes()


def test_a_resumed_training_keeps_its_settings(trained, dmil):
    done = dmil("train", "--resume", trained, "--seed", 5, "--episodes", 9, code=2)
    assert "seed differs from that of the policy" in done.err
    done = dmil("train", "--resume", trained, "--seed", 4, "--episodes", 6)
    assert "has its 6 episodes already" in " ".join(done.out.split())


@pytest.mark.slow
def test_ctrl_c_keeps_the_last_episode(dmil, tmp_path):
    process = subprocess.Popen(
        [sys.executable, "-m", "dmil", *TRAIN, "--episodes", "5000", "--out", "p.npz"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=tmp_path,
        env={**os.environ, "NO_COLOR": "1"},
    )
    for line in process.stdout:
        if line.split()[0] == "3":
            break
    process.send_signal(signal.SIGINT)
    _, err = process.communicate()
    assert process.returncode == 1
    assert "Traceback" not in err
    kept, command = re.search(
        r"(\d+) of 5000 episodes are kept; go on with: dmil (.+)", err
    ).groups()
    assert load_policy(tmp_path / "p.npz").training["episodes"] == int(kept)
    assert command == "train --resume p.npz --episodes 5000"
    assert [path.name for path in tmp_path.iterdir()] == ["p.npz"]

    more = str(int(kept) + 1)
    dmil("train", "--resume", "p.npz", "--episodes", more, cwd=tmp_path)
    dmil(*TRAIN, "--episodes", more, "--out", "whole.npz", cwd=tmp_path)
    assert (tmp_path / "p.npz").read_bytes() == (tmp_path / "whole.npz").read_bytes()


def test_the_table_has_the_librarys_numbers(trained, dmil):
    policy = load_policy(trained)

    def frozen(network):
        return controller_of(policy, network, where="", learning=False, epsilon=0.0)

    done = dmil("evaluate", "--policy", trained, "--seeds", 3, "--jobs", 1, "--json")
    found = {each["controller"]: each for each in done.json["controllers"]}
    assert set(found) == {"whole.npz", "fixed-cycle", "longest-queue-first", "max-pressure"}
    delays = [each["measures"]["delay_s"]["mean"] for each in found.values()]
    assert delays == sorted(delays)
    ours = travel_times(frozen, "grid:1x2", range(3))
    theirs = travel_times(lambda _: make_controller("max-pressure"), "grid:1x2", range(3))
    measured = found["whole.npz"]
    assert measured["per_seed"]["travel_time_s"] == ours
    assert measured["measures"]["travel_time_s"]["mean"] == pytest.approx(np.mean(ours))
    minus = measured["minus_max-pressure"]["travel_time_s"]
    assert minus["mean"] == pytest.approx(np.mean(ours) - np.mean(theirs))
    assert minus["low"] < minus["mean"] < minus["high"]
    assert measured["measures"]["bytes_per_intersection"]["mean"] > 0
    assert found["max-pressure"]["minus_max-pressure"]["travel_time_s"]["mean"] == 0

    two = dmil("evaluate", "--policy", trained, "--seeds", 3, "--jobs", 2, "--json")
    assert two.out == done.out
    assert "runs, 100 %" in two.err


def test_what_is_recorded_is_the_same_in_every_seed(dmil, city):
    folder = city()
    files = ("--roadnet", folder / "roadnet.json", "--flow", folder / "flow.json")
    done = dmil("evaluate", *files, "--controller", "random", "--seeds", 1, "--jobs", 1, "--json")
    assert done.json["same_demand"] is True
    assert any("recorded, the same in every seed" in note for note in done.json["notes"])
    found = {each["controller"]: each["measures"] for each in done.json["controllers"]}
    assert {"program", "combined", "factored", "lookahead", "max-pressure,approaching=true"} < set(
        found
    )
    # One day: an interval over seeds that change nothing would say more than is known.
    assert {each["travel_time_s"]["low"] for each in found.values()} == {None}


def test_a_city_is_trained_on_and_judged(dmil, city):
    folder = city()
    dmil("train", "--scenario", f"cityflow:{folder}", "--episodes", 2, "--out", folder / "p.npz")
    done = dmil("evaluate", "--policy", folder / "p.npz", "--seeds", 2, "--jobs", 1, cwd=folder)
    for word in ("travel time", "throughput", "mean queue", "memory entries", "memory bytes"):
        assert word in done.out
    assert "Vehicles that have not arrived count" in done.out
    assert "frozen, ε = 0" in done.out
    assert "Decisions every 15 s, clearance as each plan says" in done.out
    assert max(map(len, done.out.splitlines())) <= 80


def test_a_users_own_parts_are_found_where_they_are(dmil, tmp_path):
    (tmp_path / "mine.py").write_text(MINE)
    arguments = ("--controller", "mine:Patient", "--set", "hold=2", "--seeds", 2, "--json")
    arguments = ("evaluate", "--scenario", "grid:1x1", *arguments, "--jobs", 2)
    done = dmil.process(*arguments, cwd=tmp_path)
    found = {each["controller"]: each["per_seed"] for each in done.json["controllers"]}
    assert found["mine:Patient,hold=2"]["arrived_veh"] != found["fixed-cycle"]["arrived_veh"]
    assert found["mine:Patient,hold=2"]["spawned_veh"] == found["fixed-cycle"]["spawned_veh"]

    train = ("train", "--scenario", "grid:1x1", "--reward", "mine:calm", "--episodes", 1)
    dmil(*train, "--out", "p.npz", cwd=tmp_path)
    with only(["mine:calm"]):
        assert load_policy(tmp_path / "p.npz").reward == "mine:calm"


def test_a_series_is_written_by_the_second(dmil, tmp_path):
    arguments = ("--scenario", "grid:1x1", "--seeds", 2, "--load", 2, "--steps", 100)
    for ending, read in ((".csv", pl.read_csv), (".parquet", pl.read_parquet)):
        path = tmp_path / f"series{ending}"
        record = ("--record", tmp_path / "run")
        done = dmil("simulate", *arguments, "--series", path, *record, "--json")
        table = read(path)
        assert table.columns == ["seed", "time_s", "arrived_veh", "queue_veh"]
        assert table.height == 200
        last = table.filter(pl.col("time_s") == 100)["arrived_veh"].to_list()
        assert last == [run["arrived_veh"] for run in done.json["runs"]]
    assert pl.read_parquet(tmp_path / "run" / "seconds.parquet").equals(table)
    made = scenario("grid:1x1", load=2.0, horizon_s=100)
    assert isinstance(made.demand, PoissonDemand)
    spawned = [len(vehicles_of_seed(made, seed)) for seed in range(2)]
    assert [run["spawned_veh"] for run in done.json["runs"]] == spawned


def test_several_seeds_have_an_interval(dmil):
    done = dmil("simulate", "--scenario", "grid:1x1", "--seeds", 3)
    assert "seeds 0–2" in done.out
    assert re.search(r"travel time +\d+\.\d +\[\d+\.\d, \d+\.\d\] +s", done.out)
