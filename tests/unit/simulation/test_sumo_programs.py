"""Plans as SUMO's signal programs, loaded by the program ``sumo`` itself."""

import importlib.util
import re
import subprocess
from pathlib import Path

import pytest

from dmil.network.sumo import SumoSignals
from dmil.scenarios import SignalTiming, scenario
from dmil.scenarios.resco import find_resco_configuration
from dmil.simulation.sumo.programs import Plan, stages, write_programs

HEADS = SumoSignals("a", ("GGrg", "rgGg"), tuple((j,) for j in range(4)))


def test_between_phases_stand_yellow_and_all_red():
    timing = SignalTiming(clearance_s=5, all_red_s=2)
    assert stages(HEADS, Plan((0, 1), (20, 30)), timing) == [
        (20, "GGrg"),
        (3, "ygrg"),
        (2, "rgrg"),
        (30, "rgGg"),
        (3, "rgyg"),
        (2, "rgrg"),
    ]
    assert stages(HEADS, Plan((1,), (30,)), timing) == [(30, "rgGg")]
    assert stages(HEADS, Plan((0, 1), (20, 30)), SignalTiming()) == [(20, "GGrg"), (30, "rgGg")]


@pytest.fixture
def drive(tmp_path):
    if importlib.util.find_spec("sumo") is None or importlib.util.find_spec("sumo_rl") is None:
        pytest.skip("needs the extra sumo")
    import sumo

    def run(name, programs):
        """Run SUMO on a scenario's own configuration; return state and program by second."""
        configuration = find_resco_configuration(name)
        noted = tmp_path / "states.xml"
        note = tmp_path / "note.add.xml"
        note.write_text(
            f'<additional><timedEvent type="SaveTLSStates" dest="{noted}"/></additional>'
        )
        command = [Path(sumo.SUMO_HOME) / "bin" / "sumo", "-c", configuration]
        command += ["-a", f"{programs},{note}", "--end", "25500", "--no-step-log"]
        command += ["--xml-validation", "never"]
        done = subprocess.run(
            [str(part) for part in command], capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stderr
        return re.findall(r'programID="([^"]*)".* state="([^"]*)"', noted.read_text())

    return run


def test_sumo_shows_the_plan_that_it_loads_last(drive, tmp_path):
    made = scenario("resco/cologne1")
    file = tmp_path / "programs.add.xml"
    plan = Plan((2, 0), (12, 21))
    write_programs(file, [(0, [plan])], made.sumo.signals, made.timing, made.sumo.begin_s)
    found = drive("resco/cologne1", file)
    expected = [
        ("dmil", state)
        for duration_s, state in stages(made.sumo.signals[0], plan, made.timing)
        for _ in range(duration_s)
    ]
    assert len(expected) == 12 + 3 + 21 + 3
    assert found[: 2 * len(expected)] == 2 * expected


def test_sumo_switches_between_plans_by_the_clock(drive, tmp_path):
    made = scenario("resco/cologne1")
    file = tmp_path / "programs.add.xml"
    early, late = Plan((0, 2), (10, 10)), Plan((0, 2), (40, 5))
    timetable = [(0, [early]), (120, [late])]
    write_programs(file, timetable, made.sumo.signals, made.timing, made.sumo.begin_s)
    shown = [program for program, _ in drive("resco/cologne1", file)]
    assert set(shown[:115]) == {"dmil"}
    assert set(shown[125:]) == {"dmil-1"}
