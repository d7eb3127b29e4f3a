"""What the doctor finds about signals, their programs, and roads."""

import re
from dataclasses import replace
from pathlib import Path

import pytest

from dmil.doctor import examine, read_case
from dmil.doctor.road_findings import LONGEST_CYCLE_S
from dmil.network import Program, Stage
from dmil.scenarios import SignalTiming
from tests.unit.doctor.conftest import (
    CLEAR_EW,
    CLEAR_NS,
    EVERY_WAY,
    EW,
    NS,
    PROGRAM,
    kinds,
    of_kind,
)
from tests.unit.network.conftest import ONE

CASES = Path(__file__).parents[2] / "cases"


def test_nothing_is_found_where_nothing_is_wrong(doctor, with_states):
    diagnosis = doctor(with_states(*PROGRAM), EVERY_WAY, horizon_s=600)
    # netgenerate widens the roads just in front of the stop lines.
    assert kinds(diagnosis) == ["short-link"]
    assert diagnosis.counts == {"error": 0, "warning": 0, "note": 4}


ALL_RED = "r" * 12
SECOND = '<tlLogic id="A0" type="static" programID="1" offset="0"><phase duration="30" state="{}"/>'
SECOND += '<phase duration="3" state="{}"/></tlLogic>'


@pytest.mark.parametrize(
    ("stages", "kind", "severity", "what"),
    [
        (((30, "GGGrrrGGGrrr"), *PROGRAM[1:]), "conflicting-greens", "error", "cross or merge"),
        (((30, "GGrrrrGGgrrr"), *PROGRAM[1:]), "never-served", "error", "top0A0"),
        (((30, NS), *PROGRAM[2:]), "missing-yellow", "warning", "green turns red at once"),
        ((*PROGRAM, (20, ALL_RED)), "empty-stage", "warning", "nothing goes for 20 s"),
        (((30, CLEAR_NS), (3, ALL_RED)), "no-action", "warning", "no stage of its program"),
        (((30, "GGgGGgGGgGGg"), (3, "y" * 12)), "single-action", "warning", "only one phase"),
        (((170, NS), *PROGRAM[1:]), "long-cycle", "warning", "206 s"),
        (
            (*PROGRAM, (8, ALL_RED)),
            "clearance-beyond-interval",
            "warning",
            "clearance is 11 s, the decision interval 10 s",
        ),
        ((*PROGRAM, (2, ALL_RED)), "all-red", "note", "up to 2 s"),
        (
            ((30, NS), (3, "yyyGrryyyrrr"), (30, EW), (3, CLEAR_EW)),
            "mixed-stage",
            "note",
            "in stage 1 of its program",
        ),
        (
            ((30, NS + "r"), (3, CLEAR_NS + "r"), (9, ALL_RED + "G"), (30, EW + "r")),
            "pedestrian-stage",
            "note",
            "only pedestrians",
        ),
    ],
    ids=lambda value: value if isinstance(value, str) and value.islower() else "",
)
def test_findings_about_programs(doctor, with_states, stages, kind, severity, what):
    (found,) = of_kind(doctor(with_states(*stages)), kind)[:1]
    assert found.severity == severity
    assert what in found.what
    assert "A0" in found.place
    assert "/" not in found.place  # no path of a file
    assert found.mend[0].isupper()
    assert found.mend.endswith(".")


def test_an_actuated_program_is_named(doctor, with_states):
    actuated = 'type="actuated" programID="0" offset="0"'
    (found,) = of_kind(doctor(with_states(*PROGRAM, attributes=actuated)), "adaptive-program")
    assert (found.severity, found.place) == ("note", "intersection A0")
    assert "adaptive-program" not in kinds(doctor(with_states(*PROGRAM)))


def test_the_longest_cycle_is_no_finding_yet(doctor, with_states):
    stages = ((LONGEST_CYCLE_S - 36, NS), *PROGRAM[1:])
    assert "long-cycle" not in kinds(doctor(with_states(*stages)))


def test_pedestrians_who_never_get_green_are_a_warning(doctor, generate):
    options = (*ONE, "--sidewalks.guess", "--crossings.guess")
    assert "no-walk" not in kinds(doctor(generate(*options)))
    (found,) = of_kind(doctor(generate(*options), phases="derived"), "no-walk")
    assert found.severity == "warning"
    assert "no phase gives green to 4 of its 4 crossings" in found.what


def test_controllers_that_clear_for_less_than_the_plan_are_a_warning(with_states):
    case = read_case([str(with_states(*PROGRAM, (2, ALL_RED)))])
    assert "clearance-cut" not in kinds(examine(case))
    hasty = replace(case, timing=SignalTiming(clearance_s=3))
    found = of_kind(examine(hasty), "clearance-cut")
    assert {each.severity for each in found} == {"warning"}
    assert [each.what for each in found] == [
        "under a controller clearance 3 s, 5 s in its plan",
        "under a controller all-red 0 s, 2 s in its plan",
    ]
    assert "--clearance" in found[0].mend


def test_lanes_of_one_movement_that_merge_are_a_warning(ingolstadt7):
    diagnosis = examine(ingolstadt7)
    (found,) = of_kind(diagnosis, "conflicting-greens")
    assert (found.severity, found.place) == ("warning", "tlLogic gneJ210")


def test_parallel_rings_have_no_plan(doctor, with_states):
    path = with_states(*PROGRAM, attributes='type="NEMA" programID="0" offset="0"')
    found = kinds(doctor(path))
    assert "own-control" in found
    assert "no-program" not in found


def test_stages_in_another_order_are_named(doctor, with_states):
    path = with_states(*PROGRAM)
    path.write_text(path.read_text().replace(f'state="{CLEAR_NS}"', f'state="{CLEAR_NS}" next="0"'))
    (found,) = of_kind(doctor(path), "stage-order")
    assert (found.severity, found.place) == ("warning", "tlLogic A0, stage 1")


def test_a_timetable_of_programs_is_named(doctor, with_states):
    timetable = '<WAUT id="w" startProg="0"><wautSwitch time="300" to="1"/></WAUT>'
    timetable += '<wautJunction wautID="w" junctionID="A0"/>'
    second = SECOND.format(NS, CLEAR_NS)
    diagnosis = doctor(with_states(*PROGRAM), additional=second + timetable, horizon_s=600)
    (found,) = of_kind(diagnosis, "program-switches")
    assert (found.severity, found.place) == ("warning", "tlLogic A0")
    assert "0 at the beginning, 1 from 300 s" in found.what
    assert len(of_kind(diagnosis, "several-programs")) == 1


def test_rail_crossings_and_rail_signals_are_left_to_sumo(doctor):
    pytest.importorskip("sumolib", reason="needs the extra sumo")
    diagnosis = examine(read_case([str(CASES / "rail-crossing" / "net.net.xml")]))
    found = of_kind(diagnosis, "signal-of-sumo")
    assert [each.place for each in found] == ["tlLogic X", "tlLogic RN"]
    assert "rail_crossing" in found[0].what


def test_several_programs(doctor, with_states):
    path = with_states(*PROGRAM, more=SECOND.format(NS, CLEAR_NS))
    (found,) = of_kind(doctor(path), "several-programs")
    assert found.severity == "note"


def test_missing_right_of_way(doctor, with_states):
    path = with_states(*PROGRAM)
    path.write_text(re.sub(r"<request [^>]*/>", "", path.read_text()))
    assert kinds(doctor(path)) == ["no-right-of-way", "short-link"]


def test_controllers_that_share_a_junction_or_control_no_vehicle(doctor, with_states):
    path = with_states(*PROGRAM)
    other = '<tlLogic id="B" type="static" programID="0" offset="0">'
    other += '<phase duration="9" state="G"/></tlLogic>'
    text = path.read_text().replace("<tlLogic", other + "<tlLogic", 1)
    path.write_text(text.replace('tl="A0" linkIndex="0"', 'tl="B" linkIndex="0"'))
    diagnosis = doctor(path)
    assert [of_kind(diagnosis, kind)[0].place for kind in ("two-controllers", "no-vehicles")] == [
        "junction A0",
        "tlLogic B",
    ]


def test_one_controller_over_several_junctions(doctor, generate):
    options = ("--grid", "--grid.x-number", "2", "--grid.y-number", "1", "--grid.length", "40")
    options += ("--grid.attach-length", "100", "-j", "traffic_light", "--no-turnarounds")
    diagnosis = doctor(generate(*options, "--tls.join", "--tls.join-dist", "60"))
    (found,) = of_kind(diagnosis, "several-junctions")
    assert "2 junctions" in found.what
    assert diagnosis.intersections[0].junctions == 2


def test_left_hand_traffic(doctor, generate):
    options = ("--grid", "--grid.number", "2", "-j", "traffic_light")
    assert "left-hand-traffic" in kinds(doctor(generate(*options, "--lefthand")))
    assert "left-hand-traffic" not in kinds(doctor(generate(*options)))


def test_a_grid_has_no_program():
    diagnosis = examine(read_case(["grid:2x2"]))
    assert [each.place for each in of_kind(diagnosis, "no-program")] == [
        f"intersection {node.id}" for node in diagnosis.case.network.intersections
    ]


def test_a_single_phase_without_sumo():
    case = read_case(["grid:1x1"])
    (item,) = case.network.intersections
    every = frozenset().union(*item.phases)
    one = replace(item, phases=(every,), phase_names=(), program=Program((Stage(30, every),)))
    diagnosis = examine(replace(case, network=replace(case.network, intersections=(one,))))
    assert kinds(diagnosis) == ["single-action"]


def test_links_that_lead_nowhere():
    case = read_case(["grid:1x1"])
    (item,) = case.network.intersections
    kept = [j for j, movement in enumerate(item.movements) if movement.from_link != "W0>0,0"]
    phases = (frozenset(kept.index(j) for j in phase if j in kept) for phase in item.phases)
    cut = replace(
        item,
        movements=tuple(item.movements[j] for j in kept),
        phases=tuple(dict.fromkeys(phase for phase in phases if phase)),
        unsignalled=frozenset(kept.index(j) for j in item.unsignalled if j in kept),
        phase_names=(),
    )
    network = replace(case.network, intersections=(cut,))
    diagnosis = examine(replace(case, network=network, demand=None))
    (dead,) = of_kind(diagnosis, "dead-end")
    (unreachable,) = of_kind(diagnosis, "unreachable-link")
    assert dead.place == unreachable.place == "link W0>0,0"
    assert unreachable.what == "no exit is reachable from it"


def test_links_that_no_road_leads_to():
    case = read_case(["grid:1x2"])
    fringe = [node for node in case.network.fringe if node != "W0"]
    # West is no place where vehicles come from any more.
    network = replace(case.network, fringe=tuple(fringe))
    found = of_kind(examine(replace(case, network=network, demand=None)), "unreachable-link")
    assert [each.place for each in found if "from any entry" in each.what] == ["link W0>0,0"]


def test_links_shorter_than_a_vehicle():
    case = read_case(["grid:1x1"])
    first, *others = case.network.links
    for length_m, count in ((case.dynamics.vehicle_space_m - 0.1, 1), (0.0, 0)):
        network = replace(case.network, links=(replace(first, length_m=length_m), *others))
        found = of_kind(examine(replace(case, network=network, demand=None)), "short-link")
        assert [each.place for each in found] == [f"link {first.id}"] * count


def test_lanes_that_movements_with_other_greens_share(doctor):
    case = CASES / "factored-stuck" / "net.net.xml"
    (found,) = of_kind(doctor(case), "shared-lanes")
    assert (found.severity, found.place) == ("note", "intersection C")
    assert found.what.startswith("12 of its 12 movements share lanes")
    (found,) = of_kind(doctor(case), "locking-lanes")
    assert (found.severity, found.place) == ("note", "intersection C")
    assert found.what == "no phase serves all movements of lanes EC_0, NC_0, SC_0, WC_0"
    assert "guard=true" in found.mend


def test_lanes_whose_movements_go_together_in_some_phase_lock_no_rule(doctor, with_states):
    assert "locking-lanes" not in kinds(doctor(with_states(*PROGRAM)))


@pytest.mark.parametrize(("given", "plans"), [("kept", "all-stop"), ("all-stop", "kept")])
def test_another_kind_of_clearance_than_the_plans_is_a_warning(with_states, given, plans):
    """In both: the road from the north goes on, in one through the yellow of the others."""
    through = "GGgrrrGGgrrr"
    yellow = {"kept": "GGyrrrGGyrrr", "all-stop": "yyyrrryyyrrr"}[plans]
    back = {"kept": "GGgrrrGGgrrr", "all-stop": "rrrrrrrrrrrr"}[plans]
    case = read_case(
        [str(with_states((30, through), (3, yellow), (20, "GGrrrrGGrrrr"), (3, back)))]
    )
    assert "clearance-kind" not in kinds(examine(case))
    named = replace(case, timing=SignalTiming(clearance_s=3, clearance_kind=given))
    (found,) = of_kind(examine(named), "clearance-kind")
    assert found.severity == "warning"
    assert found.what == f"under a controller clearance is {given}, {plans} in its plan"
    same = replace(case, timing=SignalTiming(clearance_s=3, clearance_kind=plans))
    assert "clearance-kind" not in kinds(examine(same))
    without = replace(case, timing=SignalTiming(clearance_s=0, clearance_kind=given))
    assert "clearance-kind" not in kinds(examine(without))
