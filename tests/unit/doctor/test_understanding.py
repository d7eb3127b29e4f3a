"""What the doctor understands: intersections, traffic, loads."""

import importlib.util
import json
import re
from dataclasses import replace
from pathlib import Path
from typing import get_args

import numpy as np
import pytest

from dmil.demand import FileDemand
from dmil.demand.sumo.remarks import TEXTS
from dmil.doctor import KINDS, examine, kinds_markdown, read_case
from dmil.doctor.intersections import shape_letter
from dmil.doctor.load import CYCLE_S, load_of
from dmil.errors import InputError, NetworkError, UnknownNameError
from dmil.network import Intersection, Movement, Program, Stage, grid
from dmil.network.sumo.records import RemarkKind
from tests.unit.cityflow.conftest import crossing_document
from tests.unit.doctor.conftest import EVERY_WAY, PROGRAM, generate  # noqa: F401

DOCS = Path(__file__).parents[3] / "docs"
SATURATION = 0.5


def test_every_remark_of_the_readers_is_a_kind_of_finding():
    assert set(get_args(RemarkKind)) <= KINDS.keys()
    assert TEXTS.keys() <= KINDS.keys()


def test_the_page_holds_every_finding():
    assert (DOCS / "doctor.md").read_text(encoding="utf-8").endswith(kinds_markdown())


def test_every_finding_is_provoked_by_a_test():
    tests = Path(__file__).parent.glob("test_*_findings.py")
    text = "".join(path.read_text(encoding="utf-8") for path in tests)
    assert [kind for kind in KINDS if f'"{kind}"' not in text] == []


def test_sentences_are_whole():
    for name, kind in KINDS.items():
        for text in (kind.meaning, kind.mend):
            assert text[0].isupper(), name
            assert text.endswith("."), name
            assert "|" not in text, name


# Intersections


def test_an_intersection_is_described(doctor, with_states):
    (item,) = doctor(with_states(*PROGRAM), EVERY_WAY, horizon_s=600).intersections
    assert (item.id, item.shape, item.alike, item.symmetries, item.junctions) == (
        "A0",
        "A",
        1,
        4,
        1,
    )
    assert [(each.name, each.link, each.lanes) for each in item.approaches] == [
        (name, f"{side}0A0.80.00", 2)
        for name, side in (("E", "right"), ("N", "top"), ("W", "left"), ("S", "bottom"))
    ]
    assert item.approaches[0].turns == (("right", 1), ("straight", 1), ("left", 1))
    assert item.movements == 12
    assert [(phase.name, phase.planned_green_s) for phase in item.phases] == [
        ("N/S F+L+R", 30.0),
        ("E/W F+L+R", 30.0),
    ]
    assert item.stages == ((30.0, 0), (3.0, None), (30.0, 1), (3.0, None))
    assert (item.program_kind, item.cycle_s, item.clearance_s) == ("static", 66.0, 3.0)
    # Ten vehicles on each of the twelve movements.
    assert item.vehicles == 120
    assert [phase.vehicles for phase in item.phases] == [60, 60]


def test_lanes_that_lead_nowhere_do_not_count(ingolstadt7):
    diagnosis = examine(replace(ingolstadt7, demand=None))
    links = {link.id: link.lanes for link in ingolstadt7.network.links}
    approaches = [each for item in diagnosis.intersections for each in item.approaches]
    assert all(each.lanes <= links[each.link] for each in approaches)
    assert any(each.lanes < links[each.link] for each in approaches)


def test_intersections_of_one_shape_have_one_letter(mixed_network):
    case = replace(read_case(["grid:2x3"]), network=mixed_network, demand=None)
    items = examine(case).intersections
    count = {item.shape: item.alike for item in items}
    assert sum(count.values()) == len(items) == 6
    assert all([item.shape for item in items].count(s) == n for s, n in count.items())
    assert items[0].shape == "A"


@pytest.mark.parametrize(("shape", "letter"), [(0, "A"), (25, "Z"), (26, "AA"), (701, "ZZ")])
def test_letters_go_on_after_z(shape, letter):
    assert shape_letter(shape) == letter


# Traffic


def test_traffic_is_counted():
    network = grid(1, 2)
    routes = [["W0>0,0", "0,0>0,1", "0,1>E0"]] * 3 + [["W0>0,0"]]
    demand = FileDemand.from_routes(network, [0, 10, 70, 130], routes)
    case = replace(read_case(["grid:1x2"]), network=network, demand=demand, begin_s=100)
    found = examine(case).traffic
    assert (found.vehicles, found.random, found.first_s, found.last_s) == (4, False, 100, 230)
    assert (found.bar_s, found.departures) == (60, (2, 1, 1, 0, 0))
    assert (found.signals_passed, found.signalled_share) == (1.5, 0.75)
    length_m = {link.id: link.length_m for link in network.links}
    assert found.length_m == pytest.approx(sum(length_m[name] for r in routes for name in r) / 4)
    assert found.links == 2.5
    assert sum(found.crossing[0]) == sum(found.crossing[1]) == 3
    assert found.entries_veh_per_s[network.link_index["W0>0,0"]] == 4 / case.horizon_s


def test_random_demand_is_said_to_be_random():
    assert examine(read_case(["grid:1x1"])).traffic.random


@pytest.mark.parametrize(("horizon_s", "bar_s"), [(300, 60), (3600, 300), (86400, 3600)])
def test_bars_are_few(doctor, with_states, horizon_s, bar_s):
    found = doctor(with_states(*PROGRAM), EVERY_WAY, horizon_s=horizon_s).traffic
    assert found.bar_s == bar_s
    assert len(found.departures) <= 40
    assert sum(found.departures) == found.vehicles


def test_the_busiest_quarter_of_an_hour_decides():
    network = grid(1, 1)
    route = ["W0>0,0", "0,0>E0"]
    depart_s = [float(k) for k in range(0, 900, 90)] + [float(k) for k in range(900, 1800, 9)]
    demand = FileDemand.from_routes(network, depart_s, [route] * len(depart_s))
    case = replace(read_case(["grid:1x1"]), network=network, demand=demand, horizon_s=2700)
    (load,) = examine(case).traffic.load
    assert sum(load.flow_veh_per_h) == pytest.approx(400, abs=8)


# Load


def crossing(*phases, lanes=((0,), (0,)), unsignalled=(), program=None):
    """Two roads that cross, each with one movement, unless there are more lanes."""
    names = "ab" if len(lanes) == 2 else "aab"
    movements = tuple(
        Movement(name, f"{name}{k}", "straight", k, each)
        for k, (name, each) in enumerate(zip(names, lanes, strict=True))
    )
    greens = tuple(frozenset(phase) for phase in phases)
    return Intersection("x", movements, greens, frozenset(unsignalled), program)


def load(item, *flows, clearance_s=0.0):
    return load_of(item, np.array(flows), SATURATION, clearance_s)


def test_critical_movements_add_up_over_phases():
    found = load(crossing({0}, {1}), 0.1, 0.2)
    assert found.phase_share == pytest.approx((0.2, 0.4))
    assert found.degree == pytest.approx(0.6)


def test_movements_of_one_phase_need_their_time_at_once():
    assert load(crossing({0, 1}), 0.1, 0.2).degree == pytest.approx(0.4)


def test_clearance_is_lost_once_per_phase_and_cycle():
    found = load(crossing({0}, {1}), 0.1, 0.2, clearance_s=6.0)
    assert found.degree == pytest.approx(0.6 / (1 - 12 / CYCLE_S))
    assert load(crossing({0}, {1}), 0.1, 0.0, clearance_s=6.0).degree == pytest.approx(0.2)


def test_lanes_share_the_vehicles_of_a_movement():
    assert load(crossing({0}, {1}, lanes=((0, 1), (0,))), 0.2, 0.0).degree == pytest.approx(0.2)
    # The second movement leaves one of the two lanes to the first.
    found = load(crossing({0, 1}, {2}, lanes=((0, 1), (1,), (0,))), 0.2, 0.2, 0.0)
    assert found.degree == pytest.approx(0.4)


def test_the_division_of_time_that_needs_least_is_found():
    # The third phase serves both at once, so the others are only for the rest.
    found = load(crossing({0}, {1}, {0, 1}), 0.1, 0.2)
    assert found.degree == pytest.approx(0.4)
    assert found.phase_share[0] == pytest.approx(0.0)


def test_movements_without_signal_need_no_time_of_their_own():
    assert load(crossing({0}, unsignalled=(1,)), 0.1, 0.4).degree == pytest.approx(0.2)


def test_the_own_program_is_judged_by_its_fullest_lane():
    program = Program((Stage(30, frozenset({0})), Stage(10, frozenset(), True)))
    found = load(crossing({0}, {1}, program=program), 0.3, 0.0)
    assert found.program_degree == pytest.approx(0.6 / (30 / 40))
    assert load(crossing({0}, {1}, program=program), 0.3, 0.1).program_degree == float("inf")
    assert load(crossing({0}, {1}), 0.3, 0.1).program_degree is None


def test_no_vehicles_need_no_time():
    found = load(crossing({0}, {1}, program=Program((Stage(30, frozenset({0})),))), 0.0, 0.0)
    assert (found.degree, found.program_degree, found.phase_share) == (0.0, 0.0, (0.0, 0.0))


# Arguments


def test_cityflow_by_folder_and_by_files_in_any_order(tmp_path):
    document, _ = crossing_document()
    (tmp_path / "roadnet.json").write_text(json.dumps(document))
    vehicle = {"length": 5.0, "minGap": 2.5, "maxSpeed": 10.0}
    flow = [
        {
            "vehicle": vehicle | {"width": 2.0, "maxPosAcc": 2.0, "maxNegAcc": 4.5},
            "route": ["W_in", "E_out"],
            "interval": 5.0,
            "startTime": 0,
            "endTime": 100,
        }
    ]
    (tmp_path / "flow.json").write_text(json.dumps(flow))
    folder = examine(read_case([str(tmp_path)]))
    files = [str(tmp_path / name) for name in ("flow.json", "roadnet.json")]
    assert examine(read_case(files)).traffic == folder.traffic
    assert folder.traffic.vehicles == 21
    assert folder.case.network.lanes_from_left
    assert [path.name for path in folder.case.files] == ["roadnet.json", "flow.json"]
    assert folder.intersections[0].program_kind == "fixed"
    alone = examine(read_case(files[1:]))
    assert (alone.traffic, len(alone.intersections)) == (None, 1)
    with pytest.raises(InputError, match="0 road networks and 1 flow"):
        read_case(files[:1])
    with pytest.raises(InputError, match="no begin"):
        read_case(files, begin_s=3)


def test_names_and_files_of_sumo_are_the_same():
    pytest.importorskip("sumolib", reason="needs the extra sumo")
    spec = importlib.util.find_spec("sumo_rl")
    folder = Path(spec.submodule_search_locations[0]) / "nets" / "RESCO" / "cologne1"
    named = examine(read_case(["resco/cologne1"]))
    configured = examine(read_case([str(folder / "cologne1.sumocfg")]))
    prefixed = examine(read_case([f"sumo:{folder / 'cologne1.sumocfg'}"]))
    files = [str(folder / f"cologne1.{kind}.xml") for kind in ("rou", "net")]
    by_files = examine(read_case(files, begin_s=25200, horizon_s=3600))
    for other in (configured, prefixed, by_files):
        assert other.traffic == named.traffic
        assert other.intersections == named.intersections
    assert named.case.name == "resco/cologne1"
    assert configured.case.name == "cologne1"


def test_vehicle_types_may_be_in_a_file_of_their_own(doctor, with_states):
    text = '<vehicle id="a" depart="0" type="t"><route edges="top0A0 top0A0.80.00"/></vehicle>'
    diagnosis = doctor(with_states(*PROGRAM), text, additional='<vType id="t" length="9"/>')
    assert diagnosis.case.dynamics.vehicle_space_m == 11.5


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        (["no-such-name"], UnknownNameError, "no scenario named"),
        (["grid:0x1"], InputError, "0"),
        (["gone.net.xml"], InputError, "gone.net.xml: there is no such file"),
        (["gone.sumocfg"], InputError, "there is no such file"),
        (["sumo:gone.sumocfg"], InputError, "there is no such file"),
        (["gone.json"], NetworkError, "gone.json"),
        (["grid:1x1", "grid:2x2"], InputError, "no such file"),
        (["resco/cologne2"], UnknownNameError, "Did you mean 'resco/cologne"),
    ],
)
def test_what_there_is_not_is_an_error(arguments, error, message):
    with pytest.raises(error, match=message):
        read_case(arguments)


def test_files_that_do_not_fit_are_errors(tmp_path, with_states):
    def write(name, text):
        path = tmp_path / name
        path.write_text(text)
        return str(path)

    net = str(with_states(*PROGRAM))
    routes = write("a.rou.xml", "<routes/>")
    with pytest.raises(InputError, match="0 configurations and 0 networks"):
        read_case([routes])
    with pytest.raises(InputError, match="0 configurations and 2 networks"):
        read_case([net, net])
    with pytest.raises(InputError, match="its root element is <svg>"):
        read_case([write("a.xml", "<svg/>")])
    with pytest.raises(InputError, match="this is not XML"):
        read_case([write("b.xml", "nothing")])
    with pytest.raises(InputError, match="the file is empty"):
        read_case([write("c.xml", "")])
    with pytest.raises(InputError, match="DOCTYPE"):
        read_case([write("d.xml", '<!DOCTYPE x [<!ENTITY a "b">]><net>&a;</net>')])
    with pytest.raises(NetworkError, match="cut off"):
        read_case([write("e.net.xml", Path(net).read_text()[:3000])])


# Nodes where vehicles come and go


@pytest.fixture
def attached(generate):  # noqa: F811
    """Three by three intersections; the twelve roads out of them end where one can turn round."""
    pytest.importorskip("sumolib", reason="needs the extra sumo")
    return generate(
        *("--grid", "--grid.number", "3", "--grid.attach-length", "200", "-L", "2"), "--tls.guess"
    )


def test_where_roads_end_is_no_junction_even_if_one_can_turn_round(doctor, attached):
    facts = doctor(attached).network
    assert (facts.intersections, facts.junctions, facts.fringe) == (9, 0, 12)


def test_vehicles_come_and_go_where_their_routes_begin_and_end(doctor, attached):
    flows = "".join(
        f'<flow id="{a}{b}" begin="0" end="600" number="50" from="{a}" to="{b}"/>'
        for a, b in (("left0A0", "C0right0"), ("left0A0", "B2top1"), ("A1B1", "C0right0"))
    )
    diagnosis = doctor(attached, flows, horizon_s=600)
    assert diagnosis.ends == {"left0", "right0", "top1", "A1"}
    assert diagnosis.network.fringe == 4
    assert diagnosis.traffic.vehicles == 150


def test_shapes_that_are_no_places_reach_no_text(doctor, attached, tmp_path):
    path = tmp_path / "odd.net.xml"
    path.write_text(re.sub(r'(<lane .*?shape=")', r"\1nan,nan inf,3 ", attached.read_text()))
    diagnosis = doctor(path)
    points = [point for line in diagnosis.case.network.line_m.values() for point in line]
    assert np.isfinite(points).all()
    assert [each.name for each in diagnosis.intersections[0].approaches] == ["E", "N", "W", "S"]
