"""CityFlow's files named after the user's own habit, in every command."""

import json

import pytest

from dmil.cli import app


@pytest.fixture
def files(crossing, write):
    entry = {"route": ["E_in", "W_out"], "interval": 5, "startTime": 0, "endTime": 55}
    return "--roadnet", write(crossing()[0], "my roads.txt"), "--flow", write([entry], "cars")


@pytest.fixture
def run(capsys):
    def command(*arguments):
        with pytest.raises(SystemExit) as end:
            app([str(each) for each in arguments], prog_name="dmil")
        assert end.value.code == 0
        return json.loads(capsys.readouterr().out)

    return command


SHORT = ("--steps", 60, "--json")


@pytest.mark.parametrize(
    ("command", "read"),
    [
        (("doctor", *SHORT), lambda found: found["demand"]["vehicles"] == 12),
        (("scenarios", "--json"), lambda found: found["vehicles_of_seed_0"] == 12),
        (("simulate", *SHORT), lambda found: found["runs"][0]["spawned_veh"] == 12),
    ],
)
def test_both_files_have_an_option_in_every_command(files, run, command, read):
    assert read(run(*command, *files))


def test_the_doctor_needs_no_vehicles(files, run):
    found = run("doctor", *files[:2], "--json")
    assert found["demand"] is None
    assert len(found["intersections"]) == 1


def test_a_comparison_writes_its_page_of_such_files(files, run, tmp_path):
    page = tmp_path / "page.html"
    arguments = ("--no-baselines", "--controller", "max-pressure", "--seeds", 1, "--jobs", 1)
    run("evaluate", *files, *SHORT, *arguments, "--report", page)
    assert "<svg" in page.read_text()
