"""Files behind a command, and in place of its options, in every command alike."""

import shutil
from pathlib import Path

import pytest

CASE = Path(__file__).parents[2] / "cases" / "factored-stuck"
DRIVE = r"C:\roads\city"
STEPS = ("--steps", 300)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with a configuration, and with the names that another system gives its files."""
    pytest.importorskip("sumolib", reason="needs the extra sumo")
    for name in ("city", DRIVE):
        shutil.copy(CASE / "net.net.xml", tmp_path / f"{name}.net.xml")
        shutil.copy(CASE / "r.rou.xml", tmp_path / f"{name}.rou.xml")
        (tmp_path / f"{name}.sumocfg").write_text(
            f'<configuration><net-file value="{name}.net.xml"/>'
            f'<route-files value="{name}.rou.xml"/><end value="300"/></configuration>'
        )
    monkeypatch.chdir(tmp_path)
    return tmp_path


WAYS = [
    ("city.sumocfg",),
    ("sumo:city.sumocfg",),
    ("--scenario", "city.sumocfg"),
    ("city.net.xml", "city.rou.xml", *STEPS),
    ("city.rou.xml", "city.net.xml", *STEPS),
    ("--net", "city.net.xml", "--routes", "city.rou.xml", *STEPS),
    (f"{DRIVE}.sumocfg",),
    (f"sumo:{DRIVE}.sumocfg",),
    ("--scenario", f"{DRIVE}.sumocfg"),
    (f"{DRIVE}.net.xml", f"{DRIVE}.rou.xml", *STEPS),
]


@pytest.mark.parametrize("way", WAYS)
def test_every_way_to_name_the_files_is_the_same_scenario(dmil, folder, way):
    run = dmil.json("simulate", *way, "--controller", "Program")
    assert run["horizon_s"] == 300
    assert run["runs"][0]["spawned_veh"] == 90
    examined = dmil.json("doctor", *way)
    assert (examined["horizon_s"], examined["demand"]["vehicles"]) == (300, 90)


def test_train_evaluate_and_export_take_the_file(dmil, folder):
    dmil("train", "city.sumocfg", "--episodes", 1, "--out", "p.npz")
    found = dmil.json("evaluate", "city.sumocfg", "--policy", "p.npz", "--seeds", 1, "--jobs", 1)
    assert "p.npz" in [each["controller"] for each in found["controllers"]]
    queue = ("--simulator", "queue", "--controller", "fixed-cycle")
    assert dmil.json("export", "city.sumocfg", *queue)["scenario"] == "sumo:city.sumocfg"


@pytest.mark.slow
def test_calibrate_takes_the_file(dmil, folder):
    pytest.importorskip("libsumo", reason="needs the extra sumo")
    dmil("calibrate", "city.sumocfg", "--seeds", 0)
    assert (folder / "calibration.json").is_file()


def test_a_name_works_behind_the_command_too(dmil):
    assert dmil.json("simulate", "Grid:2x2", "--steps", 30)["scenario"] == "grid:2x2"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("simulate", "missing.sumocfg"), "missing.sumocfg: there is no such file"),
        (("simulate", r"C:\no\x.net.xml"), r"C:\no\x.net.xml: there is no such file"),
        (("simulate", "gird:3x3"), "Did you mean 'grid:3x3'?"),
        (("simulate", "grid:3x3", "--scenario", "grid:1x1"), "is given by FILES, too"),
        (("simulate", "grid:3x3", "--net", "x.net.xml"), "scenario and net"),
        (("doctor",), "FILES: there are 0 configurations and 0 networks"),
    ],
)
def test_what_is_wrong_with_the_files_is_told(dmil, arguments, message):
    dmil(*arguments, code=2)
    assert message in dmil.err


def test_the_end_of_a_training_says_how_the_policy_compares(dmil, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # a long name would be wrapped
    policy = "p.npz"
    train = ("train", "grid:2x2", "--steps", 300, "--episodes", 1, "--out", policy)
    found = dmil.json(*train)["compared"]["delay_s"]
    rivals = ("fixed-cycle", "max-pressure", "longest-queue-first,approaching=true", "combined")
    assert set(found) == {"p.npz", *rivals}
    lines = dmil(*train).splitlines()
    assert lines[-1] == f"Policy: {policy}. Judge it: dmil evaluate --policy {policy}"
    best = min(found, key=found.get)
    lost = found["p.npz"] - found[best]
    assert lost > 0
    assert lines[-2] == (
        f"p.npz loses to {best}, which needs no training, by {lost:.1f} s per vehicle."
    )
    assert not any("loses" in line for line in dmil(*train, "--no-compare").splitlines())
