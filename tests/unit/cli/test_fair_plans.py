"""A comparison with a plan is fair or says so; an exported plan is as safe as the one before."""

import importlib.util
import re
import subprocess
from pathlib import Path

import pytest

pytestmark = pytest.mark.skipif(
    importlib.util.find_spec("libsumo") is None, reason="needs the extra sumo"
)

ROUTES = """<routes>
<flow id="a" from="left0A0" to="A0right0" begin="0" end="300" vehsPerHour="400"/>
<flow id="b" from="top0A0" to="A0bottom0" begin="0" end="300" vehsPerHour="200"/>
</routes>"""
STAGES = (
    (30, "GGgrrrGGgrrr"),
    (4, "yyyrrryyyrrr"),
    (2, "rrrrrrrrrrrr"),
    (20, "rrrGGgrrrGGg"),
    (3, "rrryyyrrryyy"),
    (1, "rrrrrrrrrrrr"),
)


@pytest.fixture
def crossroads(tmp_path):
    """A function that writes an intersection with stages of one's own, and its configuration."""

    def write(stages=STAGES, offset_s=17):
        import sumo

        net = tmp_path / "x.net.xml"
        options = ("--grid", "--grid.number", "1", "--grid.attach-length", "200", "-j")
        options += ("traffic_light", "--turn-lanes", "1", "--no-turnarounds")
        program = Path(sumo.SUMO_HOME) / "bin" / "netgenerate"
        subprocess.run([program, *options, "-o", net], check=True, capture_output=True)
        phases = "".join(f'<phase duration="{s}" state="{state}"/>' for s, state in stages)
        logic = f'<tlLogic id="A0" type="static" programID="0" offset="{offset_s}">{phases}'
        text = re.sub(
            '<tlLogic id="A0".*?</tlLogic>', f"{logic}</tlLogic>", net.read_text(), flags=16
        )
        net.write_text(text)
        (tmp_path / "x.rou.xml").write_text(ROUTES)
        configuration = tmp_path / "x.sumocfg"
        configuration.write_text(
            '<configuration><net-file value="x.net.xml"/><route-files value="x.rou.xml"/>'
            '<end value="300"/></configuration>'
        )
        return configuration

    return write


def programs(folder):
    """Offset, and the stages as (seconds, state)."""
    text = (folder / "programs.add.xml").read_text()
    stages = re.findall(r'duration="(\d+)" state="(\w+)"', text)
    return re.findall(r'offset="(\d+)"', text), [(int(s), state) for s, state in stages]


@pytest.mark.parametrize("given", [(), ("--clearance", "1", "--min-green", "0")])
def test_an_exported_plan_keeps_clearance_least_greens_and_offset(
    dmil, crossroads, tmp_path, given
):
    dmil("export", "--scenario", crossroads(), *given, "--out", tmp_path)
    offset, stages = programs(tmp_path)
    assert offset == ["17"]
    assert [state for _, state in stages] == [state for _, state in STAGES]
    # The greens are the controller's.
    for k in (1, 2, 4, 5):
        assert stages[k] == STAGES[k]
    assert min(stages[0][0], stages[3][0]) >= 5


def test_more_clearance_than_the_plans_is_exported_too(dmil, crossroads, tmp_path):
    dmil("export", "--scenario", crossroads(), "--clearance", "7", "--out", tmp_path)
    # Yellow 5 s (7 less 2 of all-red), all-red 2 s; then 6 s and 1 s.
    seconds = [s for s, _ in programs(tmp_path)[1]]
    assert (seconds[1:3], seconds[4:]) == ([5, 2], [6, 1])


def test_greens_that_conflict_are_not_exported(dmil, crossroads, tmp_path):
    clash = ((30, "GGGrrrGGGrrr"), *STAGES[1:])
    dmil("export", "--scenario", crossroads(clash), "--out", tmp_path, code=2)
    assert "in GGGrrrGGGrrr the movements" in dmil.err
    assert "both have priority" in dmil.err
    assert "Traceback" not in dmil.err
    assert not (tmp_path / "programs.add.xml").exists()


def test_what_learns_online_is_exported_as_it_learned(dmil, crossroads, tmp_path):
    configuration = crossroads()
    found = dmil.json(
        "export", "--scenario", configuration, "--controller", "factored", "--out", tmp_path
    )
    assert any("while it learned from the first second" in note for note in found["notes"])
    frozen = dmil.json(
        *("export", "--scenario", configuration, "--controller", "factored", "--out", tmp_path),
        *("--set", "learning=false"),
    )
    assert frozen["plans"] != found["plans"] or frozen["in_sumo"] != found["in_sumo"]
    untrained = dmil.json(
        "export", "--scenario", configuration, "--controller", "sarsa", "--out", tmp_path
    )
    assert any("has learned nothing" in note for note in untrained["notes"])


def test_a_comparison_with_the_plan_is_fair_unless_the_user_says_otherwise(dmil, crossroads):
    options = ("--scenario", crossroads(), "--no-baselines", "--controller", "max-pressure")
    options += ("--reference", "program", "--seeds", "1", "--jobs", "1")
    fair = dmil.json("evaluate", *options)
    assert fair["withheld"] is None
    assert fair["controllers"][0]["minus_program"]["delay_s"]["mean"] < 0
    hasty = dmil.json("evaluate", *options, "--clearance", "2")
    assert hasty["controllers"][0]["minus_program"] == {}
    assert "A0: clearance 2 s, 6 s in its plan" in hasty["withheld"]
    shown = dmil("evaluate", *options, "--clearance", "2")
    assert "NOT A FAIR COMPARISON" in shown
    assert shown.index("NOT A FAIR") < shown.index("travel time")
    assert "− program" not in shown
    # Between controllers that all keep less, nothing is unfair.
    alone = (*options[:5], "--seeds", "1", "--jobs", "1", "--clearance", "2")
    assert dmil.json("evaluate", *alone)["withheld"] is None


def test_the_page_says_it_first(dmil, crossroads, tmp_path):
    page = tmp_path / "page.html"
    options = ("--scenario", crossroads(), "--no-baselines", "--controller", "max-pressure")
    options += ("--reference", "program", "--seeds", "1", "--jobs", "1")
    options += ("--clearance", "2", "--report", page)
    dmil("evaluate", *options)
    text = page.read_text()
    assert text.index("NOT A FAIR COMPARISON") < text.index('id="numbers"')
    assert "clearance-cut" in text
    assert "− program" not in text
