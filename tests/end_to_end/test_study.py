"""``dmil study paper`` from outside: the contract, and the same bytes on every way there."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import polars as pl
import pytest

from dmil.results import Results
from dmil.studies.paper.summaries import summary

TINY = ("study", "paper", "--grids", "1x1", "--seeds", "2", "--preset", "literal")
MANY = ("study", "paper", "--grids", "1x2", "--seeds", "8", "--preset", "literal", "--no-report")
TABLES = ("runs.parquet", "series.parquet")
CELL = {
    "preset": str,
    "grid": str,
    "reward": str,
    "controller": str,
    "embedding": str,
    "communication": bool,
    "epsilon": float,
    "n": int,
    "w_over_vc_mean": float,
    "w_over_vc_sd": float,
    "vc_mean": float,
    "entries_mean": float,
}


def tables(folder):
    return [(folder / name).read_bytes() for name in TABLES]


@pytest.fixture(scope="module")
def study(dmil, tmp_path_factory):
    """A tiny study, run in this one process, with its JSON."""
    folder = tmp_path_factory.mktemp("studies") / "one"
    done = dmil(*TINY, "--no-report", "--jobs", 1, "--out", folder, "--json")
    return folder, done.json


def test_the_json_keeps_its_contract(study):
    folder, found = study
    assert found.keys() >= {"cells", "claims", "wall_s"}
    assert found["wall_s"] > 0
    assert len(found["cells"]) == 52
    for cell in found["cells"]:
        assert cell.keys() == CELL.keys()
        learns = cell["reward"] is not None
        for name, kind in CELL.items():
            optional = name in ("reward", "embedding", "epsilon") and not learns
            assert cell[name] is None if optional else isinstance(cell[name], kind), name
        assert cell["grid"] == "1x1"
        assert cell["n"] == 2
    assert found["claims"]
    for claim in found["claims"]:
        assert claim["id"]
        assert claim["holds"] in (True, False, None)
        assert claim["evidence"]["verdict"]
    assert found["failed"] == 0
    assert Path(found["out"]) == folder


def test_the_cells_are_those_of_the_results(study):
    folder, found = study
    with Results(folder) as results:
        table = summary(results)
        runs = results.runs()
    assert [cell["w_over_vc_mean"] for cell in found["cells"]] == table["w_over_vc_mean"].to_list()
    chosen = runs.filter(pl.col("controller") == "max-pressure")
    (cell,) = (cell for cell in found["cells"] if cell["controller"] == "max-pressure")
    assert cell["w_over_vc_mean"] == pytest.approx(chosen["w_over_vc"].mean())
    assert cell["vc_mean"] == pytest.approx(chosen["arrived_veh"].mean())


@pytest.mark.slow
def test_ray_gives_the_same_bytes(study, dmil, tmp_path):
    pytest.importorskip("ray")
    folder, _ = study
    on_ray = (*TINY, "--no-report", "--executor", "ray", "--jobs", 2, "--out", tmp_path / "ray")
    patient = {"RAY_gcs_server_request_timeout_seconds": "300"}
    for _ in range(4):
        done = dmil.process(*on_ray, code=None, **patient)
        # Ray gives a node 30 s to come up, come what may. A busy machine needs more.
        if "timed out during startup" not in done.err:
            break
    assert done.code == 0, done.err
    assert tables(tmp_path / "ray") == tables(folder)


def test_a_complete_study_is_reported_again(study, dmil):
    folder, _ = study
    before = tables(folder)
    done = dmil(*TINY, "--out", folder)
    assert "is already complete in the folder, all 2 blocks" in done.err
    assert (folder / "report.html").stat().st_size > 10_000
    assert f"Report: {folder / 'report.html'}" in done.out
    assert "longest-queue-first" in done.out
    assert "Claims, preset literal" in done.out
    assert max(map(len, done.out.split("Claims")[0].splitlines())) <= 80
    assert tables(folder) == before


def test_the_report_can_be_written_again(study, dmil):
    folder, _ = study
    done = dmil("report", folder, "--no-pictures", "--json")
    assert Path(done.json["report"]).is_file()
    assert all(Path(path).is_file() for path in done.json["tables"])


def sessions_processes(session):
    """Processes of a session that are still there."""
    found = []
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = path.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(fields[3]) == session and fields[0] != "Z":
            found.append(int(path.parent.name))
    return found


@pytest.mark.slow
@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGTERM], ids=["Ctrl-C", "terminate"])
def test_an_interrupted_study_goes_on_in_one_process_and_gives_the_same_bytes(
    sent, dmil, tmp_path, uninterrupted
):
    folder = tmp_path / "study"
    process = subprocess.Popen(
        [sys.executable, "-m", "dmil", *MANY, "--jobs", "2", "--out", str(folder)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        env={**os.environ, "NO_COLOR": "1"},
    )
    for line in process.stderr:
        if "blocks, 1" in line:
            break
    process.send_signal(sent)  # to this process only, as `kill` does
    out, err = process.communicate()
    assert process.returncode == 1, err
    assert f"kept in {folder}; repeat the command to continue" in err
    assert "Traceback" not in err
    assert out == ""
    if Path("/proc").is_dir():
        assert sessions_processes(process.pid) == []
    assert not (folder / "runs.parquet").exists()
    assert not (folder / "in-use").exists()

    done = dmil(*MANY, "--jobs", 1, "--out", folder)
    assert "blocks are there already" in done.err
    assert "8 of 8 blocks, 100 %" in done.err
    assert tables(folder) == uninterrupted


@pytest.fixture(scope="module")
def uninterrupted(dmil, tmp_path_factory):
    folder = tmp_path_factory.mktemp("studies") / "whole"
    dmil(*MANY, "--jobs", 1, "--out", folder)
    return tables(folder)


def test_every_setting_can_come_from_a_file(dmil, tmp_path):
    (tmp_path / "small.toml").write_text(
        'presets = ["decaying"]\ngrids = ["1x1"]\nseeds = 5\nhorizon_s = 60\nreport = false\n'
        'rewards = ["entropy"]\nout = "from-file"\njobs = 1\n'
        '[dual_memory]\nshort_capacity = 4\nstaging = "visits"\n'
    )
    done = dmil("study", "paper", "--config", "small.toml", "--seeds", 1, "--json", cwd=tmp_path)
    assert {cell["preset"] for cell in done.json["cells"]} == {"decaying"}
    assert {cell["reward"] for cell in done.json["cells"]} == {"entropy", None}
    with Results(tmp_path / "from-file") as results:
        configuration = results.manifest["configuration"]
        runs = results.runs()
    assert configuration["seeds"] == 1  # the command line wins
    assert configuration["dual_memory"]["short_capacity"] == 4
    assert configuration["dual_memory"]["staging"] == "visits"
    assert runs["horizon_s"].unique().to_list() == [60]
