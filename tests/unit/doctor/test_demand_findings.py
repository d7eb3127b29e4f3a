"""What the doctor finds about vehicles, and about what they ask of the signals."""

import json

import pytest

from dmil.doctor import examine, read_case
from dmil.errors import DemandError, InputError
from tests.unit.cityflow.conftest import crossing_document
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

ROUTE = '<route edges="top0A0 top0A0.80.00 A0bottom0"/>'


def vehicle(name, depart, inside=ROUTE, attributes=""):
    return f'<vehicle id="{name}" depart="{depart}" {attributes}>{inside}</vehicle>'


def trip(name, depart, attributes):
    return f'<trip id="{name}" depart="{depart}" {attributes}/>'


def with_device(name):
    return vehicle("b", 1, f'{ROUTE}<param key="has.{name}.device" value="true"/>')


def flow(name, begin, end, number, start="top", goal="bottom"):
    return (
        f'<flow id="{name}" begin="{begin}" end="{end}" number="{number}" from="{start}0A0" '
        f'to="A0{goal}0"/>'
    )


WAY = 'from="top0A0" to="A0bottom0"'
STOP = '<stop lane="top0A0_0" duration="9"/>'


@pytest.mark.parametrize(
    ("kind", "severity", "text", "what"),
    [
        (
            "unknown-road",
            "error",
            trip("b", 1, 'from="top0A0" to="Z"') + "".join(vehicle(f"c{k}", 2) for k in range(9)),
            "1 go over an edge",
        ),
        ("no-way", "error", trip("b", 1, 'from="A0top0" to="top0A0"'), "1 cannot be simulated"),
        ("unsorted", "warning", vehicle("b", 9) + vehicle("c", 3), "1 stand after others"),
        ("no-fixed-departure", "warning", vehicle("b", "triggered"), "1 have no departure"),
        ("zone", "warning", trip("b", 1, 'fromTaz="x" toTaz="y"'), "1 begin or end in a zone"),
        (
            "stops-only",
            "warning",
            '<trip id="b" depart="1" from="top0A0"><stop edge="A0top0" duration="3"/></trip>',
            "1 have stops instead",
        ),
        ("signal-program", "warning", '<tlLogic id="A0" programID="x"/>', "1 programs of signals"),
        (
            "no-road-vehicle",
            "note",
            '<vType id="bike" vClass="bicycle"/>' + vehicle("b", 1, attributes='type="bike"'),
            "1 are bicycles",
        ),
        (
            "person",
            "warning",
            '<person id="p" depart="1"><walk edges="top0A0"/></person>',
            "1 are persons, which walk in the SUMO simulator only",
        ),
        ("person-elsewhere", "warning", '<person id="p" depart="1"/>', "1 are persons that ride"),
        ("container", "warning", '<container id="p" depart="1"/>', "1 are containers"),
        ("stops", "warning", vehicle("b", 1, ROUTE + STOP), "1 have stops"),
        ("stops-off", "warning", vehicle("b", 1, ROUTE + STOP.replace("top0A0", "A0A1")), "1 have"),
        ("parameters", "note", vehicle("b", 1, ROUTE + '<param key="k" value="v"/>'), "parameters"),
        ("route-part", "note", vehicle("b", 1, attributes='departEdge="1"'), "within their route"),
        ("rerouter", "warning", '<rerouter id="r" edges="top0A0"/>', "1 are rerouters"),
        ("calibrator", "warning", '<calibrator id="r" edge="top0A0"/>', "1 are calibrators"),
        ("speed-sign", "warning", '<variableSpeedSign id="r" lanes="top0A0_0"/>', "1 are signs"),
        ("rerouting-device", "warning", with_device("rerouting"), "(rerouting), which only SUMO"),
        ("taxi-device", "warning", with_device("taxi"), "(taxi), which is switched off"),
        ("driving-device", "warning", with_device("glosa"), "1 have devices that change how"),
    ],
    ids=lambda value: value if isinstance(value, str) and value.replace("-", "").isalpha() else "",
)
def test_what_the_reader_left_aside(doctor, with_states, kind, severity, text, what):
    diagnosis = doctor(with_states(*PROGRAM), vehicle("a", 0) + text, horizon_s=600)
    (found,) = of_kind(diagnosis, kind)
    assert found.severity == severity
    assert what in found.what
    assert ";" not in found.what  # the mend stands by itself
    assert diagnosis.traffic.vehicles >= 1


def test_the_road_that_is_missing_is_named(doctor, with_states):
    many = "".join(vehicle(f"c{k}", 2) for k in range(9))
    text = trip("b", 1, 'from="top0A0" to="Z"') + many
    (found,) = of_kind(doctor(with_states(*PROGRAM), text), "unknown-road")
    assert found.place == "first 'b' at 'Z'"


@pytest.mark.parametrize(("routing", "count"), [("free-flow", 1), ("sumo", 0), (None, 0)])
def test_trips_that_drive_as_on_empty_roads(doctor, with_states, routing, count):
    pytest.importorskip("sumo", reason="needs the extra sumo")
    diagnosis = doctor(with_states(*PROGRAM), trip("a", 0, WAY), routing=routing)
    assert len(of_kind(diagnosis, "free-flow")) == count


@pytest.mark.parametrize(
    ("attribute", "routing", "said"),
    [
        ('departSpeed="99"', None, "Departure speed"),
        ('departLane="99"', "sumo", "departLane"),  # its mesoscopic model has no lanes
    ],
)
def test_files_that_sumo_itself_refuses(doctor, with_states, attribute, routing, said):
    pytest.importorskip("sumo", reason="needs the extra sumo")
    text = trip("a", 0, f"{WAY} {attribute}")
    (found,) = of_kind(doctor(with_states(*PROGRAM), text, routing=routing), "sumo-refuses")
    assert found.severity == "error"
    assert said in found.what
    assert of_kind(doctor(with_states(*PROGRAM), text, routing="free-flow"), "sumo-refuses") == []


@pytest.mark.parametrize(("outside", "severity"), [(1, "note"), (9, "warning")])
def test_vehicles_outside_of_the_run(doctor, with_states, outside, severity):
    early = "".join(vehicle(f"e{k}", k) for k in range(outside))
    inside = "".join(vehicle(f"i{k}", 100 + k) for k in range(90))
    late = "".join(vehicle(f"l{k}", 900 + k) for k in range(outside))
    text, net = early + inside + late, with_states(*PROGRAM)
    diagnosis = doctor(net, text, begin_s=100, horizon_s=600)
    for kind in ("before-begin", "after-end"):
        (found,) = of_kind(diagnosis, kind)
        assert (found.severity, found.what.split()[0]) == (severity, str(outside))


@pytest.mark.parametrize(("begin_s", "horizon_s"), [(0, 600), (40_000, None), (40_000, 60)])
def test_a_run_without_vehicles_is_a_finding_with_its_mend(doctor, with_states, begin_s, horizon_s):
    text = vehicle("a", 25_205) + vehicle("b", 25_300)
    diagnosis = doctor(with_states(*PROGRAM), text, begin_s=begin_s, horizon_s=horizon_s)
    (found,) = of_kind(diagnosis, "no-vehicle-in-time")
    assert found.severity == "error"
    assert "the first is at 25205 s" in found.what
    assert "25205 (--begin)" in found.mend
    # What is said about the demand is about all of it.
    assert (diagnosis.traffic.vehicles, diagnosis.traffic.first_s) == (2, 25_205)
    assert "late-start" not in kinds(diagnosis)


def test_a_flow_without_end_is_looked_at_for_an_hour(doctor, with_states):
    text = f'<flow id="f" begin="0" period="10" {WAY}/>'
    diagnosis = doctor(with_states(*PROGRAM), text)
    (found,) = of_kind(diagnosis, "endless")
    assert "flow 'f': it has no end, nor has the run" in found.what
    assert diagnosis.traffic.vehicles == 360
    assert "endless" not in kinds(doctor(with_states(*PROGRAM), text, horizon_s=600))


def test_flows_without_end_that_begin_too_late(tmp_path, doctor, with_states):
    net = with_states(*PROGRAM)
    (tmp_path / "f.rou.xml").write_text(
        f'<routes><flow id="f" begin="500" period="10" {WAY}/></routes>'
    )
    path = tmp_path / "f.sumocfg"
    path.write_text(
        f'<configuration><input><net-file value="{net.name}"/>'
        '<route-files value="f.rou.xml"/></input>'
        '<time><begin value="0"/><end value="900"/></time></configuration>'
    )
    diagnosis = examine(read_case([str(path)], horizon_s=300))
    assert kinds(diagnosis)[0] == "no-vehicle-in-time"
    assert diagnosis.traffic.vehicles == 40


def test_files_that_cannot_be_read_are_errors_as_everywhere(doctor, with_states):
    net = with_states(*PROGRAM)
    for text, message in (
        ('<vehicle id="a" depart="soon"/>', "depart"),
        (vehicle("a", 0, '<route edges="x y"/>'), "which the network 'own' does not have"),
        ("", "no vehicle"),
    ):
        with pytest.raises(DemandError, match=message):
            doctor(net, text)


@pytest.mark.parametrize(("begin_s", "expected"), [(0, True), (399, True), (400, False)])
def test_a_late_start(doctor, with_states, begin_s, expected):
    diagnosis = doctor(with_states(*PROGRAM), vehicle("a", 1000), begin_s=begin_s)
    found = of_kind(diagnosis, "late-start")
    assert bool(found) == expected
    assert all(each.mend == "Set the begin to it: --begin 1000." for each in found)


@pytest.mark.parametrize(("horizon_s", "expected"), [(3600, False), (3700, True)])
def test_a_long_end(doctor, with_states, horizon_s, expected):
    diagnosis = doctor(with_states(*PROGRAM), vehicle("a", 0), horizon_s=horizon_s)
    assert ("long-end" in kinds(diagnosis)) == expected


def test_more_vehicles_than_signals_can_serve(doctor, with_states):
    both = flow("n", 0, 900, 400) + flow("w", 0, 900, 400, "left", "right")
    diagnosis = doctor(with_states(*PROGRAM), both, horizon_s=900)
    (found,) = of_kind(diagnosis, "demand-beyond-capacity")
    # Each of the two streams needs 400 of the 450 vehicles that a lane can serve in 900 s.
    assert diagnosis.intersections[0].load.degree == pytest.approx(
        (8 / 9 * 2) / (1 - 6 / 120), 0.05
    )
    assert found.severity == "warning"
    assert "program-beyond-capacity" not in kinds(diagnosis)


def test_more_vehicles_than_the_own_program_can_serve(doctor, with_states):
    stages = ((90, NS), (3, CLEAR_NS), (5, EW), (3, CLEAR_EW))
    diagnosis = doctor(with_states(*stages), flow("w", 0, 900, 90, "left", "right"), horizon_s=900)
    (found,) = of_kind(diagnosis, "program-beyond-capacity")
    assert "times the green that they have" in found.what
    assert "demand-beyond-capacity" not in kinds(diagnosis)
    never = doctor(
        with_states((90, "GGrrrrGGgrrr"), *PROGRAM[1:]),
        flow("n", 0, 900, 9, "top", "right"),
        horizon_s=900,
    )
    (found,) = of_kind(never, "program-beyond-capacity")
    assert "green but get none" in found.what


@pytest.mark.parametrize(("number", "expected"), [(440, False), (460, True)])
def test_more_vehicles_than_a_link_takes(doctor, with_states, number, expected):
    diagnosis = doctor(with_states(*PROGRAM), flow("n", 0, 900, number), horizon_s=900)
    found = of_kind(diagnosis, "entry-beyond-capacity")
    assert [each.place for each in found] == ["link top0A0"] * expected


def test_intersections_and_phases_that_nobody_needs(doctor, generate, with_states):
    (idle,) = of_kind(doctor(with_states(*PROGRAM), vehicle("a", 0)), "idle-phase")
    assert "phase 1 (E/W F+L+R)" in idle.what
    options = ("--grid", "--grid.x-number", "2", "--grid.y-number", "1")
    options += ("--grid.attach-length", "100", "-j", "traffic_light", "--no-turnarounds")
    net = generate(*options)
    diagnosis = doctor(net, trip("a", 0, 'from="top0A0" to="A0left0"'))
    (found,) = of_kind(diagnosis, "idle-intersection")
    assert found.place == "intersection B0"
    assert all(each.place != "intersection B0" for each in of_kind(diagnosis, "idle-phase"))


@pytest.mark.parametrize(("without", "expected"), [(1, False), (2, True)])
def test_vehicles_that_pass_no_signal(doctor, with_states, without, expected):
    short = '<route edges="top0A0 top0A0.80.00"/>'
    text = "".join(vehicle(f"s{k}", 0, short) for k in range(without)) + vehicle("a", 0)
    diagnosis = doctor(with_states(*PROGRAM), text)
    assert ("few-pass-signals" in kinds(diagnosis)) == expected


def test_options_that_are_not_used(tmp_path, with_states):
    net = with_states(*PROGRAM)
    (tmp_path / "a.rou.xml").write_text(f"<routes>{vehicle('a', 0)}</routes>")
    path = tmp_path / "a.sumocfg"
    path.write_text(
        f'<configuration><input><net-file value="{net.name}"/><route-files value="a.rou.xml"/>'
        '</input><processing><max-depart-delay value="60"/></processing></configuration>'
    )
    (found,) = of_kind(examine(read_case([str(path)])), "option-not-used")
    assert found.what == "max-depart-delay=60"


def test_an_end_before_the_begin_is_an_error(doctor, with_states):
    with pytest.raises(InputError, match="end after the beginning"):
        doctor(with_states(*PROGRAM), EVERY_WAY, horizon_s=0)


def test_what_cityflow_drops_is_found(tmp_path):
    (tmp_path / "roads.json").write_text(json.dumps(crossing_document()[0]))
    times = [(["E_in", "W_out"], 0, 60), (["E_in", "E_out"], 0, 9), (["E_in"], 0, 3)]
    times.append((["E_in", "W_out"], 9, 8))
    flows = [
        {"route": route, "interval": 1, "startTime": start, "endTime": end}
        for route, start, end in times
    ]
    (tmp_path / "cars.json").write_text(json.dumps(flows))
    found = examine(read_case([str(tmp_path / "roads.json"), str(tmp_path / "cars.json")]))
    (way,) = of_kind(found, "no-way")
    assert way.severity == "error"
    assert way.what.startswith("10 cannot be simulated")
    assert way.place == "first '[1]' at 'E_in'"
    assert [each.what[:1] for each in of_kind(found, "one-road")] == ["4"]
    assert [each.severity for each in of_kind(found, "ends-first")] == ["warning"]


def test_most_vehicles_may_have_to_give_way_without_a_signal(doctor, generate):
    # Three junctions in a row, the one in the middle without signals.
    options = ("--grid", "--grid.x-number", "3", "--grid.y-number", "1", "--no-turnarounds")
    options += ("--grid.attach-length", "100", "--tls.set", "A0,C0")
    net = generate(*options)
    through = trip("a", 0, 'from="left0A0" to="C0right0"') + trip(
        "b", 5, 'from="left0A0" to="B0top1"'
    )
    (found,) = of_kind(doctor(net, through), "give-way")
    assert (found.severity, found.what) == ("note", "100% of the vehicles")
    beside = "".join(trip(f"c{k}", 9, 'from="left0A0" to="A0top0"') for k in range(2))
    assert of_kind(doctor(net, through + beside), "give-way") == []
