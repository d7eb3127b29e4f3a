import numpy as np
import polars as pl
import pytest

from dmil.errors import InputError
from dmil.results import Results
from dmil.studies.paper.cells import cells_of
from dmil.studies.paper.published import TABLE_II, Reading, intersections_of, scenario_label
from dmil.studies.paper.summaries import (
    curves,
    paper_table,
    sensitivity,
    summary,
)
from dmil.studies.paper.tables import (
    cells_reproduced,
    complex_readings,
    exchange_table,
    memory_table,
)


@pytest.fixture
def study(make_study):
    with Results(make_study(presets=("literal", "matched"), scenarios=("grid:3x3",))) as results:
        yield results


def test_summary_has_one_row_per_cell_and_the_plain_mean(study):
    table = summary(study)
    assert table.height == 2 * 52
    expected = study.query(
        "select avg(w_over_vc), stddev(w_over_vc), avg(arrived_veh) from runs where preset ="
        " 'literal' and controller = 'dual-memory' and embedding = 'simple' and reward = 'default'"
        " and communication"
    ).row(0)
    (row,) = table.filter(
        (pl.col("preset") == "literal")
        & (pl.col("controller") == "dual-memory")
        & (pl.col("embedding") == "simple")
        & (pl.col("reward") == "default")
        & pl.col("communication")
    ).iter_rows(named=True)
    found = row["w_over_vc_mean"], row["w_over_vc_sd"], row["vc_mean"]
    assert found == pytest.approx(expected)
    assert row["w_over_vc_low"] < row["w_over_vc_mean"] < row["w_over_vc_high"]
    assert row["n"] == 8


def test_differences_to_the_baselines_are_paired(study):
    table = summary(study)
    row = table.filter(pl.col("controller") == "fixed-cycle").row(0, named=True)
    # The made-up means are .07 against .047; the shared luck of a seed cancels.
    assert row["vs_max_pressure_pct"] == pytest.approx(100 * (0.07 / 0.047 - 1), abs=5)
    assert row["vs_max_pressure_high_pct"] - row["vs_max_pressure_low_pct"] < 12
    itself = table.filter(pl.col("controller") == "max-pressure")
    assert itself["vs_max_pressure_pct"].to_list() == [0.0, 0.0]
    assert (itself["vs_longest_queue_low_pct"] > 0).all()


def test_the_papers_table_stands_beside_ours(study):
    table = paper_table(study)
    row = table.filter(
        (pl.col("preset") == "literal")
        & (pl.col("reward") == "entropy")
        & (pl.col("column") == "No Memory")
    ).row(0, named=True)
    assert (row["paper_mean"], row["paper_spread"]) == (0.10, 0.02)
    assert row["mean"] == pytest.approx(0.1, rel=0.15) and row["n"] == 8
    matched = table.filter(
        (pl.col("preset") == "matched")
        & (pl.col("reward") == "entropy")
        & (pl.col("column") == "No Memory")
    ).row(0, named=True)
    assert matched["mean"] == pytest.approx(0.8 * row["mean"], rel=0.05)
    baseline = table.filter(pl.col("column") == "max-pressure").row(0, named=True)
    assert baseline["paper_mean"] is None and baseline["reward"] is None


def test_the_papers_numbers_are_those_printed():
    printed = {(v.scenario, v.reward, v.column): (v.mean, v.spread) for v in TABLE_II}
    assert len(printed) == len(TABLE_II) == 33
    assert printed["grid:5x5", "default", "Complex + communication"] == (0.24, 0.04)
    assert printed["grid:5x5", "entropy", "Simple"] == (0.05, 0.004)
    assert printed["grid:1x1", "default", "Complex"] == (0.29, 0.1)
    assert sum(v.mean for v in TABLE_II) == pytest.approx(4.53)


def test_no_memory_depends_on_the_preset():
    assert Reading().architecture("No Memory", "literal").embedding == "exact"
    assert Reading().architecture("No Memory", "matched").embedding == "simple"
    assert Reading().architecture("Complex + communication", "matched").communication


def test_sensitivity_compares_presets_on_the_same_seeds(study):
    table = sensitivity(study)
    assert table.height == 3 * 4 * 2
    row = table.filter(
        (pl.col("preset") == "matched")
        & (pl.col("reward") == "diffusion")
        & (pl.col("column") == "No Memory")
    ).row(0, named=True)
    assert row["vs_first_preset_pct"] == pytest.approx(-20, abs=4)
    assert row["vs_first_preset_high_pct"] < 0


def test_curves_are_means_over_seeds(study):
    table = curves(study, "arrived_veh", "matched", "grid:3x3")
    assert table.height == 55 * 31
    expected = study.query(
        "select time_s, avg(arrived_veh) as mean from series where preset = 'matched' and"
        " controller = 'random' group by 1 order by 1"
    )
    found = table.filter(pl.col("controller") == "random").sort("time_s")
    assert np.allclose(found["mean"], expected["mean"])
    assert (found["low"] <= found["mean"]).all()


def test_the_slope_of_memory_is_found(study):
    cells = cells_of(study)
    exact = cells.find(
        "literal", "grid:3x3", "entropy", Reading().architecture("No Memory", "literal")
    )
    assert np.allclose(cells.measures["entries_per_decision"][:, exact], 0.9)
    dual = cells.find(
        "literal", "grid:3x3", "entropy", Reading().architecture("Complex", "literal")
    )
    assert np.allclose(cells.measures["entries_per_decision"][:, dual], 0.1)


def test_what_short_term_memory_adds_is_told_apart(study):
    cells = cells_of(study)
    number = cells.find(
        "literal", "grid:3x3", "entropy", Reading().architecture("Complex", "literal")
    )
    slopes = {
        name: cells.measures[f"{name}_per_decision"][:, number]
        for name in ("entries", "long_entries", "short_entries")
    }
    assert np.allclose(slopes["long_entries"] + slopes["short_entries"], slopes["entries"])
    table = memory_table(study)
    rows = table.filter(
        pl.col("preset") == "matched",
        pl.col("scenario") == "grid:3x3",
        pl.col("reward") == "entropy",
    )
    found = {row["agent"]: row for row in rows.iter_rows(named=True)}
    assert list(found) == [
        "SARSA exact",
        "No Memory",
        "Simple",
        "Complex",
        "Complex + communication",
    ]
    # 20 rows at the start, .1 more per decision, 14 of them in short-term memory at the end.
    row = found["Complex"]
    assert (row["first_long"], row["long"], row["entries"]) == (20, 9, 23)
    assert row["long_slope"] + row["short_slope"] == pytest.approx(0.1)
    assert (row["shared"], row["per_agent_total"]) == (9 * 23, 9 * 23)
    assert found["Complex + communication"]["shared"] == 23
    # Under literal "No Memory" is exact SARSA, which has one row.
    assert "No Memory" not in table.filter(pl.col("preset") == "literal")["agent"].to_list()


def test_readings_of_complex_stand_beside_each_other_and_the_paper(study):
    table = complex_readings(study)
    row = table.filter(
        pl.col("preset") == "matched",
        pl.col("reward") == "diffusion",
        pl.col("column") == "Complex",
        pl.col("reading") == "complex-scaled",
    ).row(0, named=True)
    assert row["vs_first_reading_pct"] == pytest.approx(100 * (0.75 / 0.7 - 1), abs=3)
    assert (row["paper_mean"], row["within"]) == (0.08, abs(row["mean"] - 0.08) <= 0.01)
    whole = paper_table(study)
    counted = cells_reproduced(whole, table)
    assert counted.rows()[0][:2] == ("literal", "complex")
    for row in counted.iter_rows(named=True):
        assert (row["cells"], row["complex_cells"]) == (12, 6)
        own = whole.filter(pl.col("preset") == row["preset"])
        if row["reading"] == "complex":
            assert row["within"] == own["within"].sum()
        assert 0 <= row["complex_within"] <= row["within"] <= 12


def test_variants_stand_beside_the_papers_rule(study):
    rows = exchange_table(study).filter(pl.col("preset") == "matched").rows(named=True)
    assert [row["variant"] for row in rows] == [
        "communication=false",
        "communication=true",
        "sent=both",
    ]
    assert [row["messages"] for row in rows] == [0, 100, 100]
    assert rows[1]["vs_rule_pct"] == 0
    # Without communication they wait longer in this made-up study.
    assert rows[0]["vs_rule_low_pct"] > 0
    assert rows[2]["vs_rule_pct"] == pytest.approx(0, abs=3)
    # They are longer runs, and no cells of the paper's study.
    assert summary(study)["variant"].null_count() == summary(study).height


def test_a_baseline_of_another_preset_stands_in(study, make_study):
    folder = make_study("some", presets=("literal", "matched"), scenarios=("grid:3x3",))
    for name in ("runs", "series"):
        table = pl.read_parquet(folder / f"{name}.parquet")
        kept = (pl.col("preset") == "literal") | pl.col("reward").is_not_null()
        table.filter(kept).write_parquet(folder / f"{name}.parquet")
    with Results(folder) as results:
        table = summary(results)
        lines = curves(results, "arrived_veh", "matched", "grid:3x3")
    assert table.filter(pl.col("preset") == "matched")["vs_max_pressure_pct"].null_count() == 0
    assert "max-pressure" in lines["controller"]


def test_a_study_without_a_successful_run_says_why(make_study):
    folder = make_study(scenarios=("grid:1x1",), seeds=1)
    runs = pl.read_parquet(folder / "runs.parquet").with_columns(status=pl.lit("no road"))
    runs.write_parquet(folder / "runs.parquet")
    with Results(folder) as results, pytest.raises(InputError, match="first failed with: no road"):
        summary(results)


def test_two_horizons_in_one_folder_are_not_mixed(make_study):
    folder = make_study(scenarios=("grid:1x1",), seeds=1)
    runs = pl.read_parquet(folder / "runs.parquet")
    longer = runs.with_columns(horizon_s=pl.lit(3600, pl.Int64))
    pl.concat([runs, longer]).write_parquet(folder / "runs.parquet")
    with Results(folder) as results, pytest.raises(InputError, match="share cell and seed"):
        summary(results)


def test_names_of_scenarios():
    assert intersections_of("grid:3x4") == 12 and intersections_of("cityflow:jinan") is None
    assert scenario_label("grid:10x2") == "10×2" and scenario_label("sumo:a") == "sumo:a"
