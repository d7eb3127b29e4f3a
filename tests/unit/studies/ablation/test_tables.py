"""What an ablation says: tables, figure, page, terminal."""

import polars as pl
import pytest

from dmil.analysis.panel import rows_by
from dmil.errors import InputError
from dmil.reports.labels import signed
from dmil.results import Results
from dmil.studies.ablation.names import cell_label
from dmil.studies.ablation.page import AblationReport
from dmil.studies.ablation.tables import ablation_tables
from dmil.studies.ablation.terminal import as_json, in_terminal
from tests.unit.made_up_ablation import CELLS, CHANGE_S, SETTINGS, write_ablation
from tests.unit.vega_lite import check_valid

LOCKED = ("combined,learning=false", "resco/cologne1", 603)
FAILED = ("factored,yields=true", "grid:3x3*2".partition("*")[0], 600)


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = write_ablation(tmp_path_factory.mktemp("made"), locked=[LOCKED], failed=[FAILED])
    with Results(folder) as found:
        yield found


@pytest.fixture(scope="module")
def tables(results):
    return ablation_tables(results)


def test_the_paired_difference_is_what_the_part_changes(tables):
    rows = rows_by(tables.differences, "cell", "variant")
    for cell in CELLS:
        for variant, change in CHANGE_S.items():
            row = rows[cell, variant]
            usual = 2.0 + (25.0 if variant.startswith("factored") else 20.0)
            assert row["pct"] == pytest.approx(100 * (change + 0.1) / usual, abs=0.5)
            if (variant, cell) == LOCKED[:2]:
                continue
            assert row["delay_s"] == pytest.approx(change + 0.1, abs=0.06)
            assert row["low"] <= row["delay_s"] <= row["high"]
            assert row["high"] - row["low"] < 0.3  # seeds differ by far more than pairs do
        assert rows[cell, "factored,learning=false"]["delay_s"] == 0.0
        assert rows[cell, "factored,learning=false"]["alike"] == 1.0
    row = rows["resco/cologne1", "combined,learning=false"]
    assert (row["n"], row["free"]) == (8, 7)
    assert row["high"] > 100 > row["pct_high"]  # a locked run counts in s, and not in %


def test_locked_and_failed_runs_are_named(tables):
    assert tables.locks.select("controller", "scenario", "seed").rows() == [LOCKED]
    rows = rows_by(tables.differences, "cell", "variant")
    assert rows["resco/cologne1", LOCKED[0]]["locked"] == 1
    assert rows["grid:3x3*2", LOCKED[0]]["locked"] == 0
    assert tables.failures["status"].to_list() == ["ValueError: no"]
    assert rows["grid:3x3*2", FAILED[0]]["n"] == SETTINGS.seeds - 1


def test_a_table_for_every_case_in_the_terminal(tables):
    *shown, locked = in_terminal(tables)
    assert len(shown) == len(CELLS)
    assert "combined,learning=false" in locked[0].plain and "1200 s" in locked[0].plain
    found = as_json(tables)
    assert found["cells"] == list(CELLS) and found["seeds"] == list(range(600, 608))
    assert len(found["differences"]) == tables.differences.height


def test_report_figure_and_files(results, tables):
    report = AblationReport(results)
    (figure,) = report.figures()
    check_valid(figure.spec)
    files = report.tables()
    assert "**combined**" in files["tables/differences.md"]
    row = rows_by(tables.differences, "cell", "variant")[CELLS[1], LOCKED[0]]
    assert f"{signed(row['delay_s'], 2)} s" in report.pages([figure])["report.html"]
    assert r"\toprule" in files["tables/differences.tex"]
    frame = pl.read_csv(files["tables/differences.csv"].encode())
    assert frame.height == tables.differences.height


def test_without_a_successful_run_there_is_no_report(tmp_path):
    one = SETTINGS.model_copy(update={"cells": ("grid:1x1",), "seeds": 1, "parts": ("age",)})
    labels = ("combined", "combined,age=0.0", "factored", "factored,age=0.025")
    folder = write_ablation(
        tmp_path / "none", settings=one, failed=[(label, "grid:1x1", 600) for label in labels]
    )
    with Results(folder) as results, pytest.raises(InputError, match="no successful run"):
        ablation_tables(results)


@pytest.mark.parametrize(
    ("name", "label"),
    [
        ("grid:5x5*3.6", "5×5 ×3.6"),
        ("grid:5x5/unequal", "5×5 unequal"),
        ("cityflow:jinan_3x4", "Jinan"),
        ("resco/ingolstadt7", "ingolstadt7"),
        ("sumo:roads/town.sumocfg", "town"),
    ],
)
def test_cases_have_names_for_readers(name, label):
    assert cell_label(name) == label
