"""``dmil study memories`` from outside: small, and the same bytes on every way there."""

import json
import os
import signal
import subprocess
import time

import polars as pl
import pytest

from dmil.cli.study import variants
from dmil.results import Results
from tests.end_to_end.conftest import COMMAND, environment

NAMES = "max-pressure,longest-queue-first,longest-queue-first,approaching=true,sarsa,epsilon=0.05"
TINY = ("study", "memories", "--small", "--cells", "grid:1x1,grid:1x2*2", "--seeds", "2")
TINY += ("--steps", "600", "--controllers", NAMES)
TABLES = ("runs.parquet", "series.parquet", "episodes.parquet", "lookups.parquet")


def tables(folder):
    return [(folder / name).read_bytes() for name in TABLES]


@pytest.fixture(scope="module")
def ran(dmil, tmp_path_factory):
    """A tiny study, run in two processes, with its report."""
    folder = tmp_path_factory.mktemp("memories") / "one"
    return folder, dmil(*TINY, "--jobs", 2, "--out", folder)


def test_controllers_are_split_before_names_and_not_before_options():
    assert variants(NAMES) == [
        "max-pressure",
        "longest-queue-first",
        "longest-queue-first,approaching=true",
        "sarsa,epsilon=0.05",
    ]


def test_every_controller_meets_the_same_vehicles(ran):
    with Results(ran[0]) as results:
        runs, episodes = results.runs(), results.episodes()
        timings = results.query("from timings")
    assert runs["status"].unique().to_list() == ["ok"]
    assert runs.height == timings.height == 2 * 2 * 4
    spawned = runs.group_by("scenario", "seed").agg(pl.col("spawned_veh").n_unique())
    assert spawned["spawned_veh"].unique().to_list() == [1]
    assert episodes.height == 2 * 2 * 2  # cells, seeds, episodes: of SARSA alone
    loads = runs.group_by("scenario").agg(pl.col("load").unique()).sort("scenario").rows()
    assert loads == [("grid:1x1", [1.0]), ("grid:1x2", [2.0])]
    assert (timings["decide_s"] > 0).all()


def test_the_terminal_says_who_stands_where(ran):
    out = ran[1].out
    assert max(map(len, out.splitlines()[:12])) <= 80
    for word in ("longest queue + approaching", "SARSA, ε .05", "W over max-pressure's", "1×2 ×2"):
        assert word in out
    assert "16 runs" in out and "report.html" in out


def test_the_report_is_there(ran):
    page = (ran[0] / "report.html").read_text(encoding="utf-8")
    assert "Memories for signal control" in page
    assert (ran[0] / "figures" / "standing.svg").is_file()
    assert (ran[0] / "tables" / "standing.md").is_file()


def test_a_killed_study_goes_on_in_one_process_and_gives_the_same_bytes(ran, dmil, tmp_path):
    folder = tmp_path / "stopped"
    command = [*COMMAND, *TINY, "--jobs", "2", "--no-report", "--out", str(folder)]
    running = subprocess.Popen(
        command, env=environment(), stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    parts = folder / "parts"
    while running.poll() is None and not list(parts.glob("runs-*")):
        time.sleep(0.05)
    os.killpg(running.pid, signal.SIGKILL)
    running.communicate(timeout=300)
    found = dmil(*TINY, "--jobs", 1, "--no-report", "--json", "--out", folder).json
    assert tables(folder) == tables(ran[0])
    assert found["cells"] == ["grid:1x1", "grid:1x2*2"]
    assert found["runs"] == 16 and found["failed"] == 0
    assert {row["controller"] for row in found["overall"]} == set(variants(NAMES))


def test_other_options_are_another_study(ran, dmil):
    done = dmil(*TINY, "--reward", "pressure", "--out", ran[0], code=2)
    assert "it holds another study, with other reward" in done.err


def test_cities_are_looked_for_where_the_variable_says(dmil, tmp_path):
    base = ("study", "memories", "--controllers", "max-pressure")
    done = dmil(*base, "--out", tmp_path / "cities", code=2, DMIL_DATA=str(tmp_path))
    assert "holds no city" in done.err and "Traceback" not in done.err


def test_bad_input_is_one_clear_error(dmil, tmp_path):
    options = ("--controllers", "max-pressure,aproaching=true")
    done = dmil("study", "memories", *options, "--out", tmp_path / "x", code=2, DMIL_DATA="")
    assert "Did you mean 'approaching'" in done.err and "Traceback" not in done.err
    assert not (tmp_path / "x").exists()


def test_the_configuration_names_cells_and_controllers(ran):
    configuration = json.loads((ran[0] / "manifest.json").read_text())["configuration"]
    assert configuration["cells"] == ["grid:1x1", "grid:1x2*2"]
    assert configuration["controllers"] == variants(NAMES)
    assert "data" not in configuration
