"""SUMO networks for the tests: made by netgenerate, or of the installed sumo-rl package."""

import importlib.util
import re
import subprocess
from pathlib import Path

import pytest

ONE = ("--grid", "--grid.number", "1", "--grid.attach-length", "100", "--no-turnarounds")
ONE += ("-j", "traffic_light", "--turn-lanes", "1")


def sumo_binary(name):
    import sumo

    return str(Path(sumo.SUMO_HOME) / "bin" / name)


def nets_of_sumo_rl():
    """The package itself cannot be imported without SUMO_HOME; its files can be read."""
    spec = importlib.util.find_spec("sumo_rl")
    assert spec is not None and spec.submodule_search_locations
    return Path(spec.submodule_search_locations[0]) / "nets"


@pytest.fixture(scope="session")
def generate(tmp_path_factory):
    """A function from netgenerate's options to the file that it writes."""
    folder = tmp_path_factory.mktemp("nets")
    made = {}

    def run(*options, zipped=False):
        key = (*options, zipped)
        if key not in made:
            made[key] = folder / f"{len(made)}.net.xml{'.gz' if zipped else ''}"
            command = [sumo_binary("netgenerate"), *options, "-o", str(made[key])]
            subprocess.run(command, check=True, capture_output=True, timeout=120)
        return made[key]

    return run


@pytest.fixture
def with_states(generate, tmp_path):
    """A function that writes a four-way intersection with a program of one's own.

    Its letters are right, straight, left from North, East, South and West: twelve of them.
    """

    def write(*stages, attributes='type="static" programID="0" offset="0"', more=""):
        text = generate(*ONE).read_text()
        phases = "".join(
            f'<phase duration="{seconds}" state="{state}"/>' for seconds, state in stages
        )
        logic = f'<tlLogic id="A0" {attributes}>{phases}</tlLogic>{more}'
        path = tmp_path / "own.net.xml"
        path.write_text(re.sub(r"<tlLogic.*</tlLogic>", logic, text, flags=re.DOTALL))
        return path

    return write
