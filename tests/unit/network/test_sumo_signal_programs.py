"""Signal programs of additional files and timetables, beside what SUMO itself shows."""

import json
import subprocess
import sys

import pytest

from dmil.errors import NetworkError
from dmil.network.sumo import read_sumo_network
from tests.unit.doctor.conftest import CLEAR_EW, CLEAR_NS, EW, NS

PROGRAM = ((30, NS), (3, CLEAR_NS), (30, EW), (3, CLEAR_EW))
PHASES = '<phase duration="{0}" state="{1}"/><phase duration="{0}" state="{2}"/>'
OTHER = PHASES.format(50, NS, EW)
THIRD = PHASES.format(20, EW, NS)
TIMETABLE = (
    '<WAUT id="w" refTime="100" startProg="0">'
    '<wautSwitch time="500" to="1"/><wautSwitch time="900" to="2"/></WAUT>'
    '<wautJunction wautID="w" junctionID="A0"/>'
)
ANSWER = """
import json, libsumo, sys
for line in sys.stdin:
    libsumo.start(["sumo", *json.loads(line), "--no-warnings"])
    light = libsumo.trafficlight
    shown = light.getProgram("A0"), light.getPhase("A0"), light.getNextSwitch("A0")
    libsumo.close()
    print("RESULT", json.dumps(shown), flush=True)
"""


def logic(phases, program="1", attributes='type="static" offset="0"'):
    return f'<tlLogic id="A0" programID="{program}" {attributes}>{phases}</tlLogic>'


TWO = logic(OTHER) + logic(THIRD, "2")


@pytest.fixture(scope="module")
def shown_by_sumo():
    """Asks SUMO which program and stage it shows at the beginning, and until when."""
    pytest.importorskip("libsumo", reason="needs the extra sumo")
    command = [sys.executable, "-P", "-c", ANSWER]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    with subprocess.Popen(command, **pipes) as process:

        def ask(net, begin_s, *more):
            options = ["--net-file", str(net), "--begin", str(begin_s)]
            options += ["--end", str(begin_s + 9999)]
            if more:
                options += ["--additional-files", ",".join(map(str, more))]
            process.stdin.write(json.dumps(options) + "\n")
            process.stdin.flush()
            for line in process.stdout:
                if line.startswith("RESULT"):
                    return json.loads(line.removeprefix("RESULT"))
            raise AssertionError("SUMO ended")

        yield ask


@pytest.mark.parametrize(
    ("added", "begin_s", "programs", "found"),
    [
        ("", 0, "0", []),
        (logic(OTHER), 0, "0 1", ["several-programs"]),
        (TWO, 7, "0 1 2", ["several-programs"]),
        (logic("", "0", 'offset="17"'), 40, "0", []),
        (logic(OTHER, "1", 'type="static" offset="begin"'), 25, "0 1", ["several-programs"]),
        (TWO + TIMETABLE, 0, "1 2 0", ["several-programs", "program-switches"]),
        (TWO + TIMETABLE, 601, "0 2 1", ["several-programs", "program-switches"]),
        (TWO + TIMETABLE, 1000, "0 1 2", ["several-programs"]),
    ],
)
def test_the_program_of_the_beginning_is_sumos(
    with_states, shown_by_sumo, tmp_path, added, begin_s, programs, found
):
    net, more = with_states(*PROGRAM), tmp_path / "tls.xml"
    more.write_text(f"<tls><group>{added}</group><e1Detector id='d' file='x'/></tls>")
    roads = read_sumo_network(net, additional=[more], begin_s=begin_s)
    (item,) = roads.network.intersections
    file = tmp_path / "programs.add.xml"
    file.write_text(f"<additional>{roads.added_programs_xml}</additional>")
    name, stage, until_s = shown_by_sumo(net, begin_s, file)
    assert name == programs.split()[-1]
    assert [each.kind for each in roads.remarks if each.kind != "missing-yellow"] == found
    place_s = (begin_s - item.program.offset_s) % item.program.cycle_s
    ends_s = [sum(s.duration_s for s in item.program.stages[: k + 1]) for k in range(stage + 1)]
    assert until_s - begin_s == ends_s[stage] - place_s
    assert place_s >= (ends_s[stage - 1] if stage else 0)


@pytest.mark.parametrize(
    ("added", "problem"),
    [
        ('<tlLogic id="Z" programID="1"><phase duration="9" state="G"/></tlLogic>', "no signal of"),
        (logic(OTHER, "0"), "there is another program '0' of it"),
        (logic("", "1"), "its program has no stages"),
        (logic(PHASES.format(9, "GG", "rr")), "stage 0 has 2 letters"),
        (logic('<phase state="GG"/>'), "its attribute 'duration' is missing"),
        (logic('<phase duration="x" state="GG"/>'), "it cannot be understood"),
        (TIMETABLE, "signal 'A0' has no program '1'"),
        (TIMETABLE.replace('junctionID="A0"', 'junctionID="Z"'), "there is no signal 'Z'"),
        (TIMETABLE.replace('wautID="w"', 'wautID="v"'), "there is no WAUT 'v'"),
        ('<WAUT id="w"><wautSwitch to="1"/></WAUT>', "its attribute 'time' is missing"),
    ],
)
def test_what_sumo_refuses_is_an_error_with_its_place(with_states, tmp_path, added, problem):
    more = tmp_path / "tls.xml"
    more.write_text(f"<additional>{added}</additional>")
    with pytest.raises(NetworkError, match=problem):
        read_sumo_network(with_states(*PROGRAM), additional=[more])


def test_a_signal_that_is_off_keeps_its_phases_and_is_left_to_sumo(
    with_states, shown_by_sumo, tmp_path
):
    net, more = with_states(*PROGRAM), tmp_path / "tls.xml"
    more.write_text(f"<additional>{logic('', 'off')}</additional>")
    roads = read_sumo_network(net, additional=[more])
    (item,) = roads.network.intersections
    assert (item.program, item.own_control) == (None, "off")
    assert item.phases == read_sumo_network(net).network.intersections[0].phases
    assert shown_by_sumo(net, 0, more)[0] == "off"


def test_files_that_include_others_are_read_with_them(with_states, shown_by_sumo, tmp_path):
    more, inner = tmp_path / "a.xml", tmp_path / "folder" / "b.xml"
    inner.parent.mkdir()
    more.write_text('<additional><include href="folder/b.xml"/></additional>')
    inner.write_text(f"<additional>{logic(OTHER)}</additional>")
    net = with_states(*PROGRAM)
    (item,) = read_sumo_network(net, additional=[more]).network.intersections
    assert item.program.cycle_s == 100
    assert shown_by_sumo(net, 0, more)[0] == "1"
    inner.write_text('<additional><include href="../a.xml"/></additional>')
    with pytest.raises(NetworkError, match=r"a\.xml', which leads back to it"):
        read_sumo_network(net, additional=[more])
