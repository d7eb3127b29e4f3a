"""Ways that SUMO chooses for trips: asked once, kept on disk, left out where there is no SUMO."""

import importlib.metadata
import subprocess

import numpy as np
import pytest

from dmil.demand import read_sumo_routes
from dmil.demand.sumo import routing
from dmil.demand.sumo.routing import routed_by_sumo, sumo_is_installed
from dmil.errors import DemandError, MissingExtraError
from dmil.network import read_sumo_network
from dmil.network.sumo.writer import sumo_program
from dmil.seeding import stream

GRID = ("--grid", "--grid.number", "2", "--grid.attach-length", "100", "-j", "traffic_light")
SHORT, LONG = "left0A0 A0B0 B0B1 B1top1", "left0A0 A0A1 A1B1 B1top1"
TRIP = '<trip id="t{0}" depart="{0}.5" from="left0A0" to="B1top1"/>'
ENDS = (("from", "left0A0"), ("to", "B1top1"))


@pytest.fixture(scope="module")
def net(tmp_path_factory):
    pytest.importorskip("sumo", reason="needs the extra sumo")
    path = tmp_path_factory.mktemp("net") / "two.net.xml"
    program, environment = sumo_program("netgenerate")
    command = [str(program), *GRID, "--output-file", str(path)]
    subprocess.run(command, check=True, capture_output=True, env=environment, timeout=120)
    return path


@pytest.fixture
def make(net, tmp_path, monkeypatch):
    """A function that reads routes and returns what `routed_by_sumo` wants; the cache is empty."""
    monkeypatch.setenv("DMIL_CACHE", str(tmp_path / "cache"))
    network = read_sumo_network(net).network

    def run(text, **options):
        path = tmp_path / "a.rou.xml"
        path.write_text(f"<routes>{text}</routes>")
        return read_sumo_routes(path, network, **options), network, net, 600

    return run


@pytest.fixture
def kept(tmp_path):
    """A function that returns the only file of the cache."""

    def find():
        (found,) = (tmp_path / "cache").rglob("*.txt")
        return found

    return find


def ways(demand, network):
    vehicles = demand.vehicles(network, 600, stream(0))
    return [
        " ".join(network.links[link].id for link in vehicles.route(vehicle))
        for vehicle in range(len(vehicles))
    ]


def nobody_asks(*_args, **_options):
    raise AssertionError("SUMO was run")


def answers(monkeypatch, found):
    monkeypatch.setattr(routing, "_asked", lambda *_: found)


def test_only_vehicles_without_a_route_are_trips(make):
    demand, *_ = make(
        '<flow id="f" begin="0" end="10" number="2" from="left0A0" to="B1top1" via="A0A1"/>'
        '<flow id="g" begin="0" end="500" probability="0.1" from="left0A0" to="B1top1"/>'
        + TRIP.format(3)
        + f'<vehicle id="own" depart="4"><route edges="{SHORT}"/></vehicle>'
        + TRIP.format(5)
    )
    assert demand.exact_depart_s.tolist() == [0.0, 3.5, 4.0, 5.0, 5.5]
    flow = (*ENDS, ("via", "A0A1"))
    assert dict(demand.trips) == {0: flow, 1: ENDS, 3: flow, 4: ENDS}


def test_vehicles_with_routes_need_no_sumo(make, monkeypatch):
    monkeypatch.setattr(subprocess, "run", nobody_asks)
    given = make(f'<vehicle id="own" depart="4"><route edges="{SHORT}"/></vehicle>')
    assert routed_by_sumo(*given) is given[0]


def test_ways_are_taken_over_by_vehicle(make, monkeypatch):
    own = f'<vehicle id="own" depart="4"><route edges="{SHORT}"/></vehicle>'
    given = make(TRIP.format(3) + own + TRIP.format(5))
    answers(monkeypatch, {"0": tuple(LONG.split()), "2": tuple(SHORT.split())})
    found = routed_by_sumo(*given)
    assert ways(found, given[1]) == [LONG, SHORT, SHORT]
    assert found.remarks == ()
    assert ways(found.scaled(2), given[1]) == [LONG, LONG, SHORT, SHORT, SHORT, SHORT]
    np.testing.assert_array_equal(
        found.recorded.recorded.depart_s, given[0].recorded.recorded.depart_s
    )


RANDOM = '<flow id="g" begin="0" end="500" probability="0.2" from="left0A0" to="B1top1"/>'


def test_vehicles_that_depart_at_random_choose_among_the_ways_that_sumo_found(make, monkeypatch):
    given = make(RANDOM)
    assert given[0].unrouted == [ENDS]
    found = {f"0/{v}": tuple((LONG if v % 4 else SHORT).split()) for v in range(8)}
    answers(monkeypatch, found)
    routed = routed_by_sumo(*given)
    assert routed.remarks == ()
    (flow,) = routed.streams
    assert sorted(share for _, share in flow.choice) == [0.25, 0.75]
    driven = ways(routed, given[1])
    assert set(driven) == {LONG, SHORT}
    assert 0.6 < driven.count(LONG) / len(driven) < 0.9


def test_a_flow_of_which_sumo_lets_in_nobody_keeps_its_way_and_is_told(make, monkeypatch):
    given = make(RANDOM)
    answers(monkeypatch, {})
    routed = routed_by_sumo(*given)
    assert routed.streams[0].choice == given[0].streams[0].choice
    assert [(each.kind, each.example) for each in routed.remarks] == [
        ("free-flow", "left0A0 B1top1")
    ]


def test_a_flow_at_random_gets_the_ways_of_the_traffic(make, monkeypatch):
    """So many vehicles by the short way that SUMO sends some of the flow by the long one."""
    monkeypatch.setattr(routing, "LONGER_S", 300)
    jam = '<flow id="j" begin="0" end="500" period="1"><route edges="left0A0 A0B0 B0B1"/></flow>'
    routed = routed_by_sumo(*make(RANDOM + jam))
    assert routed.remarks == ()
    assert len(routed.streams[0].choice) > 1


@pytest.mark.parametrize("answer", [(), ("left0A0", "B1top1"), ("left0A0", "pavement", "B1top1")])
def test_a_trip_without_a_way_that_can_be_driven_keeps_its_own(make, monkeypatch, answer):
    given = make(TRIP.format(3) + TRIP.format(5))
    answers(monkeypatch, {"0": tuple(LONG.split())} | ({"1": answer} if answer else {}))
    found = routed_by_sumo(*given)
    assert ways(found, given[1]) == [LONG, ways(given[0], given[1])[1]]
    assert [(each.kind, each.count) for each in found.remarks] == [("free-flow", 1)]
    assert "fastest route at free flow" in found.remarks[0].text


def test_sumo_is_asked_once(make, monkeypatch, kept):
    first = routed_by_sumo(*make(TRIP.format(3) + TRIP.format(5)))
    text = kept().read_text()
    monkeypatch.setattr(subprocess, "run", nobody_asks)
    given = make(TRIP.format(3) + TRIP.format(5))
    again = routed_by_sumo(*given)
    assert ways(again, given[1]) == ways(first, given[1])
    assert (kept().read_text(), len(text.splitlines())) == (text, 3)


@pytest.mark.parametrize("change", ["vehicles", "begin", "horizon", "version", "network"])
def test_whatever_sumo_goes_by_asks_it_anew(make, monkeypatch, tmp_path, change):
    given = list(make(TRIP.format(3)))
    routed_by_sumo(*given)
    asked = []
    monkeypatch.setattr(routing, "_asked", lambda *args: asked.append(args) or {})
    if change == "vehicles":
        given = make(TRIP.format(4))
    elif change == "begin":
        given = make(TRIP.format(3), begin_s=1)
    elif change == "horizon":
        given[3] = 3
    elif change == "version":
        monkeypatch.setattr(routing, "version", lambda name: "0.1")
    else:
        other = tmp_path / "other.net.xml"
        other.write_text(given[2].read_text() + "<!-- another -->")
        given[2] = other
    routed_by_sumo(*given)
    assert len(asked) == 1


DAMAGES = {
    "cut off": lambda whole: whole[:-9],
    "another way": lambda whole: whole.replace(b"A0A1", b"A0B0"),
    "empty": lambda whole: b"",
    "no text": lambda whole: b"\xff" + whole,
    "longer": lambda whole: whole + b"x",
}


def test_a_damaged_file_is_made_anew(make, kept):
    via = '<trip id="t" depart="3" from="left0A0" to="B1top1" via="A0A1"/>'
    given = make(via)
    routed_by_sumo(*given)
    whole = kept().read_bytes()
    for name, damage in DAMAGES.items():
        assert damage(whole) != whole, name
        kept().write_bytes(damage(whole))
        assert ways(routed_by_sumo(*given), given[1]) == [LONG], name
        assert kept().read_bytes() == whole, name


def test_a_cache_that_cannot_be_written_is_done_without(make, monkeypatch, tmp_path):
    (tmp_path / "file").write_text("")
    given = make(TRIP.format(3))
    monkeypatch.setenv("DMIL_CACHE", str(tmp_path / "file"))
    assert routed_by_sumo(*given).remarks == ()


def test_what_sumo_says_against_it_is_told(make, net):
    given = make('<trip id="t" depart="3" from="left0A0" to="B1top1" departLane="7"/>')
    with pytest.raises(DemandError) as caught:
        routed_by_sumo(*given)
    message = str(caught.value)
    assert message.startswith(f"{net}: SUMO failed to route the trips: Error:")
    assert "Quitting" not in message and ".." not in message
    assert "Warning" not in message and "--routing free-flow" in message


def test_without_sumo_one_command_installs_it(make, monkeypatch):
    given = make(TRIP.format(3))
    assert sumo_is_installed()

    def absent(name):
        raise importlib.metadata.PackageNotFoundError(name)

    monkeypatch.setattr(routing, "version", absent)
    assert not sumo_is_installed()
    with pytest.raises(MissingExtraError, match=r"pip install 'dmil\[sumo\]'"):
        routed_by_sumo(*given)


def test_the_mesoscopic_model_is_asked_in_its_own_way_unless_better_is_known(make, monkeypatch):
    asked = []

    def answer(_net, _vehicles, _programs, options):
        asked.append("--mesosim" in options)
        return {"0": tuple(LONG.split())}

    monkeypatch.setattr(routing, "_asked", answer)
    given = make(TRIP.format(3))
    for _ in range(2):
        found = routed_by_sumo(*given, mesoscopic=True)
        assert ways(found, given[1]) == [LONG]
    assert asked == [True]
    routed_by_sumo(*given)
    assert asked == [True, False]
    # What the other model has said is taken from now on.
    monkeypatch.setattr(
        routing, "_kept", lambda path, kept=routing._kept: paths.append(path) or kept(path)
    )
    paths = []
    routed_by_sumo(*given, mesoscopic=True)
    assert (asked, len(paths)) == ([True, False], 1)


def test_the_mesoscopic_model_of_sumo_chooses_ways_as_well(make):
    given = make(TRIP.format(3) + TRIP.format(5))
    found = routed_by_sumo(*given, mesoscopic=True)
    assert found.remarks == ()
    assert ways(found, given[1]) == ways(routed_by_sumo(*given), given[1])


def test_who_waits_too_long_outside_of_the_mesoscopic_model_keeps_the_way_he_has(make, monkeypatch):
    crowd = "".join(TRIP.format(number).replace(f'"{number}.5"', '"0"') for number in range(1500))
    asked = []
    keep = routing._asked

    def answer(*given):
        asked.append(keep(*given))
        return asked[-1]

    monkeypatch.setattr(routing, "_asked", answer)
    found = routed_by_sumo(*make(crowd), mesoscopic=True)
    (remark,) = found.remarks
    assert (remark.kind, remark.count) == ("free-flow", 1500 - len(asked[0]))
    assert 100 < len(asked[0]) < 1000
