"""Tables of the study of memories, from a made-up one with known answers."""

import math

import numpy as np
import polars as pl
import pytest

from dmil.errors import InputError
from dmil.reports.contenders import controller_name
from dmil.results import Results
from dmil.studies.memories.names import cell_label
from dmil.studies.memories.tables import memories_tables
from tests.unit.made_up_memories import (
    ABLATIONS,
    CELLS,
    CONTROLLERS,
    DIVERGED,
    EPISODES,
    write_made_up_study,
)

FEW = ("longest-queue-first", "max-pressure", "foresight", "factored", "lookahead")


@pytest.fixture
def tables(made_up_memories):
    return made_up_memories


def row_of(table, **values):
    found = table.filter(*(pl.col(name).eq_missing(value) for name, value in values.items()))
    assert found.height == 1, found
    return found.row(0, named=True)


def test_cells_stand_by_size_and_load_and_cities_last(tables):
    labels = [cell_label(cell) for cell in tables.runs.cells]
    assert labels == [
        *("1×1 ×1", "1×1 ×3", "1×1 ×7", "3×3 ×1", "3×3 ×4", "5×5 ×1", "5×5 ×3", "5×5 ×3.6"),
        *("5×5 time-varying", "5×5 unequal", "Jinan", "Jinan 2000", "Hangzhou"),
    ]
    assert list(tables.runs.controllers) == list(CONTROLLERS)
    assert tables.runs.ablations == ABLATIONS


def test_names_are_those_a_reader_knows():
    assert controller_name("longest-queue-first,approaching=true") == "longest queue + approaching"
    assert controller_name("sarsa,embedding=complex,epsilon=0.05") == (
        "SARSA, complex classes, ε .05"
    )
    assert controller_name("mine:Controller") == "mine:Controller"


def test_differences_are_those_that_were_made_up(tables):
    for cell in tables.runs.cells:
        row = row_of(tables.standing, cell=cell, controller="factored")
        assert row["n"] == 6
        assert row["max_pressure_pct"] == pytest.approx(-18, abs=2)
        assert row["max_pressure_low"] < row["max_pressure_pct"] < row["max_pressure_high"] < -14
        assert row["approaching_pct"] == pytest.approx(100 * (0.82 / 0.89 - 1), abs=2.5)
        assert row["max_pressure_better"] == 1.0
        assert row["low"] <= row["iqm"] <= row["high"]
    itself = row_of(tables.standing, cell="grid:3x3", controller="max-pressure")
    assert itself["max_pressure_pct"] == 0.0 and itself["max_pressure_p"] is None


def test_the_corrected_p_value_counts_the_tests_of_the_cell(tables):
    # Six seeds that all differ to one side: 2 / 2^6, times the number of others at most.
    row = row_of(tables.standing, cell="grid:3x3", controller="factored")
    others = len(CONTROLLERS) - 2  # itself, and foresight, which is not here
    assert row["max_pressure_p"] == pytest.approx(min(2 / 2**6 * others, 1.0))


def test_over_all_cells_the_ratio_is_the_made_up_one(tables):
    for controller, (ratio, _, _) in CONTROLLERS.items():
        row = row_of(tables.overall, controller=controller)
        assert row["max_pressure_ratio"] == pytest.approx(ratio, rel=0.02)
        assert row["max_pressure_low"] <= row["max_pressure_ratio"] <= row["max_pressure_high"]
    assert row_of(tables.overall, controller="foresight")["cells"] == 3
    assert row_of(tables.overall, controller="vdn")["n"] == 6 * len(CELLS) - 1
    assert row_of(tables.overall, controller="max-pressure")["max_pressure_better"] is None


def test_costs_are_per_intersection_and_failures_are_counted(tables):
    name, scenario, load, _ = DIVERGED
    row = row_of(tables.cost, cell=f"{scenario}*{load:g}", controller=name)
    assert (row["planned"], row["failed"], row["diverged"]) == (6, 1, 1)
    assert row["bytes_per_intersection"] == row["bytes_largest"] == CONTROLLERS[name][1]
    assert row["us_per_decision"] == pytest.approx(100 * (1 + 1.35) / 360)
    assert (row["overtook"], row["decisions_until_better"]) == (0.0, None)
    ours = row_of(tables.cost, cell="grid:5x5", controller="factored")
    assert (ours["overtook"], ours["decisions_until_better"]) == (1.0, 0.0)
    rule = row_of(tables.cost, cell="grid:5x5", controller="random")
    assert rule["overtook"] is None and not rule["learns"]
    assert tables.failures["status"].to_list() == ["DivergedError: values are not finite at 70 s"]


def test_hit_rates_sum_to_one(tables):
    row = row_of(tables.hit_rates, cell="grid:1x1", controller="factored", source="prior")
    assert row["share"] == pytest.approx(0.1)
    sums = tables.hit_rates.group_by("cell", "controller").agg(pl.col("share").sum())
    assert np.allclose(sums["share"], 1.0)


def test_learning_curves_end_with_the_test(tables):
    curve = tables.learning.filter(
        (pl.col("cell") == "grid:5x5") & (pl.col("controller") == "mfec")
    )
    assert curve["run"].to_list() == list(range(1, EPISODES + 2))
    assert curve["test"].to_list() == [False] * EPISODES + [True]
    ratio = (curve["mean"] / curve["base"]).to_list()
    assert ratio == pytest.approx([1.9 * 3, 1.9 * 2, 1.9 * 5 / 3, 1.9 * 1.5, 1.9], rel=0.05)
    untrained = tables.learning.filter(pl.col("controller") == "factored")
    assert untrained["run"].unique().to_list() == [1]


def test_memory_goes_from_training_into_the_test(tables):
    course = tables.memory.filter((pl.col("cell") == "grid:5x5") & (pl.col("controller") == "mfec"))
    assert course["hour"].min() == 1.0 and course["hour"].max() == EPISODES + 1.0
    assert course.sort("hour")["bytes"][-1] == pytest.approx(1_200_000)


def test_a_profile_rises_where_the_controller_stands_and_diverged_runs_never_reach_it(tables):
    profile = tables.profiles.filter(pl.col("controller") == "factored").sort("ratio")
    assert profile.filter(pl.col("ratio") < 0.8)["share"].max() == 0.0
    assert profile.filter(pl.col("ratio") > 0.84)["share"].min() == 1.0
    last = tables.profiles.filter(pl.col("controller") == "vdn").sort("ratio")["share"][-1]
    assert last == pytest.approx(1 - 1 / (6 * len(CELLS)))


def test_an_ablation_is_compared_with_factored_memory(tables):
    everywhere = row_of(tables.ablation, controller=ABLATIONS[0], cell=None)
    assert everywhere["pct"] == pytest.approx(100 * (0.87 / 0.82 - 1), abs=1)
    assert tables.ablation.height == 1 + len(CELLS)


def test_bars_are_judged_by_their_rules(tables):
    holds = dict(tables.claims.select("id", "holds").iter_rows())
    assert {name for name, value in holds.items() if value} >= {
        "below-max-pressure",
        "below-longest-queue",
        "below-approaching",
        "nowhere-above-approaching",
        "fifteen-percent",
        "ten-kilobytes",
        "rivals-above-max-pressure",  # a rival that diverged is no counterexample
        "prioritised-helps",
    }
    assert holds["team-value-helps"] is False  # one of its runs diverged
    assert row_of(tables.claims, id="team-value-helps")["verdict"].startswith("1 run failed")
    assert holds["hindsight-helps"] is None
    assert row_of(tables.claims, id="hindsight-helps")["verdict"] == "not run"
    evidence = row_of(tables.claims, id="below-max-pressure")["evidence"]
    assert len(evidence) == 10 and {one["cell"] for one in evidence}.isdisjoint({"grid:1x1"})
    known = row_of(tables.standing, cell="grid:5x5", controller="factored")
    chosen = next(one for one in evidence if one["cell"] == "grid:5x5")
    assert chosen["value"] == known["max_pressure_pct"]


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (1.02, {"below-max-pressure": False, "nowhere-above-max-pressure": False}),
        (0.9, {"fifteen-percent": False, "below-max-pressure": True}),
    ],
)
def test_bars_that_are_not_met_are_called_so(tmp_path, change, expected):
    made = write_made_up_study(tmp_path / "other", controllers=FEW)
    runs = pl.read_parquet(made / "runs.parquet")
    wait = pl.col("wait_per_spawned_s")
    base = (
        wait.filter(pl.col("controller") == "max-pressure").first().over("scenario", "load", "seed")
    )
    runs.with_columns(
        wait_per_spawned_s=pl.when(pl.col("controller") == "factored")
        .then(base * change)
        .otherwise(wait)
    ).write_parquet(made / "runs.parquet")
    with Results(made) as results:
        holds = dict(memories_tables(results).claims.select("id", "holds").iter_rows())
    assert {name: holds[name] for name in expected} == expected


def test_cells_that_were_not_run_leave_a_bar_open(tmp_path):
    made = write_made_up_study(tmp_path / "part", controllers=FEW)
    runs = pl.read_parquet(made / "runs.parquet")
    runs.filter(~pl.col("scenario").str.starts_with("cityflow")).write_parquet(
        made / "runs.parquet"
    )
    with Results(made) as results:
        found = memories_tables(results).claims
    row = row_of(found, id="below-max-pressure")
    assert row["holds"] is None and row["verdict"] == "holds in all 7 run, 2 cells were not"
    assert row["lacking"] == ["cityflow:*jinan*", "cityflow:*hangzhou*"]
    assert row_of(found, id="fifteen-percent")["holds"] is True


def test_too_few_seeds_give_no_verdict(tmp_path):
    with Results(write_made_up_study(tmp_path / "few", seeds=2, controllers=FEW)) as results:
        found = memories_tables(results)
    assert set(found.claims["verdict"]) == {"too few seeds", "not run"}
    assert math.isfinite(found.overall["max_pressure_low"].drop_nulls().min())


def test_a_study_without_a_successful_run_says_so(tmp_path):
    made = write_made_up_study(tmp_path / "none", seeds=1, controllers=FEW)
    runs = pl.read_parquet(made / "runs.parquet").with_columns(status=pl.lit("no road"))
    runs.write_parquet(made / "runs.parquet")
    with Results(made) as results, pytest.raises(InputError, match=r"no successful run.*no road"):
        memories_tables(results)
