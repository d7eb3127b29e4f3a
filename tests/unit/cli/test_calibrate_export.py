"""Calibration and export on the command line."""

import csv
import importlib.util

import pytest

NAME = "resco/cologne1"
SHORT = ("--scenario", NAME, "--steps", "400")

with_sumo = pytest.mark.skipif(
    importlib.util.find_spec("libsumo") is None or importlib.util.find_spec("sumo_rl") is None,
    reason="needs the extra sumo",
)


@with_sumo
def test_a_calibration_is_measured_shown_and_used(dmil, tmp_path):
    file = tmp_path / "c.json"
    shown = dmil("calibrate", *SHORT, "--out", file)
    assert "saturation flow" in shown
    assert "longest-queue-first" in shown
    assert f"Written: {file}" in dmil.err
    plain = dmil.json("simulate", *SHORT)
    used = dmil.json("simulate", *SHORT, "--calibration", file)
    assert used["runs"][0]["travel_time_s"] > plain["runs"][0]["travel_time_s"]
    found = dmil.json("calibrate", *SHORT, "--out", file, "--seeds", "0")
    assert found["comparison"] == []
    assert found["calibration"]["scenario"] == NAME
    dmil("simulate", "--scenario", "grid:1x1", "--calibration", file, code=2)
    assert "expected a calibration of the same network" in dmil.err


def test_a_calibration_that_is_not_there(dmil, tmp_path):
    dmil("simulate", "--scenario", "grid:1x1", "--calibration", tmp_path / "c.json", code=2)
    assert "there is no such file" in dmil.err


@with_sumo
def test_a_controller_is_exported_and_compared(dmil, tmp_path):
    shown = dmil("export", *SHORT, "--out", tmp_path)
    assert "its fixed-time plan" in shown
    programs = (tmp_path / "programs.add.xml").read_text()
    assert programs.count("<tlLogic") == 1
    assert 'programID="dmil" offset="0"' in programs
    rows = list(csv.DictReader((tmp_path / "signals.csv").read_text().splitlines()))
    assert (rows[0]["time_s"], rows[0]["from_phase"]) == ("0", "")
    found = dmil.json("export", *SHORT, "--out", tmp_path, "--plans", "200")
    assert [plan["since_s"] for plan in found["plans"]] == [0, 200]
    assert (tmp_path / "programs.add.xml").read_text().count("<tlLogic") == 2
    delays = {label: each["delay_s"] for label, each in found["in_sumo"].items()}
    assert list(delays) == ["max-pressure", "its fixed-time plan", "the network's program"]
    assert delays["its fixed-time plan"] != delays["the network's program"]


def test_a_network_that_is_not_sumos_gives_events_only(dmil, tmp_path):
    found = dmil.json("export", "--scenario", "grid:1x2", "--steps", "60", "--out", tmp_path)
    assert found["files"] == [str(tmp_path / "signals.csv")]
    assert found["in_sumo"] == {}
    assert [path.name for path in tmp_path.iterdir()] == ["signals.csv"]


@with_sumo
def test_a_network_is_written_for_sumo_if_asked(dmil, tmp_path):
    found = dmil.json(
        "export", "--scenario", "grid:1x2", "--steps", "60", "--out", tmp_path, "--network"
    )
    assert {path.rsplit("/", 1)[-1] for path in found["files"]} == {
        "signals.csv",
        "network.net.xml",
        "programs.add.xml",
    }


@with_sumo
def test_the_own_program_needs_no_export(dmil, tmp_path):
    dmil("export", *SHORT, "--controller", "program", "--out", tmp_path / "plan", code=2)
    assert "needs no export" in dmil.err
    assert not (tmp_path / "plan").exists()


def test_a_folder_that_cannot_be_made(dmil, tmp_path):
    file = tmp_path / "file"
    file.write_text("")
    dmil("export", "--scenario", "grid:1x1", "--steps", "60", "--out", file, code=2)
    assert "expected a folder" in dmil.err
