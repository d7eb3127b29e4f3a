"""``dmil study resco`` from outside: real SUMO, small, and the same bytes on every way there."""

import json
import os
import signal
import subprocess
import time

import polars as pl
import pytest

from dmil.results import Results
from tests.end_to_end.conftest import COMMAND, environment

pytest.importorskip("libsumo", reason="needs the extra sumo")
pytestmark = pytest.mark.slow

TINY = ("study", "resco", "--scenarios", "cologne1", "--seeds", "1", "--episodes", "2")
TINY += ("--steps", "600", "--no-report")
TABLES = ("runs.parquet", "series.parquet", "episodes.parquet")


def tables(folder):
    return [(folder / name).read_bytes() for name in TABLES]


@pytest.fixture(scope="module")
def study(dmil, tmp_path_factory):
    """A tiny study, run in two processes."""
    folder = tmp_path_factory.mktemp("resco") / "one"
    dmil(*TINY, "--jobs", 2, "--out", folder)
    return folder


def test_every_controller_is_judged_in_every_simulator(study):
    with Results(study) as results:
        runs, episodes = results.runs(), results.episodes()
    assert runs["status"].unique().to_list() == ["ok"]
    by_simulator = runs.group_by("simulator").len().sort("simulator").rows()
    # Nineteen controllers, of which SUMO's actuated control runs in SUMO only.
    assert by_simulator == [
        ("queue", 18),
        ("queue-calibrated", 18),
        ("sumo", 19),
        ("sumo-unblocked", 19),
    ]
    assert runs["locked"].null_count() == 0
    learners = runs.filter(pl.col("reward").is_not_null())
    assert set(learners["trained_in"]) == {"queue-calibrated"}
    assert episodes.height == 7 * 2
    assert (runs["delay_s"] > 0).all()
    # The same vehicles for everybody, and emissions where somebody knows them.
    assert runs["spawned_veh"].n_unique() == 1
    in_sumo = pl.col("simulator").is_in(["sumo", "sumo-unblocked"])
    assert (runs.filter(in_sumo)["co2_g"] > 0).all()
    assert runs.filter(~in_sumo)["co2_g"].null_count() == 36


def test_random_is_worse_than_max_pressure_in_every_simulator(study):
    with Results(study) as results:
        found = results.query(
            "select simulator, any_value(delay_s) filter (controller = 'random') as random,"
            " any_value(delay_s) filter (controller = 'max-pressure') as pressure"
            " from runs group by simulator"
        )
    assert found.height == 4
    assert (found["random"] > 1.5 * found["pressure"]).all()


def test_an_interrupted_study_goes_on_in_one_process_and_gives_the_same_bytes(
    study, dmil, tmp_path
):
    folder = tmp_path / "stopped"
    command = [*COMMAND, *TINY, "--jobs", "2", "--out", str(folder)]
    running = subprocess.Popen(
        command, env=environment(), stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    parts = folder / "parts"
    while running.poll() is None and not list(parts.glob("runs-*")):
        time.sleep(0.1)
    os.killpg(running.pid, signal.SIGINT)
    _, said = running.communicate(timeout=300)
    if running.returncode:  # it may have been quicker than the signal
        assert "repeat the command to continue" in said
        assert "Traceback" not in said
    dmil(*TINY, "--jobs", 1, "--out", folder)
    assert tables(folder) == tables(study)


def test_the_manifest_says_how_it_was_trained(study):
    configuration = json.loads((study / "manifest.json").read_text())["configuration"]
    assert configuration["train_in"] == "queue"
    assert configuration["calibrate"] is True
    assert configuration["episodes"] == 2


def test_an_unknown_network_is_one_error(dmil, tmp_path):
    done = dmil("study", "resco", "--scenarios", "cologne2", "--out", tmp_path / "x", code=2)
    assert "'cologne2'" in done.err
    assert "cologne1" in done.err
    assert not (tmp_path / "x").exists()
