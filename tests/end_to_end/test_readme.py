"""The README's own commands and its library example, as they stand there."""

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from dmil.network import grid
from dmil.network.sumo.writer import write_sumo_network

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", README, re.DOTALL)


COMMANDS = [
    shlex.split(line, comments=True)[1:]
    for block in blocks("sh")
    for line in block.splitlines()
    if line.startswith("dmil ")
]


# These come after the README's own options and win: the same commands, only shorter, most in one
# process. That more give the same the tests of the studies show.
SHORTER = {
    ("study", "resco"): ("--seeds", "1", "--episodes", "1", "--steps", "120"),
    # Their reports are written by the tests of these studies.
    ("study", "paper"): ("--grids", "1x1", "--seeds", "2", "--jobs", "1", "--no-report"),
    ("study", "memories"): (
        *(
            "--cells",
            "grid:1x1",
            "--no-deep",
            "--seeds",
            "2",
            "--steps",
            "300",
            "--jobs",
            "1",
            "--no-report",
        ),
    ),
    ("study", "ablation"): (
        *("--cells", "grid:1x1", "--seeds", "2", "--steps", "300", "--jobs", "1", "--no-report"),
    ),
    ("tune",): ("--steps", "300", "--budget", "200", "--jobs", "1"),
    ("evaluate",): ("--seeds", "2", "--steps", "400", "--jobs", "1"),
    ("train",): ("--episodes", "2"),
}


def shorter(command):
    found = (more for start, more in SHORTER.items() if tuple(command[: len(start)]) == start)
    return [*command, *next(found, ())]


def test_the_readme_has_commands():
    ours = {"doctor", "calibrate", "train", "evaluate", "export"}
    assert ours | {"simulate", "study", "theory", "controllers", "tune"} == {
        command[0] for command in COMMANDS
    }


@pytest.fixture
def sumo_city(tmp_path):
    """A folder with a small city.sumocfg."""
    network = grid(1, 2)
    net_file = write_sumo_network(network, tmp_path).net_file
    trips = "".join(
        f'<trip id="{k}" depart="{5 * k}" from="W0_0_0" to="0_1_E0"/>' for k in range(60)
    )
    (tmp_path / "city.rou.xml").write_text(f"<routes>{trips}</routes>")
    (tmp_path / "city.sumocfg").write_text(
        f'<configuration><net-file value="{net_file.name}"/><route-files value="city.rou.xml"/>'
        '<begin value="0"/><end value="400"/></configuration>'
    )
    return tmp_path


def test_every_command_works_in_its_order(dmil, sumo_city):
    for command in COMMANDS:
        assert dmil(*shorter(command), cwd=sumo_city).out.strip()
    for file in ("policy.npz", "city.svg", "plan/programs.add.xml", "roads/report.html"):
        assert (sumo_city / file).is_file()


@pytest.mark.parametrize("source", blocks("python"))
def test_the_library_example_runs_and_compares(source, tmp_path):
    done = subprocess.run(
        [sys.executable, "-c", source],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert len(lines) == 4
    assert [line.startswith("max-pressure") for line in lines] == [False, True] * 2


def test_the_two_commands_are_targets_of_the_makefile():
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for line in re.findall(r"^make (\w+)", README, re.MULTILINE):
        assert re.search(rf"^{line}:", makefile, re.MULTILINE)


@pytest.mark.parametrize("link", sorted(set(re.findall(r"\]\(([^)#]+)\)", README))))
def test_every_link_leads_somewhere(link):
    assert (ROOT / link).exists()
