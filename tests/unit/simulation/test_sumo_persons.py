"""Persons that walk: they do so in SUMO as in a run of SUMO alone, and their delay is told."""

import subprocess
from xml.etree import ElementTree

import numpy as np
import pytest

from dmil.controllers import make_controller
from dmil.errors import DemandError
from dmil.rewards import make_reward
from dmil.scenarios import SumoConfiguration, sumo_scenario
from dmil.simulation import QueueSimulator, SumoSimulator
from dmil.training import evaluate, vehicles_of_seed
from tests.unit.network.conftest import sumo_binary

pytest.importorskip("libsumo", reason="needs the extra sumo")

SUMO_SEED = 23423
HORIZON_S = 600
FLOW = '<flow id="v" begin="0" end="600" period="5"><route edges="left0A0 A0B0 B0B1"/></flow>'
PERSONS = """
<vType id="slow" vClass="pedestrian" maxSpeed="0.9"/>
<personFlow id="g" type="slow" begin="20" end="600" period="9">{walk}</personFlow>
<person id="late" depart="0:02:00"><walk edges="left0A0 A0B0"/>{stop}</person>
<person id="p" depart="12"><personTrip from="left0A0" to="B0B1"/></person>
<person id="rider" depart="15"><ride from="left0A0" to="A0B0" lines="v.0"/></person>
""".format(walk='<walk from="A0B0" to="A1top0"/>', stop='<stop edge="A0B0" duration="9"/>')


@pytest.fixture(scope="module")
def network(tmp_path_factory):
    path = tmp_path_factory.mktemp("town") / "town.net.xml"
    grid = ("--grid", "--grid.number=2", "--grid.length=120", "--grid.attach-length=100")
    walks = ("--sidewalks.guess", "--crossings.guess", "--tls.guess", "-j", "traffic_light")
    command = [sumo_binary("netgenerate"), *grid, *walks, "-o", path]
    subprocess.run(command, check=True, capture_output=True)
    return path


def scenario_of(network, text):
    routes = network.with_name("town.rou.xml")
    routes.write_text(f"<routes>{text}</routes>", encoding="utf-8")
    return sumo_scenario(SumoConfiguration(network, (routes,)), horizon_s=HORIZON_S)


def run(simulator, controller="program"):
    reward, vehicles = make_reward("default"), vehicles_of_seed(simulator.scenario, 0)
    return evaluate(simulator, make_controller(controller), vehicles, reward, SUMO_SEED).measures


@pytest.fixture(scope="module")
def crowd(network):
    """A simulator of vehicles and persons."""
    made = SumoSimulator(scenario_of(network, FLOW + PERSONS))
    yield made
    made.close()


def test_they_wait_as_in_sumo_alone_and_vehicles_wait_for_them(network, crowd):
    text = FLOW + "\n".join(line for line in PERSONS.splitlines() if "rider" not in line)
    alone = network.with_name("alone.rou.xml")
    # As one file SUMO would pass over what is not sorted, so there are two.
    alone.write_text(f"<routes>{FLOW}</routes>", encoding="utf-8")
    walking = network.with_name("walking.rou.xml")
    lines = text.removeprefix(FLOW).splitlines()
    by_departure = [lines[1], lines[4], lines[2], lines[3]]
    walking.write_text(f"<routes>{''.join(by_departure)}</routes>", encoding="utf-8")
    output = network.with_name("output.xml")
    subprocess.run(
        [
            *(sumo_binary("sumo"), "-n", network, "-r", f"{alone},{walking}", "-e", str(HORIZON_S)),
            *("--tripinfo-output", output, "--tripinfo-output.write-unfinished"),
            *("--time-to-teleport", "-1", "--seed", str(SUMO_SEED)),
        ],
        check=True,
        capture_output=True,
    )
    found = ElementTree.parse(output)
    standing_s = [
        float(each.get("waitingTime"))
        for each in found.iter("personinfo")
        if each.get("depart") != "-1"
    ]
    assert len(standing_s) == 67
    with_persons = run(crowd)
    assert with_persons.person_delay_s == pytest.approx(np.mean(standing_s), rel=0.05)
    losses_s = [float(each.get("timeLoss")) for each in found.iter("tripinfo")]
    assert with_persons.time_loss_veh_s == pytest.approx(sum(losses_s), rel=0.05)


def test_a_longer_red_is_a_longer_delay(crowd):
    delays_s = [run(crowd, name).person_delay_s for name in ("fixed-cycle", "random")]
    assert min(delays_s) > 0
    assert delays_s[0] != delays_s[1]


def test_where_nobody_walks_nothing_is_known(network, crowd):
    simulator = SumoSimulator(scenario_of(network, FLOW))
    assert np.isnan(run(simulator).person_delay_s)
    simulator.close()
    assert np.isnan(run(QueueSimulator(crowd.scenario)).person_delay_s)


@pytest.mark.parametrize(
    ("person", "message"),
    [
        ('<person id="p" depart="0"/><person id="p" depart="0"/>', "another person of this id"),
        ('<person id="p" depart="soon"><walk to="A0B0"/></person>', "depart is 'soon'"),
        ('<person id="p" type="x" depart="0"><walk to="A0B0"/></person>', "vehicle type 'x'"),
        ('<person depart="0"><walk to="A0B0"/></person>', "'id' is missing"),
    ],
)
def test_what_is_wrong_with_a_person_is_told(network, person, message):
    with pytest.raises(DemandError, match=message):
        scenario_of(network, FLOW + person)
