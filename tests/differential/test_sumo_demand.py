"""The demand read from SUMO's files against SUMO itself: the same departures, the same ways."""

import subprocess
from xml.etree import ElementTree

import numpy as np
import pytest

from dmil.demand import read_sumo_routes
from dmil.demand.sumo.routing import routed_by_sumo
from dmil.network import read_sumo_network
from dmil.network.sumo.writer import sumo_program
from dmil.seeding import stream

GRID = ("--grid", "--grid.number", "3", "--grid.attach-length", "200", "--no-turnarounds")
GRID += ("-j", "traffic_light")
BEGIN_S, END_S = 10, 400
ROUTES = """<routes>
<vType id="car" length="4"/>
<route id="r" edges="left0A0 A0B0 B0C0"/>
<flow id="period" begin="0" end="60" period="7" route="r"/>
<flow id="tail" begin="300" period="9.7" route="r"/>
<trip id="unsorted" depart="299" from="left0A0" to="A0A1"/>
<flow id="number" begin="300" end="340" number="7" from="top0A2" to="C2right2"/>
<flow id="hourly" begin="300" end="340" vehsPerHour="777" from="left1A1" to="C1right1" via="B1B2"/>
<trip id="trip" type="car" depart="300.5" from="left2A2" to="C0bottom2"/>
<vehicle id="own" depart="301"><route edges="bottom0A0 A0A1 A1A2"/></vehicle>
<trip id="round" depart="302" from="A0A1" to="A0A1" via="B1B0"/>
<trip id="late" depart="399.5" from="left2A2" to="C0bottom2"/>
</routes>"""


@pytest.fixture(scope="module")
def net(tmp_path_factory):
    pytest.importorskip("sumo", reason="needs the extra sumo")
    path = tmp_path_factory.mktemp("sumo") / "grid.net.xml"
    program, environment = sumo_program("netgenerate")
    command = [str(program), *GRID, "--output-file", str(path)]
    subprocess.run(command, check=True, capture_output=True, env=environment, timeout=120)
    return path


def of_sumo(net, routes, end_s=END_S, *, in_traffic=False):
    """Run SUMO, if not said with ways independent of the traffic: intended departures, edges."""
    output = routes.with_name("output.xml")
    program, environment = sumo_program("sumo")
    command = [str(program), "--net-file", str(net), "--route-files", str(routes)]
    command += ["--begin", str(BEGIN_S), "--end", str(end_s), "--no-step-log", "--no-warnings"]
    command += ["--vehroute-output", str(output), "--vehroute-output.intended-depart"]
    command += ["--vehroute-output.write-unfinished", "--time-to-teleport", "-1"]
    if not in_traffic:
        command += ["--device.rerouting.adaptation-interval=0"]
        command += ["--device.rerouting.adaptation-steps=0"]
    subprocess.run(command, check=True, capture_output=True, env=environment, timeout=120)
    for vehicle in ElementTree.parse(output).getroot().iter("vehicle"):
        last = vehicle.findall(".//route")[-1]
        yield float(vehicle.get("depart")), vehicle.get("id"), last.get("edges")


def test_departures_and_ways_are_those_of_sumo(net, tmp_path):
    routes = tmp_path / "routes.rou.xml"
    routes.write_text(ROUTES)
    network = read_sumo_network(net).network
    demand = read_sumo_routes(routes, network, begin_s=BEGIN_S, end_s=END_S)
    vehicles = demand.vehicles(network, END_S - BEGIN_S, stream(0))
    ours = sorted(
        (int(second), " ".join(network.links[k].id for k in vehicles.route(vehicle)))
        for vehicle, second in enumerate(vehicles.depart_s)
    )
    theirs = sorted((int(np.ceil(s)) - BEGIN_S, edges) for s, _, edges in of_sumo(net, routes))
    assert len(ours) > 25
    assert ours == theirs
    remarks = {remark.kind: (remark.count, remark.example) for remark in demand.remarks}
    assert remarks == {
        "before-begin": (2, "period"),
        "after-end": (1, "late"),
        "unsorted": (1, "unsorted"),
    }


def test_ways_in_traffic_are_those_of_sumo(net, tmp_path, monkeypatch):
    monkeypatch.setenv("DMIL_CACHE", str(tmp_path))
    own = '<route edges="left1A1 A1B1 B1C1 C1right1"/></vehicle>'
    crowd = "".join(
        f'<trip id="t{k}" type="car" depart="{10.3 + 2.5 * k}" from="left{k % 3}A{k % 3}" '
        f'to="C{k % 2}right{k % 2}" departLane="best"/><vehicle id="v{k}" depart="{12 + 2.5 * k}">'
        f"{own}"
        for k in range(150)
    )
    routes = tmp_path / "routes.rou.xml"
    routes.write_text(f'<routes><vType id="car" length="4"/>{crowd}</routes>')
    network = read_sumo_network(net).network
    demand = read_sumo_routes(routes, network, begin_s=BEGIN_S, end_s=END_S)
    routed = routed_by_sumo(demand, network, net, END_S - BEGIN_S)
    assert routed.remarks == demand.remarks

    def ways(each):
        found = each.vehicles(network, END_S - BEGIN_S, stream(0))
        return sorted(
            (int(second), " ".join(network.links[k].id for k in found.route(vehicle)))
            for vehicle, second in enumerate(found.depart_s)
        )

    theirs = sorted(
        (int(np.ceil(s)) - BEGIN_S, edges)
        for s, _, edges in of_sumo(net, routes, END_S + 1800, in_traffic=True)
    )
    assert ways(routed) == theirs
    detours = sum(one != other for one, other in zip(ways(demand), theirs, strict=True))
    assert detours > 10
