"""Junctions without signals in the queue simulator: gaps, turns, lanes that end, full links."""

import subprocess
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest

from dmil.demand import FileDemand
from dmil.network import Intersection, Junction, Link, Movement, RoadNetwork, check_network
from dmil.scenarios import QueueDynamics, SumoConfiguration, scenario, sumo_scenario
from dmil.seeding import stream
from dmil.simulation import QueueSimulator
from dmil.simulation.queue.gaps import gap_of, junctions_that_hold
from dmil.training.phases import vehicles_of_seed
from tests.unit.network.conftest import sumo_binary


def way(first, second, turn="straight", approach=0, lanes=(0,)):
    return Movement(first, second, turn, approach, lanes)


def roads(lengths_m, junctions, signal, *, lanes=None, dynamics=None):
    """A scenario of links at 10 m/s, with one signal X of one phase for each of its movements."""
    lanes = lanes or {}
    links = tuple(
        Link(id, *id.split(">"), length_m, 10.0, lanes.get(id, 1))
        for id, length_m in lengths_m.items()
    )
    phases = tuple(frozenset({k}) for k in range(len(signal)))
    nodes = {node for link in links for node in (link.start, link.end)}
    inner = {"X", *(junction.id for junction in junctions)}
    network = RoadNetwork(
        "roads",
        links,
        (Intersection("X", signal, phases, frozenset()),),
        tuple(sorted(nodes - inner)),
        dict.fromkeys(nodes, (0.0, 0.0)),
        junctions=junctions,
    )
    check_network(network)
    return replace(
        scenario("grid:1x1"), network=network, dynamics=dynamics or QueueDynamics(), horizon_s=60
    )


def run(made, *journeys, phase=0):
    """Drive (departure, link ids) to the end; return simulator and last observation."""
    seconds, routes = zip(*journeys, strict=True)
    demand = FileDemand.from_routes(made.network, seconds, routes)
    simulator = QueueSimulator(made)
    simulator.reset(demand.vehicles(made.network, 999, stream(0, "no")))
    for _ in range(6):
        observation = simulator.advance(np.array([phase]))
    return simulator, observation


@pytest.fixture
def merge():
    """P>J goes first, Q>J gives way; both on to the signal X."""
    ways = (way("P>J", "J>X"), way("Q>J", "J>X", approach=1))
    return roads(
        {"P>J": 30.0, "Q>J": 20.0, "J>X": 50.0, "X>Z": 10.0},
        (Junction("J", ways, ((), (0,))),),
        (way("J>X", "X>Z"),),
    )


def test_who_gives_way_waits_for_the_critical_gap_and_follows_in_it(merge):
    route = ["J>X", "X>Z"]
    major = [(t, ["P>J", *route]) for t in (0, 3, 6)]
    simulator, observation = run(merge, *major, (0, ["Q>J", *route]), (0, ["Q>J", *route]))
    state = simulator.state
    # At the junction at 2 s; others come at 3, 6 and 9 s, each less than 6.5 s after the one
    # before. The first goes behind the last of them and waits 1 s behind it at the signal, the
    # second follows after 4 s.
    waits = sorted(state.waited_s.tolist())
    assert waits[-2:] == [8, 11]
    assert simulator.measures().time_loss_veh_s >= 19
    # Visits are those of intersections, and controllers see queues there only.
    assert simulator.measures().visits == 5
    assert observation.queue_veh.shape == observation.waiting_veh.shape == (1, 1)
    assert simulator.passed_veh().tolist() == [5]


def test_gaps_are_those_of_the_manual():
    ways = (
        *(way("E", "W"), way("E", "S", "left")),
        *(way("W", "S", "right"), way("W", "E")),
        *(way("S", "E", "right"), way("S", "W", "left")),
    )
    tee = Junction("T", ways, ((), (2, 3), (), (), (3,), (0, 1, 3)))
    assert [gap_of(tee, j) for j in (1, 4, 5)] == [(4.1, 2.2), (6.2, 3.3), (7.1, 3.5)]
    entry = Junction("R", (way("A", "C", "left"), way("B", "C", "right")), ((), (0,)))
    critical_s, follow_s = gap_of(entry, 1)
    # Siegloch: exp(-q (critical - follow / 2)) / follow; the HCM's roundabout: 1380, 0.00102.
    assert 3600 / follow_s == pytest.approx(1380, rel=0.001)
    assert (critical_s - follow_s / 2) / 3600 == pytest.approx(0.00102, rel=0.002)
    stop = Junction("S", (way("A", "C"), way("B", "D")), ((1,), (0,)))
    assert gap_of(stop, 0) == gap_of(stop, 1) == (2.9, 3.9)


def test_at_an_all_way_stop_roads_take_turns():
    lengths_m = {"P>J": 20.0, "J>X": 50.0, "X>Z": 10.0, "Q>J": 20.0, "J>R": 50.0}
    ways = (way("P>J", "J>X"), way("Q>J", "J>R", approach=1))
    made = roads(lengths_m, (Junction("J", ways, ((1,), (0,))),), (way("J>X", "X>Z"),))
    simulator, _ = run(made, *[(0, ["P>J", "J>X", "X>Z"])] * 4, *[(0, ["Q>J", "J>R"])] * 4)
    arrived = np.sort(simulator.state.arrived_s)
    # Both have a queue from 2 s on: one of the two every 3 s, so the last goes 7 turns later.
    assert simulator.state.waited_s.max() == 7 * 3
    assert arrived[-1] > 0


def test_lanes_that_end_hold_up():
    # Three lanes, of which two go on: 20 vehicles need 10 s, one a second on each lane.
    ways = (way("P>J", "J>X", lanes=(1, 2)),)
    made = roads(
        {"P>J": 100.0, "J>X": 100.0, "X>Z": 10.0},
        (Junction("J", ways),),
        (way("J>X", "X>Z", lanes=(0, 1)),),
        lanes={"P>J": 3, "J>X": 2, "X>Z": 2},
    )
    assert [junction.id for junction in junctions_that_hold(made.network, storage=False)] == ["J"]
    simulator, _ = run(made, *[(0, ["P>J", "J>X", "X>Z"])] * 20)
    assert simulator.state.waited_s.sum() == 2 * sum(range(10))
    wide = replace(made.network, links=tuple(replace(each, lanes=2) for each in made.network.links))
    whole = replace(wide, junctions=(Junction("J", (way("P>J", "J>X", lanes=(0, 1)),)),))
    assert junctions_that_hold(whole, storage=False) == ()


def test_who_wants_into_a_full_link_holds_up_those_behind_in_his_lane():
    ways = (way("P>J", "J>X"), way("P>J", "J>R", "right"))
    made = roads(
        {"P>J": 200.0, "J>X": 20.0, "X>Z": 10.0, "J>R": 50.0, "Y>X": 50.0},
        (Junction("J", ways),),
        (way("J>X", "X>Z"), way("Y>X", "X>Z", approach=1)),
        dynamics=QueueDynamics(storage=True, vehicle_space_m=10.0),
    )
    # The signal shows red to J>X, where two have room; the third waits before it, and so does
    # who wants to turn right behind him.
    journeys = [(0, ["P>J", "J>X", "X>Z"])] * 3 + [(1, ["P>J", "J>R"])]
    assert run(made, *journeys, phase=1)[0].state.arrived_s[-1] == -1
    assert run(made, *journeys[1:], phase=1)[0].state.arrived_s[-1] > 0


@pytest.mark.parametrize("major_veh_per_h", [900, 1200])
def test_a_side_road_waits_about_as_long_as_in_sumo(tmp_path, major_veh_per_h):
    pytest.importorskip("sumo", reason="needs the extra sumo")
    nodes = {"W": (-500, 0), "S": (0, -500), "J": (0, 0), "E": (500, 0), "X": (1500, 0)}
    nodes |= {"Z": (1700, 0), "Y": (1500, 300)}
    roads_of = {"WJ": 9, "JE": 9, "SJ": 3, "EX": 9, "XZ": 9, "YX": 5}
    text = "".join(
        f'<node id="{name}" x="{x}" y="{y}" type="{kind}"/>'
        for name, (x, y) in nodes.items()
        for kind in ["traffic_light" if name == "X" else "priority"]
    )
    (tmp_path / "a.nod.xml").write_text(f"<nodes>{text}</nodes>")
    text = "".join(
        f'<edge id="{a}{b}" from="{a}" to="{b}" numLanes="1" speed="13.9" priority="{rank}"/>'
        for (a, b), rank in roads_of.items()
    )
    (tmp_path / "a.edg.xml").write_text(f"<edges>{text}</edges>")
    rng = np.random.default_rng(3)
    major_s = np.cumsum(rng.exponential(3600 / major_veh_per_h, major_veh_per_h // 2))
    side_s = np.cumsum(rng.exponential(24.0, 75))
    both = sorted([(t, "m", "WJ") for t in major_s] + [(t, "s", "SJ") for t in side_s])
    text = "".join(
        f'<vehicle id="{kind}{k}" depart="{t:.1f}" departSpeed="max"><route edges="{link} JE"/>'
        "</vehicle>"
        for k, (t, kind, link) in enumerate(both)
    )
    (tmp_path / "a.rou.xml").write_text(f"<routes>{text}</routes>")

    def call(program, *options):
        command = [sumo_binary(program), *options]
        subprocess.run(command, check=True, capture_output=True, timeout=120, cwd=tmp_path)

    call("netconvert", "-n", "a.nod.xml", "-e", "a.edg.xml", "-o", "a.net.xml")
    call("sumo", "-n", "a.net.xml", "-r", "a.rou.xml", "--tripinfo-output", "trips.xml")
    trips = ElementTree.parse(tmp_path / "trips.xml").getroot().iter("tripinfo")
    late_s = [
        float(trip.get("timeLoss")) + float(trip.get("departDelay"))
        for trip in trips
        if trip.get("id").startswith("s")
    ]
    net, routes = tmp_path / "a.net.xml", tmp_path / "a.rou.xml"
    made = sumo_scenario(SumoConfiguration(net, (routes,), ()), begin_s=0, horizon_s=3600)
    simulator = QueueSimulator(made)
    simulator.reset(vehicles_of_seed(made, 0))
    for _ in range(360):
        simulator.advance(np.array([0]))
    of_side = np.array([kind == "s" for _, kind, _ in both])
    waited_s = float(simulator.state.waited_s[of_side].mean())
    assert 0.1 * np.mean(late_s) < waited_s < 1.5 * np.mean(late_s)
