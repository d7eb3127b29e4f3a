"""What ``dmil study memories`` says in a terminal and as JSON."""

import json

import pytest
from rich.console import Console

from dmil.cli.study import MemoriesParameters
from dmil.cli.terminal import print_json
from dmil.studies.memories.terminal import (
    as_json,
    cells_table,
    claim_lines,
    standing_table,
    subjects,
)
from tests.unit.made_up_memories import CONTROLLERS


@pytest.fixture
def tables(made_up_memories):
    return made_up_memories


def printed(*parts):
    console = Console(width=80, no_color=True)
    with console.capture() as capture:
        console.print(*parts, sep="\n")
    return [line.rstrip() for line in capture.get().splitlines()]


def test_all_controllers_stand_in_order_and_fit_into_a_terminal(tables):
    lines = printed(standing_table(tables))
    assert max(map(len, lines)) <= 80
    text = "\n".join(lines)
    assert text.index("factored ") < text.index("longest queue + approaching") < text.index("MFEC")
    row = next(line for line in lines if line.startswith("factored ")).split()
    assert row[:2] == ["factored", "0.820"] or row[1].startswith("0.8")
    assert "100" in row and "3,400" in row and row[-1] == "0"
    assert next(line for line in lines if line.startswith("VDN")).split()[-1] == "1/78"
    assert sum(line.split()[1:2] != [] for line in lines) >= len(CONTROLLERS)


def test_ours_have_a_table_by_cells(tables):
    assert subjects(tables) == ["factored", "lookahead"]
    lines = printed(cells_table(tables, "factored"))
    assert max(map(len, lines)) <= 80
    row = next(line for line in lines if line.startswith("5×5 ×3.6")).split()
    # Two words of the cell, W, three differences with their intervals, and no planner there.
    assert len(row) == 10 and row[-1] == "–"
    assert all(part.startswith(("−", "±")) for part in row[3:-1])
    single = next(line for line in lines if line.startswith("1×1 ×7")).split()
    assert single[-2].startswith("+2.")  # the planner is 20 % below max-pressure, this one 18 %


def test_verdicts_of_what_was_run_have_a_line_each(tables):
    text = [str(line) for line in claim_lines(tables)]
    assert any(line.startswith("holds  Factored memory takes less than 10 kB") for line in text)
    assert any(line.startswith("1 run failed") for line in text)
    assert not any(line.startswith("not run") for line in text)


def test_json_has_the_tables(tables, capsys):
    print_json(as_json(tables))
    found = json.loads(capsys.readouterr().out)
    assert len(found["cells"]) == 13 and len(found["standing"]) > 200
    assert {row["id"] for row in found["claims"]} >= {"below-max-pressure", "ten-kilobytes"}
    assert found["failures"][0]["controller"] == "vdn"


def test_small_sets_only_what_is_not_given(monkeypatch):
    monkeypatch.setenv("DMIL_DATA", "/nowhere")
    study = MemoriesParameters(small=True, seeds=3).study
    assert (study.seeds, study.episodes, study.horizon_s) == (3, 2, 1200)
    assert study.data is None and len(study.cells) == 3
    assert str(MemoriesParameters().study.data) == "/nowhere"
    assert MemoriesParameters(data="/here").study.data.name == "here"
