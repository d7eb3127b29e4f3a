"""``dmil study ablation`` from outside: small, and the same bytes on every way there."""

import polars as pl
import pytest

from dmil.results import Results

TINY = ("study", "ablation", "--cells", "grid:1x1,grid:1x2*2", "--seeds", "2", "--steps", "300")
TINY += ("--controllers", "combined,factored", "--parts", "learning,age,guard")


@pytest.fixture(scope="module")
def ran(dmil, tmp_path_factory):
    """A tiny ablation, run in two processes, with its report."""
    folder = tmp_path_factory.mktemp("ablation") / "one"
    return folder, dmil(*TINY, "--jobs", 2, "--out", folder)


def test_every_variant_meets_the_same_vehicles(ran):
    with Results(ran[0]) as results:
        runs = results.runs()
    assert runs["status"].unique().to_list() == ["ok"]
    assert runs.height == 2 * 2 * 2 * 4
    spawned = runs.group_by("scenario", "seed").agg(pl.col("spawned_veh").n_unique())
    assert spawned["spawned_veh"].unique().to_list() == [1]
    assert runs["locked"].null_count() == 0


def test_where_no_lanes_are_shared_the_guard_changes_nothing(ran):
    rows = pl.read_csv(ran[0] / "tables" / "differences.csv").filter(pl.col("part") == "guard")
    assert rows.height == 4
    assert rows["alike"].to_list() == [1.0] * 4


def test_terminal_and_report_say_what_came_out(ran):
    folder, done = ran
    assert max(map(len, done.out.splitlines()[:-2])) <= 80
    for word in ("1×2 ×2: delay in s, 2 seeds", "as it is", "without learning", "with long waits"):
        assert word in done.out
    assert (folder / "figures" / "parts.svg").is_file()
    assert (folder / "tables" / "differences.tex").is_file()
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert "What each part of a controller is worth" in page


def test_one_process_gives_the_same_bytes(ran, dmil, tmp_path):
    done = dmil(*TINY, "--jobs", 1, "--no-report", "--json", "--out", tmp_path / "other")
    again, first = (folder / "runs.parquet" for folder in (tmp_path / "other", ran[0]))
    assert again.read_bytes() == first.read_bytes()
    assert done.json["runs"] == 32 and done.json["failed"] == 0
    assert {row["part"] for row in done.json["differences"]} == {"learning", "age", "guard"}


def test_the_same_command_again_has_nothing_to_run(ran, dmil):
    done = dmil(*TINY, "--no-report", "--json", "--out", ran[0])
    assert done.json["runs"] == 32
    assert "already complete" in done.err


def test_a_name_that_is_wrong_ends_with_2(dmil, tmp_path):
    done = dmil("study", "ablation", "--parts", "ages", "--out", tmp_path / "x", code=2)
    assert "there is no part named 'ages'" in done.err
    assert not (tmp_path / "x").exists()


@pytest.mark.slow
def test_roads_of_sumo_run_in_sumo(dmil, tmp_path):
    pytest.importorskip("libsumo", reason="needs the extra sumo")
    given = ("--cells", "resco/cologne1", "--controllers", "max-pressure", "--parts", "guard")
    done = dmil(
        *("study", "ablation", *given, "--seeds", 1, "--steps", 300, "--jobs", 1),
        *("--no-report", "--json", "--out", tmp_path / "roads"),
    )
    assert done.json["runs"] == 2
    with Results(tmp_path / "roads") as results:
        runs = results.runs()
    assert runs["simulator"].unique().to_list() == ["sumo"]
    assert set(runs["controller"]) == {"max-pressure", "max-pressure,guard=false"}
