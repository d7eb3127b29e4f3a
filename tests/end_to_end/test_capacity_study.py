"""``dmil study capacity`` from outside: small, and the same bytes on every way there."""

import json
import os
import signal
import subprocess
import time

import polars as pl
import pytest

from dmil.results import Results
from dmil.studies.capacity.figures import figures_of_study
from dmil.studies.capacity.tables import capacity_tables
from tests.end_to_end.conftest import COMMAND, environment
from tests.unit.vega_lite import check_valid

NAMES = "max-pressure,fixed-cycle"
TINY = ("study", "capacity", "--networks", "grid:1x1*10", "--controllers", NAMES, "--seeds", "3")
TINY += ("--steps", "1200", "--levels", "5", "--halvings", "2", "--data", ".")
FIGURES = {
    *("capacity", "delay-over-load", "disturbances"),
    *("after-incident", "after-surge"),
}


def tables(folder):
    return [(folder / name).read_bytes() for name in ("runs.parquet", "series.parquet")]


@pytest.fixture(scope="module")
def ran(dmil, tmp_path_factory):
    """A tiny study, run in two processes, with its report."""
    folder = tmp_path_factory.mktemp("capacity") / "one"
    return folder, dmil(*TINY, "--jobs", 2, "--out", folder)


@pytest.fixture(scope="module")
def made(ran):
    with Results(ran[0]) as results:
        return capacity_tables(results)


def test_every_controller_meets_the_same_vehicles_and_more_at_higher_loads(ran):
    with Results(ran[0]) as results:
        runs = results.runs().filter(pl.col("preset") == "capacity")
    assert runs["status"].unique().to_list() == ["ok"]
    spawned = runs.group_by("seed", "load").agg(pl.col("spawned_veh").unique()).sort("load")
    assert spawned["spawned_veh"].list.len().max() == 1
    for _, own in spawned.group_by("seed", maintain_order=True):
        assert own["spawned_veh"].explode().is_sorted()


def test_max_pressure_holds_more_than_a_fixed_cycle(made):
    rows = {row["controller"]: row for row in made.capacities.iter_rows(named=True)}
    ours, fixed = rows["max-pressure"], rows["fixed-cycle"]
    assert fixed["capacity"] < fixed["high"] < ours["low"] < ours["capacity"] < 10
    assert fixed["difference_high"] < 0 and not fixed["among_best"] and ours["among_best"]
    # 27 vehicles per minute is load 1.
    assert ours["veh_per_h"] == pytest.approx(27 * 60 * ours["capacity"], rel=0.05)
    assert ours["unbounded"] == 0


def test_delay_rises_with_the_load_until_the_queue_grows(made):
    own = made.curves.filter(controller="max-pressure")
    assert own["load"].to_list()[:2] == [2.0, 4.0]
    assert own["mean"].is_sorted()
    assert own["verdict"][0] == "stable"
    assert own["difference_pct"].to_list() == [0.0] * own.height


def test_every_disturbance_is_measured_beside_the_undisturbed_run(made):
    own = made.disturbances.filter(controller="max-pressure")
    assert own["disturbance"].to_list() == [
        *("undisturbed", "incident", "surge", "dead-detectors", "failing-detectors", "noise"),
        "other-day",
    ]
    rows = {row["disturbance"]: row for row in own.iter_rows(named=True)}
    assert rows["undisturbed"]["added_s"] == 0.0
    assert rows["incident"]["added_s"] > 0 and rows["surge"]["added_s"] > 0
    assert rows["incident"]["recovery_s"] is not None and rows["noise"]["recovery_s"] is None
    calm = made.courses.filter(pl.col("time_s") < 300, controller="max-pressure")
    assert calm["mean"].to_list() == [0.0] * calm.height and calm.height > 0


def test_the_figures_are_valid(made):
    drawn = {figure.name: figure for figure in figures_of_study(made, 1200)}
    assert drawn.keys() == FIGURES
    for figure in drawn.values():
        check_valid(figure.spec)


def test_the_terminal_fits_and_says_who_holds_what(ran):
    out = ran[1].out
    lines = out.splitlines()
    assert max(map(len, lines[:20])) <= 80
    for word in ("Highest stable load", "max-pressure", "fixed cycle", "disturbed", "surge"):
        assert word in out
    assert "report.html" in out


def test_the_report_is_there(ran):
    page = (ran[0] / "report.html").read_text(encoding="utf-8")
    assert "Capacity and disturbances" in page and "max-pressure holds the highest load" in page
    for name in FIGURES:
        assert (ran[0] / "figures" / f"{name}.svg").is_file()
        assert f'id="figure-{name}"' in page
    assert (ran[0] / "tables" / "capacities.csv").is_file()


def test_a_killed_study_goes_on_where_it_was(ran, dmil, tmp_path):
    folder = tmp_path / "stopped"
    command = [*COMMAND, *TINY, "--jobs", "1", "--no-report", "--out", str(folder)]
    running = subprocess.Popen(
        command, env=environment(), stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    parts = folder / "parts"
    while running.poll() is None and not list(parts.glob("runs-*")):
        time.sleep(0.05)
    os.killpg(running.pid, signal.SIGKILL)
    running.communicate(timeout=300)
    done = dmil(*TINY, "--jobs", 1, "--no-report", "--json", "--out", folder)
    assert tables(folder) == tables(ran[0])
    assert done.json["networks"] == ["grid:1x1"] and done.json["failed"] == 0


def test_the_configuration_names_networks_and_controllers(ran):
    configuration = json.loads((ran[0] / "manifest.json").read_text())["configuration"]
    assert configuration["networks"] == ["grid:1x1*10"]
    assert configuration["controllers"] == NAMES.split(",")
    assert "data" not in configuration


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--networks", "grid:1x1*much"), "SCENARIO*LOAD"),
        (("--networks", "grid:1x1*2,grid:1x1*3"), "every network once"),
        (("--networks", "grid:1x1", "--controllers", "program"), "runs on none of the networks"),
        (("--networks", "grid:1x1", "--controllers", "max-presure"), "Did you mean"),
        (("--networks", "cityflow:nowhere"), "DMIL_DATA"),
        (("--networks", "grid:1x1", "--tolerance", "0"), "tolerance"),
    ],
)
def test_bad_input_is_one_clear_error(dmil, tmp_path, options, message):
    done = dmil("study", "capacity", *options, "--out", tmp_path / "x", code=2, DMIL_DATA="")
    assert message in done.err and "Traceback" not in done.err
    assert not (tmp_path / "x").exists()
