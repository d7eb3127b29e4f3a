"""One block of a study: rows that say what happened, failures included."""

import pytest

from dmil.studies.paper import study as room
from dmil.studies.paper.plan import VARIANTS, Block, architectures
from dmil.studies.paper.settings import PaperStudySettings
from dmil.studies.paper.study import run_block

SETTINGS = PaperStudySettings(grids=("1x1",), seeds=1, horizon_s=60, rewards=("entropy",))
BLOCK = Block("literal", "grid:1x1", 0)


@pytest.fixture(scope="module")
def result():
    return run_block(SETTINGS, BLOCK)


def test_there_is_one_row_per_architecture_and_one_per_decision(result):
    plan = architectures(SETTINGS)
    assert len(result.runs) == len(plan)
    # 6 decisions and the horizon.
    assert len(result.series) == 7 * len(plan)
    assert {row["status"] for row in result.runs} == {"ok"}


def test_all_architectures_meet_the_same_vehicles(result):
    assert len({row["spawned_veh"] for row in result.runs}) == 1


def test_the_series_ends_where_the_run_does(result):
    run = next(row for row in result.runs if row["controller"] == "dual-memory")
    names = ("embedding", "communication", "reward", "epsilon")
    rows = [
        row
        for row in result.series
        if row["controller"] == "dual-memory" and all(row[n] == run[n] for n in names)
    ]
    assert [row["time_s"] for row in rows] == [0, 10, 20, 30, 40, 50, 60]
    assert rows[0]["arrived_veh"] == rows[0]["queue_veh"] == 0
    assert rows[-1]["arrived_veh"] == run["arrived_veh"]
    assert rows[-1]["msize_per_agent"] == run["msize_per_agent"]
    assert run["msize_per_agent"] == (
        3 * rows[-1]["long_term_entries"] + 8 * rows[-1]["short_term_entries"]
    )


def test_the_same_block_gives_the_same_rows(result):
    again = run_block(SETTINGS, BLOCK)
    assert again.runs == result.runs
    assert again.series == result.series


def test_a_run_that_fails_is_a_row_that_says_so(monkeypatch, result):
    make = room.make_controller

    def broken(name, *arguments, **keywords):
        if name == "max-pressure":
            raise ZeroDivisionError("no pressure today")
        return make(name, *arguments, **keywords)

    monkeypatch.setattr(room, "make_controller", broken)
    rows = run_block(SETTINGS, BLOCK).runs
    failed = [row for row in rows if row["status"] != "ok"]
    assert [row["status"] for row in failed] == ["ZeroDivisionError: no pressure today"]
    assert "w_over_vc" not in failed[0]
    assert len(rows) == len(result.runs)


def test_variants_run_longer_from_the_same_start():
    settings = PaperStudySettings(
        grids=("1x2",),
        presets=("literal",),
        seeds=1,
        horizon_s=60,
        rewards=("entropy",),
        variant_factor=3,
    )
    result = run_block(settings, Block("literal", "grid:1x2", 0))
    found = {row["variant"]: row for row in result.runs if row["variant"]}
    assert tuple(found) == VARIANTS
    assert {row["status"] for row in found.values()} == {"ok"}
    assert {row["horizon_s"] for row in found.values()} == {180}
    assert {row["training_s"] for row in found.values()} == {60}
    assert len({row["spawned_veh"] for row in found.values()}) == 1
    assert found["communication=false"]["messages"] == 0
    # Two agents send and are answered, once in 180 s.
    assert found["communication=true"]["messages"] == 4
    assert not any(row["variant"] for row in result.series)
