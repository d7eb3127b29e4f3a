"""What only SUMO drives and follows, beside what a plain ``sumo`` does with the same files.

Nothing is random in these vehicles, so the two runs are the same.
"""

import importlib.util
import subprocess
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from dmil.controllers import make_controller
from dmil.network.sumo.writer import sumo_program
from dmil.rewards import make_reward
from dmil.scenarios import read_sumo_configuration, sumo_scenario
from dmil.simulation import QueueSimulator, SumoSimulator
from dmil.simulation.sumo.files import together
from dmil.simulation.sumo.survey import SurveyFiles
from dmil.simulation.timing import PROGRAM
from dmil.training import evaluate, vehicles_of_seed

pytestmark = pytest.mark.skipif(
    importlib.util.find_spec("libsumo") is None, reason="needs the extra sumo"
)

NET = Path(__file__).parents[2] / "cases/rerouting-device/net.net.xml"
EDGES = "WA AB BC CE"
"""One lane each, with a signal at B; the way by D is 1.3 km longer."""
ROUTE = f'<vType id="c" sigma="0" speedDev="0"/><route id="r" edges="{EDGES}"/>'
CARS = '<flow id="c" type="c" route="r" begin="1" end="600" period="9"/>'
BICYCLES = (
    '<vType id="b" vClass="bicycle" sigma="0" speedDev="0"/>'
    '<flow id="b" type="b" route="r" begin="0" end="600" period="20" departLane="0"/>'
)


@pytest.fixture
def files(tmp_path):
    """Writes a configuration of some routes and additional definitions."""

    def write(routes, additional="", options=""):
        (tmp_path / "r.rou.xml").write_text(f"<routes>{routes}</routes>")
        (tmp_path / "a.add.xml").write_text(f"<additional>{additional}</additional>")
        path = tmp_path / "c.sumocfg"
        path.write_text(
            f'<configuration><net-file value="{NET}"/><route-files value="r.rou.xml"/>'
            f'<additional-files value="a.add.xml"/><end value="640"/>{options}</configuration>'
        )
        return path

    return write


def plain(path):
    """Return arrivals and delay of the cars in a plain ``sumo``."""
    program, environment = sumo_program("sumo")
    output = path.with_name("trips.xml")
    command = [str(program), "-c", str(path), "--no-step-log"]
    command += ["--tripinfo-output", str(output), "--tripinfo-output.write-unfinished"]
    command += ["--tripinfo-output.write-undeparted"]
    subprocess.run(command, check=True, env=environment, capture_output=True)
    trips = [each.attrib for each in ElementTree.parse(output).getroot()]
    cars = [trip for trip in trips if trip["vType"] != "b"]
    lost_s = sum(max(0, float(car["timeLoss"])) + float(car["departDelay"]) for car in cars)
    return sum(float(car["arrival"]) >= 0 for car in cars), lost_s / len(cars)


def ours(path, kind=SumoSimulator):
    """Return the same of a run under the file's plan."""
    scenario = sumo_scenario(path)
    simulator = kind(scenario)
    simulator.reset(vehicles_of_seed(scenario, 0))
    while simulator.measures().time_s < scenario.horizon_s:
        simulator.advance(np.full(len(scenario.network.intersections), PROGRAM, np.int32))
    measures = simulator.measures()
    if isinstance(simulator, SumoSimulator):
        simulator.close()
    return measures.arrived_veh, measures.delay_s


def test_cars_meet_bicycles_and_buses_at_stops_which_are_in_no_queue(files):
    undisturbed_s = ours(files(ROUTE + CARS))[1]
    path = files(ROUTE + BICYCLES + CARS)
    arrived, delay_s = ours(path)
    assert (arrived, delay_s) == pytest.approx(plain(path), abs=0.1)
    assert delay_s > undisturbed_s + 5
    stop = '<stop lane="AB_0" endPos="90" duration="120"/>'
    bus = f'<vehicle id="bus" type="c" depart="0"><route edges="{EDGES}"/>{stop}</vehicle>'
    path = files(ROUTE + bus + CARS)
    arrived, delay_s = ours(path)
    assert (arrived, delay_s) == pytest.approx(plain(path), abs=0.01)
    assert delay_s > undisturbed_s + 3
    scenario = sumo_scenario(files(ROUTE + bus))
    simulator = SumoSimulator(scenario)
    simulator.reset(vehicles_of_seed(scenario, 0))
    programs = np.full(len(scenario.network.intersections), PROGRAM, np.int32)
    seen = [simulator.advance(programs) for _ in range(12)]
    simulator.close()
    standing = [int(each.queue_veh.sum()) for each in seen]
    assert standing[6:] == [0] * 6  # it stands there from before 60 s until after 120 s


def test_rerouters_send_vehicles_elsewhere_in_sumo_alone(files):
    long = (
        '<route id="long" edges="WA AD DC CE"/><rerouter id="w" edges="WA">'
        '<interval begin="0" end="640"><routeProbReroute id="long"/></interval></rerouter>'
    )
    path = files(ROUTE + CARS, long)
    arrived, delay_s = ours(path)
    assert (arrived, delay_s) == pytest.approx(plain(path), abs=0.01)
    assert ours(path, QueueSimulator)[0] > arrived + 8


def test_jams_dissolve_when_the_file_says_so(files):
    # A stop of no end to be seen, in the only lane.
    stop = '<stop lane="AB_0" endPos="90" duration="9999"/>'
    bus = f'<vehicle id="bus" type="c" depart="0"><route edges="{EDGES}"/>{stop}</vehicle>'
    several = CARS.replace("600", "300")
    assert ours(files(ROUTE + bus + several))[0] == 0
    path = files(ROUTE + bus + several, options='<time-to-teleport value="60"/>')
    arrived, delay_s = ours(path)
    assert arrived > 0
    assert (arrived, delay_s) == pytest.approx(plain(path), abs=0.01)


def test_a_survey_counts_none_of_the_others_and_stands_beside_other_definitions(files, tmp_path):
    halt = '<busStop id="halt" lane="AB_0" startPos="9" endPos="29"/>'
    scenario = sumo_scenario(files(ROUTE + BICYCLES + CARS, halt))
    survey = SurveyFiles(scenario.network, tmp_path)
    simulator = SumoSimulator(scenario, further_options=survey.options)
    vehicles = vehicles_of_seed(scenario, 0)
    evaluate(simulator, make_controller("program"), vehicles, make_reward("default"), 0)
    simulator.close()
    assert not np.isnan(survey.read(vehicles, 640).entered_s).any()


def test_the_mesoscopic_model_runs_without_them(files):
    scenario = sumo_scenario(files(ROUTE + BICYCLES + CARS))
    simulator = SumoSimulator(scenario, model="meso")
    vehicles = vehicles_of_seed(scenario, 0)
    found = evaluate(simulator, make_controller("program"), vehicles, make_reward("default"), 0)
    simulator.close()
    assert found.measures.delay_s < 40  # 128 s among the bicycles


def test_additional_files_of_both_are_loaded():
    chosen = ["--seed", "1", "--additional-files", "a,b", "--no-step-log"]
    assert together(chosen, ["--x", "--additional-files", "c", "--y"]) == [
        *("--seed", "1", "--additional-files", "a,b,c", "--no-step-log", "--x", "--y")
    ]
    assert together(["--x"], ["--additional-files", "c"]) == ["--x", "--additional-files", "c"]


def test_the_configuration_reads_back(files):
    read = read_sumo_configuration(files(CARS, options='<ignore-route-errors value="true"/>'))
    assert read.for_sumo == (("ignore-route-errors", "true"),)
