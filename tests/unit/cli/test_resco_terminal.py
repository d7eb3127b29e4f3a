"""What ``dmil study resco`` and ``dmil report`` say about a study on the RESCO benchmark."""

import json

import pytest
from rich.console import Console

from dmil.cli.terminal import print_json
from dmil.results import Results
from dmil.scenarios.names import RESCO
from dmil.studies.resco.tables import resco_tables
from dmil.studies.resco.terminal import agreement_lines, as_json, locks_table, resco_table
from tests.unit.made_up_resco import CONTENDERS, SUMO


@pytest.fixture(scope="module")
def tables(make_resco_study):
    with Results(make_resco_study(scenarios=tuple(RESCO), seeds=3)) as results:
        return resco_tables(results)


def printed(*parts):
    console = Console(width=80, no_color=True)
    with console.capture() as capture:
        console.print(*parts, sep="\n")
    return [line.rstrip() for line in capture.get().splitlines()]


def test_all_networks_fit_into_a_terminal(tables):
    lines = printed(resco_table(tables))
    text = "\n".join(lines)
    assert max(map(len, lines)) <= 80 and "…" not in text
    for word in ("col.8", "ing.21", "art.4x4", "dual complex + comm.", "published MPLight"):
        assert word in text
    assert sum(line.startswith(("dual", "sarsa")) for line in lines) == 7


def test_a_median_stands_above_its_interval_and_what_was_published(tables):
    lines = printed(resco_table(tables))
    place = next(number for number, line in enumerate(lines) if line.startswith("program"))
    row = tables.headline.filter(controller="program", scenario="resco/cologne1").row(0, named=True)
    median, half, published = (line.split() for line in lines[place : place + 3])
    assert median[1].rstrip("*") == f"{row['median']:.1f}"
    assert half[0] == f"±{(row['iqm_high'] - row['iqm_low']) / 2:.1f}"
    assert published[0] == "[56.6]" and "[133]" in published


def test_few_networks_have_their_full_names(make_resco_study):
    with Results(make_resco_study(seeds=1, contenders=CONTENDERS[:7])) as results:
        lines = printed(resco_table(resco_tables(results)))
    assert "ingolstadt21" in lines[1] and "1 seed" in lines[0]
    assert not any("±" in line or "*" in line for line in lines if "Median" not in line)


def test_locked_runs_stand_in_a_table_where_there_are_some(tables):
    lines = printed(locks_table(tables))
    assert max(map(len, lines)) <= 80
    (random,) = (line.split() for line in lines if line.startswith("random"))
    (pressure,) = (line.split() for line in lines if line.startswith("max-pressure"))
    assert random[1:] == ["1/3"] * 8 and pressure[1:] == ["0/3"] * 8


def test_a_line_for_each_queue_simulator(tables):
    lines = printed(*agreement_lines(tables))
    assert len(lines) == 2
    assert lines[1].startswith("queue-calibrated against sumo: Kendall's τ 1.00 [0.9")
    assert lines[1].endswith("delays −10 %")


def test_json_holds_all_tables(tables, capsys):
    print_json(as_json(tables))
    found = json.loads(capsys.readouterr().out)
    assert found["judge"] == SUMO and found["trained_in"] == ["queue-calibrated"]
    assert len(found["locks"]) == len(CONTENDERS) * len(RESCO)
    assert len(found["delay"]) == len(CONTENDERS) * len(RESCO)
    assert len(found["training"]) == 7 * len(RESCO)
    pooled = [row for row in found["agreement"] if row["scenario"] is None]
    assert {(row["metric"], row["simulator"]) for row in pooled} == {
        (metric, simulator)
        for metric in ("delay_s", "travel_time_s")
        for simulator in ("queue", "queue-calibrated")
    }
    assert len(found["published"]) == 53


def test_the_command_report_writes_the_pages_of_the_networks(dmil, make_resco_study):
    folder = make_resco_study(scenarios=("resco/cologne1",), seeds=2, contenders=CONTENDERS[3:7])
    found = dmil.json("report", folder, "--no-pictures")
    assert found["report"] == str(folder / "report.html")
    assert found["scenarios"] == [str(folder / "scenarios" / "cologne1.html")]
    assert len(found["tables"]) == 9 and found["figures"] == []
    assert "Pages of the networks" in dmil("report", folder, "--no-pictures")
