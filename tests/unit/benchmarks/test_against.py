"""Two versions beside each other: whose package runs, in which order, and what is compared."""

import json
from pathlib import Path

import pytest

from dmil.benchmarks import against
from dmil.benchmarks.against import figures_against
from dmil.errors import DmilError, InputError

MAIN = """
import json, sys
from pathlib import Path
figures = {figures}
with Path({log!r}).open("a") as log:
    log.write({name!r})
print(json.dumps({{"figures": [dict(name=k, value=v, unit="runs/s") for k, v in figures.items()]}}))
sys.exit({code})
"""


@pytest.fixture
def version(tmp_path):
    """A checkout whose bench says what it is told to."""

    def make(name, figures, code=0):
        package = tmp_path / name / "src" / "dmil"
        package.mkdir(parents=True)
        (package / "__init__.py").touch()
        log = str(tmp_path / "log")
        main = MAIN.format(figures=figures, log=log, name=name[0], code=code)
        (package / "__main__.py").write_text(main, encoding="utf-8")
        return tmp_path / name

    return make


@pytest.fixture
def here(version, monkeypatch):
    package = version("here", {"kernel": 300.0, "new": 1.0}) / "src" / "dmil" / "__init__.py"
    monkeypatch.setattr(against.dmil, "__file__", str(package))


def compared(folder, rounds=2):
    told = []
    found = figures_against(folder, rounds=rounds, progress=lambda *each: told.append(each))
    return found, told


def test_figures_that_both_have_are_compared_measured_in_turns(here, version, tmp_path):
    there = version("there", {"old": 2.0, "kernel": 200.0})
    (found,), told = compared(there)
    assert (found.name, found.unit, found.here, found.there) == ("kernel", "runs/s", 300.0, 200.0)
    assert found.ratio == found.ratio_min == found.ratio_max == 1.5
    assert (tmp_path / "log").read_text() == "htth"
    assert told == [(done, 4) for done in range(5)]


def test_the_folder_of_the_package_does_as_well(here, version):
    there = version("there", {"kernel": 600.0})
    assert compared(there / "src")[0][0].ratio == 0.5


def test_a_bench_that_fails_is_one_clear_error(here, version):
    with pytest.raises(DmilError, match="there/src: its bench ended with code 3"):
        compared(version("there", {"kernel": 1.0}, code=3))


def test_a_folder_without_the_package_is_refused(tmp_path):
    with pytest.raises(InputError, match="there is no package dmil"):
        compared(Path(tmp_path))


def test_the_command_prints_both_and_their_ratio(here, version, capsys):
    from dmil.cli import app

    there = version("there", {"kernel": 200.0})
    for more in ((), ("--json",)):
        with pytest.raises(SystemExit) as ended:
            app(["bench", "--against", str(there), "--rounds", "1", *more])
        assert ended.value.code == 0
        said = capsys.readouterr().out
        if more:
            assert json.loads(said)["figures"][0]["ratio"] == 1.5
        else:
            assert "1.5 (1.5 to 1.5)" in said
