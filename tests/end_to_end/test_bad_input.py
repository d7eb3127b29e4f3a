"""Whatever cannot be used: one clear error, exit code 2, no traceback, nothing left behind."""

import json
import os
import sys
from pathlib import Path

import numpy as np
import pytest

MINE = """
import numpy as np

class NoVerbs:
    pass

class Stops:
    def reset(self, context):
        raise MemoryError("400 TiB")

    def decide(self, observation, reward): ...

class WrongPhase:
    def reset(self, context):
        self.count = len(context.network.intersections)

    def decide(self, observation, reward):
        return np.full(self.count, 99, np.int32)
"""
STUDY = ("study", "paper", "--preset", "literal", "--grids", "1x1", "--seeds", "1", "--no-report")
RUN = ("simulate", "--scenario", "grid:1x1")
BAD_VALUES = {
    "negative load": ((*RUN, "--load", "-1"), "--load: found -1.0; expected at least 0"),
    "load that is no number": ((*RUN, "--load", "nan"), "--load: found nan"),
    "infinite load": ((*STUDY, "--load", "inf", "--out", "new"), "--load: found inf"),
    "zero steps": ((*STUDY, "--steps", "0", "--out", "new"), "--steps: found 0"),
    "a run without a decision": ((*RUN, "--steps", "9"), "horizon is 9 s"),
    "zero seeds": ((*STUDY, "--seeds", "0", "--out", "new"), "--seeds: found 0"),
    "zero jobs": ((*STUDY, "--jobs", "0", "--out", "new"), "--jobs: found 0"),
    "a scenario": (("simulate", "--scenario", "gird:5x5"), "Did you mean 'grid:5x5'?"),
    "a grid": ((*STUDY, "--grids", "5by5", "--out", "new"), "expected grid:ROWSxCOLUMNS"),
    "a controller": ((*RUN, "--controller", "max-presure"), "Did you mean 'max-pressure'?"),
    "a reward": ((*STUDY, "--rewards", "difusion", "--out", "new"), "Did you mean 'diffusion'?"),
    "an embedding": (
        (*RUN, "--controller", "sarsa", "--set", "embedding=simpel"),
        "Did you mean 'simple'?",
    ),
    "a preset": ((*STUDY, "--preset", "litteral", "--out", "new"), "Did you mean 'literal'?"),
    "an option": ((*STUDY, "--sedes", "3", "--out", "new"), "No such option: --sedes"),
    "a setting": (
        (*RUN, "--controller", "sarsa", "--set", "epsilom=0"),
        "Did you mean 'epsilon'?",
    ),
    "a module": ((*RUN, "--controller", "nowhere:Mine"), "'nowhere' cannot be imported"),
    "a class without verbs": ((*RUN, "--controller", "mine:NoVerbs"), "lacks the verbs"),
    "a phase that is not there": (
        (*RUN, "--controller", "mine:WrongPhase"),
        "the controller chose phase 99; expected a phase from 0 to 7",
    ),
    "an output folder that is a file": ((*STUDY, "--out", "mine.py"), "mine.py: it is a file"),
    "an output folder with other files": ((*STUDY, "--out", "."), "it holds other files"),
    "a number without end": ((*RUN, "--seed", "9" * 30), "--seed: found 999"),
    "a load of millions": ((*RUN, "--load", "1e9"), "--load: found 1000000000.0"),
    "a run of centuries": ((*RUN, "--steps", "9" * 30), "--steps: found 999"),
    "more memory than there is": (
        (*RUN, "--controller", "mine:Stops"),
        "too large for this machine (400 TiB)",
    ),
    "a module that ends the program": (
        (*RUN, "--controller", "leaves:Mine"),
        "'leaves' cannot be imported (SystemExit: 0)",
    ),
    "a policy that would be a folder": (
        ("train", "--scenario", "grid:1x1", "--episodes", "1", "--no-prior", "--out", "a_folder"),
        "a_folder: it is a folder",
    ),
    "a grid in other digits": ((*RUN[:2], "grid:٣x3"), "expected grid:ROWSxCOLUMNS"),
    "a table that is a list": ((*RUN, "--config", "list.toml"), "found [1]; expected a table."),
    "a policy that is none": ((*RUN, "--policy", "mine.py"), "mine.py: not a whole policy"),
    "a missing policy": ((*RUN, "--policy", "no.npz"), "no.npz: there is no such file"),
}


def judge(done, *said):
    """One error and nothing else."""
    assert done.out == ""
    lines = done.err.strip().splitlines()
    assert lines[0].startswith("error: "), done.err
    assert all(text in lines[0] for text in said), done.err
    assert len(lines) == 1 or lines[1].startswith("Help: "), done.err
    assert "Traceback" not in done.err


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", "1")
    (tmp_path / "mine.py").write_text(MINE)
    (tmp_path / "leaves.py").write_text("raise SystemExit(0)")
    (tmp_path / "list.toml").write_text("timing = [1]")
    (tmp_path / "a_folder").mkdir()
    return tmp_path


@pytest.mark.parametrize("case", BAD_VALUES)
def test_a_bad_value_is_one_clear_error(case, dmil, folder):
    arguments, said = BAD_VALUES[case]
    before = sorted(folder.iterdir())
    done = dmil(*arguments, cwd=folder, code=2)
    judge(done, said)
    assert sorted(folder.iterdir()) == before


def test_a_process_of_its_own_says_the_same(dmil, folder):
    for case in ("a phase that is not there", "zero seeds"):
        arguments, said = BAD_VALUES[case]
        here, there = (run(*arguments, cwd=folder, code=2) for run in (dmil, dmil.process))
        judge(there, said)
        assert there == here


def spoil_route(roadnet, flow):
    flow[3]["route"] = ["E_in", "nowhere"]


def spoil_way(roadnet, flow):
    flow[3]["route"] = ["E_in", "N_out"]


def spoil_phase(roadnet, flow):
    phases = roadnet["intersections"][0]["trafficLight"]["lightphases"]
    phases[1]["availableRoadLinks"] = [0, 44]


def spoil_shape(roadnet, flow):
    del roadnet["roads"][0]["points"]


def spoil_times(roadnet, flow):
    flow[3].update(startTime=-5, endTime=-3)


def spoil_end(roadnet, flow):
    flow[3]["endTime"] = 1e15


def spoil_interval(roadnet, flow):
    flow[3].update(startTime=0, endTime=10, interval=1e-12)


def spoil_speed(roadnet, flow):
    for lane in roadnet["roads"][0]["lanes"]:
        lane["maxSpeed"] = 1e-300


def spoil_lanes(roadnet, flow):
    roadnet["roads"][0]["lanes"] = []


BAD_FILES = {
    "a vehicle after millions of years": (spoil_end, "flow.json", "[3].endTime"),
    "vehicles without number": (spoil_interval, "flow.json", "it stands for 1e+13 vehicles"),
    "a road that takes for ever": (spoil_speed, "roadnet.json", "to drive along it takes"),
    "a road without lanes": (spoil_lanes, "roadnet.json", "list should have at least 1 item"),
    "a route over a road that does not exist": (spoil_route, "flow.json", "'nowhere'"),
    "a phase naming a movement that does not exist": (spoil_phase, "roadnet.json", "44"),
    "JSON of the wrong shape": (spoil_shape, "roadnet.json", "points"),
}


@pytest.mark.parametrize("case", BAD_FILES)
def test_a_bad_file_is_named(case, dmil, city):
    spoil, file, said = BAD_FILES[case]
    folder = city(spoil)
    done = dmil("simulate", "--scenario", f"cityflow:{folder}", code=2)
    judge(done, file, said)


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (spoil_way, "1 cannot be simulated, since the network has no route"),
        (spoil_times, "1 entries end before they begin, or before second 0"),
    ],
)
def test_what_cityflow_drops_is_dropped_and_told(dmil, city, spoil, said):
    done = dmil("simulate", "--scenario", f"cityflow:{city(spoil)}", code=0)
    assert f"Warning: {said}" in " ".join(done.err.split())


def test_a_mark_at_the_beginning_of_a_file_is_skipped(dmil, city):
    folder = city()
    for path in folder.glob("*.json"):
        path.write_text(path.read_text(encoding="utf-8"), encoding="utf-8-sig")
    (folder / "run.toml").write_text(f'scenario = "cityflow:{folder}"', encoding="utf-8-sig")
    assert dmil("simulate", "--config", folder / "run.toml").out


def test_the_unspoilt_files_run(dmil, city):
    done = dmil("simulate", "--scenario", f"cityflow:{city()}", "--json")
    assert done.json["runs"][0]["spawned_veh"] == 200


@pytest.mark.parametrize("length", [0, 400])
def test_a_truncated_file_is_named(length, dmil, city):
    folder = city()
    roadnet = folder / "roadnet.json"
    roadnet.write_text(roadnet.read_text()[:length])
    judge(dmil("simulate", "--scenario", f"cityflow:{folder}", code=2), "roadnet.json")


def test_a_missing_file_is_named(dmil, city):
    folder = city()
    files = ("--roadnet", folder / "roadnet.json", "--flow", folder / "no.json")
    judge(dmil("simulate", *files, code=2), "no.json: there is no such file")


def test_a_policy_for_another_shape_is_refused(dmil, policy):
    done = dmil("evaluate", "--scenario", "grid:1x1", "--policy", policy, "--seeds", 2, code=2)
    judge(done, "policy.npz: a policy for 2 intersections", "trained on 'grid:1x2'")


@pytest.mark.parametrize(
    "key, value, said",
    [
        ("version", 99, "version 99 of the format"),
        ("controller", None, "its header has None for 'controller'"),
        ("options", {"epsilom": 1}, "Did you mean 'epsilon'?"),
        ("format", "zip", "no policy"),
    ],
)
def test_a_policy_from_elsewhere_is_refused(key, value, said, dmil, policy, tmp_path):
    with np.load(policy) as file:
        arrays = dict(file)
    header = json.loads(arrays["header"].tobytes()) | {key: value}
    arrays["header"] = np.frombuffer(json.dumps(header).encode(), np.uint8)
    np.savez(tmp_path / "other.npz", **arrays)
    judge(dmil("evaluate", "--policy", tmp_path / "other.npz", code=2), said)


def test_a_policy_and_another_controller_are_not_one_run(dmil, policy):
    done = dmil("simulate", "--policy", policy, "--controller", "sarsa", code=2)
    judge(done, "controller 'sarsa' beside a policy of 'dual-memory'")
    assert dmil("simulate", "--policy", policy, "--controller", "dual-memory").out


def test_half_a_policy_is_refused(dmil, policy, tmp_path):
    half = tmp_path / "half.npz"
    half.write_bytes(policy.read_bytes()[:800])
    judge(dmil("simulate", "--policy", half, code=2), "half.npz: not a whole policy file")


def test_a_folder_that_holds_another_study_is_left_alone(dmil, tmp_path):
    dmil(*STUDY, "--jobs", 1, "--out", tmp_path / "study")
    before = {path: path.stat().st_mtime_ns for path in sorted((tmp_path / "study").rglob("*"))}
    done = dmil(*STUDY, "--load", 2, "--out", tmp_path / "study", code=2)
    judge(done, "it holds another study, with other load")
    after = {path: path.stat().st_mtime_ns for path in sorted((tmp_path / "study").rglob("*"))}
    assert after == before


def test_an_output_folder_that_cannot_be_written_is_named(dmil, tmp_path):
    folder = tmp_path / "locked"
    folder.mkdir()
    folder.chmod(0o500)
    # The superuser may write everywhere but into the kernel's own folders.
    place = Path("/proc/study") if os.access(folder, os.W_OK) else folder / "study"
    if not place.parent.is_dir():
        pytest.skip("no folder here that cannot be written")
    judge(dmil(*STUDY, "--out", place, code=2), f"{place}: cannot be made")
    judge(
        dmil("train", "--scenario", "grid:1x1", "--no-prior", "--out", place / "p.npz", code=2),
        "cannot be written",
    )


def test_an_error_is_json_too(dmil):
    done = dmil("simulate", "--scenario", "gird:1x1", "--json", code=2)
    assert "no scenario named 'gird:1x1'" in done.json["error"]
    assert done.err.startswith("error: there is no scenario")


@pytest.mark.parametrize("how", [{"DMIL_DEBUG": "1"}, {}])
def test_debugging_shows_where(how, dmil):
    flags = () if how else ("--debug",)
    done = dmil("simulate", "--scenario", "gird:1x1", *flags, code=2, **how)
    assert "Traceback" in done.err
    assert "error: there is no scenario" in done.err
