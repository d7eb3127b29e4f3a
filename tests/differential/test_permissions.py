"""Who may use which lane, in routes, queues and loads, and what SUMO makes of the same files."""

import re
import subprocess
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

import dmil
from dmil.doctor import examine, read_case
from dmil.errors import DemandError
from dmil.network.sumo.writer import sumo_program
from dmil.scenarios import SumoConfiguration, sumo_scenario
from dmil.simulation.queue import QueueSimulator
from dmil.simulation.sumo import SumoSimulator

CASES = Path(__file__).parents[1] / "cases"
BUS_LANE = CASES / "bus-lane" / "bus2.net.xml"
BUSES = '<vType id="bus" vClass="bus"/><vType id="truck" vClass="truck"/>'
NODES = """<nodes><node id="W" x="-300" y="0"/><node id="C" x="0" y="0" type="traffic_light"/>
<node id="E" x="300" y="0"/><node id="N" x="0" y="300"/><node id="S" x="0" y="-300"/></nodes>"""

pytestmark = pytest.mark.usefixtures("_sumo")


@pytest.fixture(scope="module")
def _sumo():
    pytest.importorskip("sumo", reason="needs the extra sumo")


@pytest.fixture
def built(tmp_path):
    """A function from the lanes of the road from the West, and how they lead on, to a network."""

    def build(west, connections="", name="own"):
        others = "".join(
            f'<edge id="{a}{b}" from="{a}" to="{b}" numLanes="1" speed="13.89"/>'
            for a, b in ("CW", "CE", "EC", "NC", "CN", "SC", "CS")
        )
        edges = f'<edge id="WC" from="W" to="C" speed="13.89" {west}</edge>{others}'
        texts = {"nod": NODES, "edg": f"<edges>{edges}</edges>"}
        texts["con"] = f"<connections>{connections}</connections>"
        program, environment = sumo_program("netconvert")
        command = [str(program), "--no-turnarounds", "-o", str(tmp_path / f"{name}.net.xml")]
        for kind, text in texts.items():
            (tmp_path / f"{name}.{kind}.xml").write_text(text)
            option = {"nod": "node", "edg": "edge", "con": "connection"}[kind]
            command += [f"--{option}-files", str(tmp_path / f"{name}.{kind}.xml")]
        subprocess.run(command, check=True, capture_output=True, env=environment, timeout=120)
        return tmp_path / f"{name}.net.xml"

    return build


@pytest.fixture
def scenario(tmp_path, monkeypatch):
    """A function from a network and vehicles to the scenario of 900 s."""
    monkeypatch.setenv("DMIL_CACHE", str(tmp_path / "cache"))

    def make(net, vehicles, **options):
        routes = vehicles
        if not isinstance(vehicles, Path):
            routes = tmp_path / "own.rou.xml"
            routes.write_text(f"<routes>{BUSES}{vehicles}</routes>")
        return sumo_scenario(SumoConfiguration(net, (routes,)), horizon_s=900, **options)

    return make


def drive(scenario, simulator=QueueSimulator):
    """Run the networks' own programs for all of the horizon; what the simulator measured."""
    run = simulator(scenario)
    try:
        run.reset(dmil.vehicles_of_seed(scenario, 0), 0)
        phases = np.full(len(scenario.network.intersections), -1)
        for _ in range(0, 900, scenario.timing.decision_interval_s):
            run.advance(phases)
        return run.measures(), getattr(run, "state", None)
    finally:
        getattr(run, "close", lambda: None)()


def of_sumo(net, routes, folder):
    """Run plain SUMO for 900 s: vehicles that arrived, delay per vehicle with the wait to enter."""
    program, environment = sumo_program("sumo")
    command = [str(program), "-n", str(net), "-r", str(routes), "-e", "900", "--no-step-log"]
    command += ["--time-to-teleport", "-1", "--tripinfo-output", str(folder / "trips.xml")]
    command += ["--tripinfo-output.write-unfinished", "--tripinfo-output.write-undeparted"]
    subprocess.run(command, check=True, capture_output=True, env=environment, timeout=120)
    trips = list(ElementTree.parse(folder / "trips.xml").getroot().iter("tripinfo"))
    delay_s = [float(trip.get("timeLoss")) + float(trip.get("departDelay")) for trip in trips]
    arrived = sum(float(trip.get("arrival")) >= 0 for trip in trips)
    return arrived, sum(delay_s) / len(trips), trips


def test_a_bus_lane_is_no_second_lane_for_cars(scenario, tmp_path):
    routes = CASES / "bus-lane" / "r.rou.xml"
    made = scenario(BUS_LANE, routes)
    measures, _ = drive(made)

    # The same road without the bus lane, its program in the order of the other file.
    text = (CASES / "bus-lane" / "car1.net.xml").read_text()
    stages = re.findall(r'<phase duration="\d+" *state="\w+"/>', text)
    swapped = tmp_path / "one.net.xml"
    begin, end = text.index(stages[0]), text.index(stages[-1]) + len(stages[-1])
    swapped.write_text(text[:begin] + "".join(stages[2:] + stages[:2]) + text[end:])
    alone, _ = drive(scenario(swapped, routes))

    assert measures.wait_veh_s == alone.wait_veh_s
    assert measures.arrived_veh == alone.arrived_veh == 240
    arrived, delay_s, _ = of_sumo(BUS_LANE, routes, tmp_path)
    assert (arrived, delay_s) == (245, pytest.approx(103.1, abs=0.5))
    assert measures.wait_veh_s / measures.spawned_veh == pytest.approx(delay_s, rel=0.05)


def test_the_doctor_counts_the_lane_for_cars_alone():
    diagnosis = examine(
        read_case([str(BUS_LANE), str(CASES / "bus-lane" / "r.rou.xml")], horizon_s=900)
    )

    (load,) = diagnosis.traffic.load
    assert load.degree == pytest.approx(0.74, abs=0.005)
    assert load.program_degree == pytest.approx(1.27, abs=0.005)
    assert [each.kind for each in diagnosis.findings] == ["program-beyond-capacity"]


def test_buses_pass_the_cars_on_their_lane(scenario, tmp_path):
    text = (CASES / "bus-lane" / "r.rou.xml").read_text()
    buses = '<flow id="b" type="bus" from="WC" to="CE" begin="0" end="900" vehsPerHour="60"/>'
    routes = tmp_path / "mixed.rou.xml"
    routes.write_text(text.replace("<routes>", f"<routes>{BUSES}{buses}"))
    made = scenario(BUS_LANE, routes)
    _, state = drive(made)
    vehicles = dmil.vehicles_of_seed(made, 0)
    is_bus = np.array([kind.get("type") == "bus" for kind in made.sumo.kinds])[vehicles.kind]
    west = vehicles.route_links[vehicles.route_offset[:-1]] == made.network.link_index["WC"]

    def wait_s(who):
        return float(state.waited_s[who & (state.arrived_s >= 0)].mean())

    cars_s, buses_s = wait_s(west & ~is_bus), wait_s(is_bus)
    _, _, trips = of_sumo(BUS_LANE, routes, tmp_path)
    done = [trip for trip in trips if float(trip.get("arrival")) >= 0]
    of_buses = [float(t.get("timeLoss")) for t in done if t.get("vType") == "bus"]
    assert buses_s < cars_s / 3
    assert np.mean(of_buses) < cars_s / 3


def test_the_doctor_divides_mixed_traffic_among_the_lanes_of_each(tmp_path):
    flow = '<flow id="{0}{1}" type="{1}" from="WC" to="CE" begin="0" end="900" vehsPerHour="{2}"/>'

    def degree(cars, buses):
        routes = tmp_path / "mixed.rou.xml"
        flows = flow.format("a", "DEFAULT_VEHTYPE", cars) + flow.format("b", "bus", buses)
        routes.write_text(f"<routes>{BUSES}{flows}</routes>")
        (load,) = examine(read_case([str(BUS_LANE), str(routes)], horizon_s=900)).traffic.load
        return load.degree

    # 0.5 vehicles per second and lane: 900 cars need half of the time whatever the buses do,
    # until there are more of these.
    assert degree(900, 100) == degree(900, 800) == pytest.approx(0.5, rel=0.05)
    assert degree(100, 900) == pytest.approx(500 / 1800, rel=0.05)


def test_a_footway_and_a_cycle_lane_beside_a_road_change_nothing(built, scenario):
    flow = '<flow id="f" from="WC" to="CE" begin="0" end="900" vehsPerHour="1100"/>'
    plain = built('numLanes="1">', name="plain")
    ways = '<lane index="0" allow="pedestrian"/><lane index="1" allow="bicycle"/>'
    beside = built(f'numLanes="3">{ways}', name="beside")
    one, three = scenario(plain, flow), scenario(beside, flow)

    links = {link.id: link for link in three.network.links}
    assert (links["WC"].lanes, links["WC"].open_lanes) == (3, 1)
    served = {m.lanes for m in three.network.intersections[0].movements if m.from_link == "WC"}
    assert served == {(2,)}
    measures, state = drive(three)
    assert measures.wait_veh_s == drive(one)[0].wait_veh_s > 0
    room_m = links["WC"].length_m
    assert state.occupancy_veh.max() == room_m // one.dynamics.vehicle_space_m


@pytest.mark.parametrize("routing", ["sumo", "free-flow"])
def test_random_flows_keep_off_a_road_that_is_closed_to_them(scenario, routing):
    folder = CASES / "random-flow-permission"
    made = scenario(folder / "net.net.xml", folder / "rnd.rou.xml", routing=routing)
    vehicles, links = dmil.vehicles_of_seed(made, 0), made.network.links
    ways = {" ".join(links[k].id for k in vehicles.route(v)) for v in range(len(vehicles))}

    assert ways == {"WA AD DB BE", "NA AS"}
    measures, _ = drive(made, SumoSimulator)
    assert measures.arrived_veh == measures.spawned_veh == len(vehicles)


@pytest.mark.parametrize("spacing", ['probability=".1"', 'period="exp(.1)"', 'period="10"'])
def test_each_class_looks_for_its_own_way(scenario, spacing):
    flow = '<flow id="{0}" type="{0}" from="WA" to="BE" begin="0" end="600" {1}/>'
    flows = "".join(flow.format(kind, spacing) for kind in ("bus", "truck"))
    net = CASES / "random-flow-permission" / "net.net.xml"
    made = scenario(net, flows, routing="free-flow")
    vehicles, links = dmil.vehicles_of_seed(made, 0), made.network.links
    kinds = [made.sumo.kinds[kind]["type"] for kind in vehicles.kind]
    ways = {
        (kinds[v], " ".join(links[k].id for k in vehicles.route(v))) for v in range(len(vehicles))
    }

    assert ways == {("bus", "WA AB BE"), ("truck", "WA AD DB BE")}


def test_routes_and_trips_over_a_closed_road_are_left_out_and_counted(scenario):
    net = CASES / "random-flow-permission" / "net.net.xml"
    made = scenario(
        net,
        '<vehicle id="over" depart="0"><route edges="WA AB BE"/></vehicle>'
        '<trip id="on" depart="1" from="AB" to="AB"/>'
        '<trip id="via" depart="2" from="WA" to="BE" via="AB"/>'
        '<vehicle id="ok" type="bus" depart="3"><route edges="WA AB BE"/></vehicle>',
    )

    (remark,) = (each for each in made.demand.remarks if each.kind == "no-way")
    assert (remark.count, remark.example) == (3, "over")
    assert len(dmil.vehicles_of_seed(made, 0)) == 1


TURNS = """<connection from="WC" to="CS" fromLane="0" toLane="0"/>
<connection from="WC" to="CE" fromLane="1" toLane="0"/>
<connection from="WC" to="CN" fromLane="1" toLane="0"/>"""


def test_a_class_that_only_a_turn_lane_admits_can_only_turn(built, scenario):
    net = built('numLanes="2"><lane index="1" disallow="truck"/>', TURNS)
    trip = '<trip id="{0}{1}" type="{0}" depart="{2}" from="WC" to="C{1}"/>'
    trips = "".join(
        trip.format(kind, goal, k)
        for k, (kind, goal) in enumerate(
            (kind, goal) for kind in ("truck", "DEFAULT_VEHTYPE") for goal in "SEN"
        )
    )
    made = scenario(net, trips)
    vehicles, links = dmil.vehicles_of_seed(made, 0), made.network.links
    gone = [(made.sumo.kinds[vehicles.kind[v]]["type"], links[vehicles.route(v)[-1]].id)
            for v in range(len(vehicles))]  # fmt: skip

    assert gone == [("truck", "CS"), *(("DEFAULT_VEHTYPE", f"C{goal}") for goal in "SEN")]
    (remark,) = (each for each in made.demand.remarks if each.kind == "no-way")
    assert remark.count == 2
    assert drive(made, SumoSimulator)[0].arrived_veh == 4
    assert drive(made)[0].arrived_veh == 4


def test_a_class_that_has_no_way_at_all_is_named(built, scenario):
    net = built('numLanes="1" disallow="truck">')

    with pytest.raises(DemandError, match="the network has no route for their vehicle class"):
        scenario(net, '<trip id="t" type="truck" depart="0" from="WC" to="CE"/>')


@pytest.mark.parametrize("spacing", ['probability=".2"', 'period="exp(.2)"', 'period="5"'])
def test_of_a_distribution_each_vehicle_drives_as_its_own_class(scenario, spacing):
    net = CASES / "random-flow-permission" / "net.net.xml"
    members = '<vType id="car" probability="3"/><vType id="line" vClass="bus"/>'
    made = scenario(
        net,
        f'<vTypeDistribution id="any">{members}</vTypeDistribution>'
        f'<flow id="f" type="any" from="WA" to="BE" begin="0" end="600" {spacing}/>',
        routing="free-flow",
    )
    vehicles, links = dmil.vehicles_of_seed(made, 0), made.network.links
    ways = [
        (made.sumo.kinds[vehicles.kind[v]]["type"], links[vehicles.route(v)[1]].id)
        for v in range(len(vehicles))
    ]

    assert set(ways) == {("car", "AD"), ("line", "AB")}
    assert 0.1 < sum(kind == "line" for kind, _ in ways) / len(ways) < 0.4
    assert drive(made, SumoSimulator)[0].arrived_veh == len(vehicles)


def test_of_a_distribution_with_a_number_all_depart(scenario):
    net = CASES / "random-flow-permission" / "net.net.xml"
    made = scenario(
        net,
        '<vTypeDistribution id="any" vTypes="bus truck" probabilities=".5 .5"/>'
        '<flow id="f" type="any" from="WA" to="BE" begin="0" number="40" period="exp(.2)"/>',
        routing="free-flow",
    )

    assert len(dmil.vehicles_of_seed(made, 0)) == 40
