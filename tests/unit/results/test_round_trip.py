import json
import shutil

import polars as pl
import pytest

from dmil.errors import InputError, OutputError
from dmil.results import (
    RUNS,
    RUNS_SCHEMA,
    SERIES_SCHEMA,
    Results,
    read_manifest,
    schema_markdown,
    write_manifest,
    write_results,
)


@pytest.fixture(scope="module")
def original(make_study):
    cells = [c for c in make_study.cells() if c["reward"] in ("entropy", None)]
    return make_study(seeds=3, scenarios=("grid:3x3",), cells=cells)


@pytest.fixture
def study(original, tmp_path_factory):
    """A copy of one's own."""
    return shutil.copytree(original, tmp_path_factory.mktemp("copy") / "study")


def test_what_is_written_is_read(study):
    with Results(study) as results:
        runs, series = results.runs(), results.series()
    assert dict(runs.schema) == RUNS_SCHEMA
    assert dict(series.schema) == SERIES_SCHEMA
    assert runs.height == 3 * 23 and series.height == 3 * 23 * 31
    first = runs.filter((pl.col("controller") == "max-pressure") & (pl.col("seed") == 0))
    assert first["reward"].to_list() == [None] and first["communication"].to_list() == [False]


def test_equal_rows_give_equal_bytes_in_any_order(study, tmp_path):
    with Results(study) as results:
        runs, series = results.runs(), results.series()
    shuffled = runs.sample(fraction=1.0, shuffle=True, seed=1), series.reverse()
    write_results(tmp_path / "again", *shuffled)
    for name in ("runs.parquet", "series.parquet"):
        assert (tmp_path / "again" / name).read_bytes() == (study / name).read_bytes()


def test_a_changed_row_changes_the_bytes(study, tmp_path):
    with Results(study) as results:
        runs, series = results.runs(), results.series()
    write_results(tmp_path / "other", runs.with_columns(arrived_veh=pl.lit(1)), series)
    assert (tmp_path / "other/runs.parquet").read_bytes() != (study / "runs.parquet").read_bytes()


def test_sql_sees_runs_and_series(study):
    with Results(study) as results:
        table = results.query(
            "select controller, count(*) as n from runs join series using (preset, scenario, seed,"
            " controller) where controller = 'random' group by 1"
        )
    assert table.rows() == [("random", 93)]


@pytest.mark.parametrize("sql", ["selct 1", "select nothing from runs"])
def test_wrong_sql_is_the_users_to_mend(study, sql):
    with Results(study) as results, pytest.raises(InputError):
        results.query(sql)


def test_only_whole_files_appear(study, tmp_path):
    assert {path.name for path in study.iterdir()} == {
        "episodes.parquet",
        "lookups.parquet",
        "runs.parquet",
        "series.parquet",
        "timings.parquet",
        "manifest.json",
    }
    bad = pl.DataFrame({"study": ["x"]})
    with pytest.raises(OutputError, match="missing columns"):
        write_results(tmp_path / "bad", bad, bad)
    assert not (tmp_path / "bad").exists()


def _runs(study):
    with Results(study) as results:
        return results.runs(), results.series()


def test_two_rows_of_one_run_are_refused(study, tmp_path):
    runs, series = _runs(study)
    with pytest.raises(OutputError, match="2 rows share their identity"):
        write_results(tmp_path / "twice", pl.concat([runs, runs.head(1)]), series)


def test_a_missing_seed_and_a_wrong_type_are_refused(study, tmp_path):
    runs, series = _runs(study)
    without = runs.with_columns(seed=pl.lit(None, pl.Int64))
    with pytest.raises(OutputError, match=r"\['seed'\] have null"):
        write_results(tmp_path / "null", without, series)
    with pytest.raises(OutputError, match="wrong type"):
        write_results(tmp_path / "type", runs.with_columns(seed=pl.lit("first")), series)


def test_a_folder_that_is_not_results_says_so(tmp_path):
    with pytest.raises(OutputError, match=r"no such folder.*dmil study"):
        Results(tmp_path / "nothing")
    with pytest.raises(OutputError, match=r"holds no manifest\.json"):
        Results(tmp_path)


def test_another_schema_version_says_so(study):
    write_manifest(study, {"schema_version": 99})
    with pytest.raises(OutputError, match="schema version is 99; expected 7"):
        Results(study)


def test_a_broken_manifest_says_so(study):
    (study / "manifest.json").write_text("{")
    with pytest.raises(OutputError, match="cannot be read"):
        Results(study)


def test_truncated_parquet_says_so(study):
    path = study / "series.parquet"
    path.write_bytes(path.read_bytes()[:-100])
    with pytest.raises(OutputError, match=r"series\.parquet: the file is truncated"):
        Results(study)


def test_other_columns_say_so(study):
    pl.DataFrame({"seed": [1]}).write_parquet(study / "runs.parquet")
    with pytest.raises(OutputError, match=r"runs\.parquet: columns .*w_over_vc"):
        Results(study)
    (study / "runs.parquet").unlink()
    with pytest.raises(OutputError, match=r"holds no runs\.parquet"):
        Results(study)


def test_the_manifest_knows_where_it_came_from(tmp_path):
    write_manifest(tmp_path, {"configuration": {"seeds": [1, 2]}, "wall_s": 1.5})
    manifest = read_manifest(tmp_path)
    assert manifest["configuration"] == {"seeds": [1, 2]}
    assert set(manifest["versions"]) == {"dmil", "python", "numpy", "numba"}
    assert manifest["machine"]["cores"] >= 1
    assert json.loads((tmp_path / "manifest.json").read_text()) == manifest


def test_a_manifest_that_is_not_json_is_refused(tmp_path):
    with pytest.raises(OutputError, match="cannot be written as JSON"):
        write_manifest(tmp_path, {"wall_s": float("nan")})
    assert list(tmp_path.iterdir()) == []


def test_a_quote_in_the_folder_is_no_sql(make_study):
    folder = make_study("it's here", seeds=1, scenarios=("grid:1x1",))
    with Results(folder) as results:
        assert results.query("select count(*) from runs").item() == 55


def test_a_folder_whose_name_looks_like_a_pattern_is_read_itself(make_study):
    cells = [cell for cell in make_study.cells() if cell["reward"] is None]
    make_study("run1", seeds=2, scenarios=("grid:1x1",), cells=cells)
    for name in ("run[1]", "run*", "run?"):
        folder = make_study(name, seeds=1, scenarios=("grid:1x1",), cells=cells)
        with Results(folder) as results:
            assert results.runs().height == len(cells) == 4
            assert results.series()["seed"].unique().to_list() == [0]


def test_ctrl_c_during_a_question_is_ctrl_c(make_study, monkeypatch):
    class Interrupted:
        def sql(self, sql):
            raise RuntimeError("Query interrupted")

        def close(self):
            pass

    with Results(make_study(seeds=1, scenarios=("grid:1x1",))) as results:
        monkeypatch.setattr(results, "_connection", Interrupted())
        with pytest.raises(KeyboardInterrupt):
            results.runs()


def test_every_column_is_documented():
    text = schema_markdown()
    for column in RUNS:
        assert f"| `{column.name}` |" in text
        assert column.meaning.endswith(".")
