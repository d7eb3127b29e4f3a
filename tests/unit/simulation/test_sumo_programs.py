"""Plans as SUMO's signal programs, loaded by the program ``sumo`` itself."""

import importlib.util
import re
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from dmil.network import grid
from dmil.network.sumo import SumoSignals
from dmil.scenarios import SignalTimes, scenario, signal_times
from dmil.scenarios.names import find_resco_configuration
from dmil.simulation.sumo.programs import Plan, programs_xml, stages

ITEM = grid(1, 1).intersections[0]
HEADS = SumoSignals("a", ("GGrg", "rgGg"), tuple((j,) for j in range(4)))
STOPPING = replace(ITEM, unsignalled=frozenset({3}))


def times(clearance_s, all_red_s, *, all_stop=False):
    """Times of one intersection with two phases."""
    changes = (
        np.array([[[0, out], [back, 0]]], np.int32) for out, back in (clearance_s, all_red_s)
    )
    return SignalTimes(*changes, *np.zeros((2, 1, 2), np.int32), np.array([all_stop]))


def test_between_phases_stand_the_yellow_and_all_red_of_each_change():
    kept = times((5, 4), (2, 0))
    assert stages(HEADS, Plan((0, 1), (20, 30)), kept, ITEM, 0) == [
        (20, "GGrg"),
        (3, "ygrg"),
        (2, "rgrg"),
        (30, "rgGg"),
        (4, "rgyg"),
    ]
    assert stages(HEADS, Plan((1,), (30,)), kept, ITEM, 0) == [(30, "rgGg")]
    stopping = times((5, 4), (2, 0), all_stop=True)
    shown = stages(HEADS, Plan((0, 1), (20, 30)), stopping, STOPPING, 0)
    assert [state for _, state in shown] == ["GGrg", "yyrg", "rrrg", "rgGg", "ryyg"]
    without = times((0, 0), (0, 0))
    assert stages(HEADS, Plan((0, 1), (20, 30)), without, ITEM, 0) == [(20, "GGrg"), (30, "rgGg")]


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
    kept = signal_times(made.timing, made.network)
    begin_s, network = made.sumo.begin_s, made.network
    file.write_text(programs_xml([(0, [plan])], network, made.sumo.signals, kept, begin_s))
    found = drive("resco/cologne1", file)
    expected = [
        ("dmil", state)
        for duration_s, state in stages(made.sumo.signals[0], plan, kept, ITEM, 0)
        for _ in range(duration_s)
    ]
    assert len(expected) == 12 + 3 + 21 + 3
    # The cycle begins where the file's own one does.
    place = (begin_s - int(network.intersections[0].program.offset_s)) % len(expected)
    assert found[: 2 * len(expected)] == (3 * expected)[place:][: 2 * len(expected)]


def test_sumo_switches_between_plans_by_the_clock(drive, tmp_path):
    made = scenario("resco/cologne1")
    file = tmp_path / "programs.add.xml"
    early, late = Plan((0, 2), (10, 10)), Plan((0, 2), (40, 5))
    timetable = [(0, [early]), (120, [late])]
    kept = signal_times(made.timing, made.network)
    begin_s, network = made.sumo.begin_s, made.network
    file.write_text(programs_xml(timetable, network, made.sumo.signals, kept, begin_s))
    shown = [program for program, _ in drive("resco/cologne1", file)]
    assert set(shown[:115]) == {"dmil"}
    assert set(shown[125:]) == {"dmil-1"}
