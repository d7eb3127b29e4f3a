"""The page about a user's own network: its commands, in their order, on a network of ours."""

import csv
import json
import re
import shlex
import subprocess
from pathlib import Path
from xml.etree import ElementTree

import pytest

from dmil.network.sumo.writer import sumo_program

pytest.importorskip("libsumo", reason="needs the extra sumo")
pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "your-network.md").read_text(encoding="utf-8")
LINES = [
    shlex.split(line)
    for block in re.findall(r"```sh\n(.*?)```", PAGE, re.DOTALL)
    for line in block.splitlines()
]
COMMANDS = [line[1:] for line in LINES if line[0] == "dmil"]
# The page's own options stay; these come after them and win.
SHORTER = {
    "calibrate": ("--seeds", "0"),
    "train": ("--episodes", "2"),
    "evaluate": ("--seeds", "2", "--jobs", "1"),
}
TRIPS = (("left0A0", "B0right0"), ("top0A0", "A0bottom0"), ("right0B0", "B0top1"))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with a city.sumocfg whose network is made as the page says, only smaller."""
    path = tmp_path_factory.mktemp("city")
    (named,) = (line[1:] for line in LINES if line[0] == "netgenerate")
    size = ("--grid.x-number", "2", "--grid.y-number", "1")
    program, environment = sumo_program("netgenerate")
    command = [str(program), *named, *size]
    subprocess.run(command, check=True, capture_output=True, cwd=path, env=environment, timeout=120)
    trips = "".join(
        f'<trip id="{number}" depart="{3 * number}" from="{start}" to="{end}"/>'
        for number in range(80)
        for start, end in [TRIPS[number % 3]]
    )
    (path / "city.trips.xml").write_text(f"<routes>{trips}</routes>")
    (path / "city.sumocfg").write_text(
        '<configuration><net-file value="city.net.xml"/><route-files value="city.trips.xml"/>'
        '<begin value="0"/><end value="300"/></configuration>'
    )
    return path


def test_the_commands_lead_to_an_answer_and_a_plan(dmil, folder):
    verbs = [command[0] for command in COMMANDS]
    assert verbs[:3] == ["doctor", "evaluate", "export"]
    assert verbs[3:] == ["calibrate", "train", "evaluate", "export"]
    outs = [dmil(*each, *SHORTER.get(each[0], ()), cwd=folder).out for each in COMMANDS]
    doctor, evaluated, exported, _, trained, judged, _ = outs

    assert "2 intersections" in doctor
    ElementTree.parse(folder / "city.svg")
    calibration = json.loads((folder / "calibration.json").read_text())
    assert 0.1 < calibration["saturation_flow_veh_per_s"] < 1
    everybody = {"program", "actuated", "combined", "factored", "lookahead"}
    for found in (*everybody, "longest-queue-first", "max-pressure", "− program", "CO2", "IQM"):
        assert found in evaluated
    report = (folder / "report.html").read_text(encoding="utf-8")
    assert "against <b>program</b>" in report
    assert "simulator: sumo" in report
    for contender in everybody:
        assert f'<td class="name">{contender}</td>' in report
    assert '<td class="name">max-pressure,<br>approaching=true</td>' in report
    with (folder / "seeds.csv").open(encoding="utf-8", newline="") as file:
        assert len(list(csv.DictReader(file))) == 2 * 7
    assert "its fixed-time plan" in exported
    assert "policy.npz" in trained.splitlines()[-2]
    assert "policy.npz" in judged

    # A plain SUMO loads the plan as the page says.
    (named,) = (line[1:] for line in LINES if line[:2] == ["sumo", "-c"])
    program, environment = sumo_program("sumo")
    ran = subprocess.run(
        [str(program), *named, "--tripinfo-output", "trips.xml"],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )
    assert ran.returncode == 0, ran.stderr
    assert len(ElementTree.parse(folder / "trips.xml").findall("tripinfo")) > 50


@pytest.mark.parametrize("link", sorted(set(re.findall(r"\]\(([^)#:]+)\)", PAGE))))
def test_every_link_leads_somewhere(link):
    assert (ROOT / "docs" / link).exists()
