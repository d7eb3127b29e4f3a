"""The folder of a study: kept, continued, refused."""

import fcntl
import json

import polars as pl
import pytest

from dmil.errors import OutputError
from dmil.experiments.store import StudyStore
from dmil.parallel import LocalExecutor
from dmil.results import Results
from dmil.studies import PaperStudy, PaperStudySettings, run_study
from dmil.studies.paper.plan import blocks
from dmil.studies.paper.study import run_block
from dmil.studies.paper.tables import paper_tables

SETTINGS = PaperStudySettings(
    presets=("literal", "decaying"), grids=("1x1",), seeds=2, horizon_s=60, rewards=("entropy",)
)
TABLES = ("episodes.parquet", "runs.parquet", "series.parquet")
FILES = (*TABLES, "lookups.parquet")
"""All but the timings: the same bytes whatever happens."""


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("studies") / "whole"
    run_study(PaperStudy(SETTINGS), folder, executor=LocalExecutor(1))
    return folder


class Interrupted:
    """An executor that is interrupted after some items."""

    def __init__(self, after):
        self.after = after

    def map(self, function, items):
        for item in items[: self.after]:
            yield function(item)
        raise KeyboardInterrupt


def test_a_finished_study_holds_results_and_nothing_half_done(whole):
    assert {path.name for path in whole.iterdir()} == {
        *FILES,
        "timings.parquet",
        "manifest.json",
        "study.json",
    }
    manifest = json.loads((whole / "manifest.json").read_text())
    assert manifest["configuration"]["presets"]["decaying"]["epsilon_decay"] == 0.95
    assert manifest["wall_s"] > 0


def test_an_interrupted_study_continues_and_gives_the_same_bytes(whole, tmp_path):
    folder = tmp_path / "study"
    with pytest.raises(KeyboardInterrupt):
        run_study(PaperStudy(SETTINGS), folder, executor=Interrupted(after=3))
    assert not (folder / "manifest.json").exists()
    seen = []
    run_study(
        PaperStudy(SETTINGS),
        folder,
        executor=LocalExecutor(1),
        progress=lambda *each: seen.append(each),
    )
    assert seen == [(3, 4), (4, 4)]
    for name in FILES:
        assert (folder / name).read_bytes() == (whole / name).read_bytes()


def test_two_workers_give_the_bytes_of_one(whole, tmp_path):
    run_study(PaperStudy(SETTINGS), tmp_path / "two", executor=LocalExecutor(2))
    for name in FILES:
        assert (tmp_path / "two" / name).read_bytes() == (whole / name).read_bytes()


def test_a_complete_study_is_left_as_it_is(whole):
    before = (whole / "manifest.json").stat().st_mtime_ns
    run_study(PaperStudy(SETTINGS), whole, executor=Interrupted(after=0))
    assert (whole / "manifest.json").stat().st_mtime_ns == before
    assert {path.name for path in whole.iterdir()} == {
        *FILES,
        "timings.parquet",
        "manifest.json",
        "study.json",
    }


def test_a_block_without_its_series_does_not_count(tmp_path):
    plan = blocks(SETTINGS)
    with StudyStore(tmp_path / "study", {"study": "x"}) as store:
        store.keep(run_block(SETTINGS, plan[0]))
        store.flush()
        assert store.left(plan) == plan[1:]
        for path in (tmp_path / "study" / "parts").glob("runs-*"):
            path.unlink()
        assert store.left(plan) == plan


def test_a_folder_that_cannot_hold_the_study_is_refused(whole, tmp_path):
    (tmp_path / "file").write_text("")
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "thesis.tex").write_text("")
    for folder, found in (
        (tmp_path / "file", "it is a file"),
        (tmp_path / "full", "it holds other files"),
        (whole, "another study, with other seeds"),
    ):
        with pytest.raises(OutputError, match=found):
            run_study(PaperStudy(SETTINGS.model_copy(update={"seeds": 3})), folder)


def test_a_folder_whose_name_looks_like_a_pattern_continues(whole, tmp_path):
    folder = tmp_path / "study [b]*"
    with pytest.raises(KeyboardInterrupt):
        run_study(PaperStudy(SETTINGS), folder, executor=Interrupted(after=3))
    run_study(PaperStudy(SETTINGS), folder, executor=LocalExecutor(1))
    for name in FILES:
        assert (folder / name).read_bytes() == (whole / name).read_bytes()


def test_a_study_in_use_is_refused_and_a_dead_lock_is_not(tmp_path):
    folder = tmp_path / "study"
    with (
        StudyStore(folder, {"study": "x"}),
        pytest.raises(OutputError, match="another process is at work"),
        StudyStore(folder, {"study": "x"}),
    ):
        pass
    assert not (folder / "in-use").exists()
    (folder / "in-use").write_text("left by a process that was killed")
    with StudyStore(folder, {"study": "x"}):
        pass
    assert not (folder / "in-use").exists()


def test_a_lock_on_a_file_that_its_owner_has_just_removed_is_none(tmp_path, monkeypatch):
    folder = tmp_path / "study"
    lock = fcntl.flock

    def late(file, operation):
        (folder / "in-use").unlink()
        lock(file, operation)

    monkeypatch.setattr(fcntl, "flock", late)
    with pytest.raises(OutputError, match="at work"), StudyStore(folder, {"study": "x"}):
        pass


def test_the_tables_hold_one_row_per_run_and_decision(whole):
    episodes, runs, series = (pl.read_parquet(whole / name) for name in TABLES)
    assert episodes.is_empty()  # the paper's training is one run
    assert runs.height * 7 == series.height
    assert runs["status"].unique().to_list() == ["ok"]


def test_a_study_with_other_epsilons_is_analysed_as_it_was_run(tmp_path):
    settings = PaperStudySettings(
        presets=("literal",),
        grids=("1x2",),
        seeds=5,
        horizon_s=60,
        rewards=("default", "entropy"),
        sarsa={"epsilon": 0.3},
        dual_memory={"epsilon": 0.2},
    )
    run_study(PaperStudy(settings), tmp_path / "study", executor=LocalExecutor(1))
    with Results(tmp_path / "study") as results:
        tables = paper_tables(results)
    ours = tables.paper.filter(pl.col("reward") == "entropy").drop_nulls("mean")
    assert set(ours["column"]) >= {"No Memory", "Simple", "Complex"}
    judged = tables.claims.filter(pl.col("id") == "memory-beats-sarsa")
    assert set(judged["outcome"]) <= {"holds", "does not hold", "depends", "not shown"}
    assert judged["evidence"].list.len().min() > 0
