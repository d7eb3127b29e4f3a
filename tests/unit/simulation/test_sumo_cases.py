"""Networks that people bring: the file's own plan in SUMO, beside a plain run of SUMO."""

import importlib.util
from contextlib import ExitStack
from pathlib import Path

import pytest

from dmil.controllers import make_controller
from dmil.rewards import make_reward
from dmil.scenarios import SumoConfiguration, sumo_scenario
from dmil.simulation import QueueSimulator, SumoSimulator
from dmil.simulation.stand_ins import stand_ins
from dmil.training import evaluate, vehicles_of_seed

pytestmark = pytest.mark.skipif(
    importlib.util.find_spec("libsumo") is None, reason="needs the extra sumo"
)

CASES = Path(__file__).parents[2] / "cases"
SUMO_SEED = 23423
"""SUMO's own default."""


def run_of(simulator, controller="program"):
    reward, vehicles = make_reward("default"), vehicles_of_seed(simulator.scenario, 0)
    return evaluate(simulator, make_controller(controller), vehicles, reward, SUMO_SEED).measures


@pytest.fixture
def in_sumo():
    """Makes a simulator in SUMO and ends it."""
    with ExitStack() as stack:

        def make(scenario):
            simulator = SumoSimulator(scenario)
            stack.callback(simulator.close)
            return simulator

        yield make


@pytest.fixture(scope="module")
def rings():
    files = CASES / "nema-program" / "ne.net.xml", (CASES / "nema-program" / "ne.rou.xml",)
    return sumo_scenario(SumoConfiguration(*files), horizon_s=900)


def test_nema_signals_are_left_to_sumo(rings, in_sumo):
    simulator = in_sumo(rings)
    for controller in ("program", "actuated"):
        measures = run_of(simulator, controller)
        assert (measures.spawned_veh, measures.arrived_veh) == (300, 300)
        delay_s = (measures.time_loss_veh_s + measures.departure_delay_veh_s) / 300
        assert delay_s == pytest.approx(20.8, rel=0.05)  # sumo -n … -r … -e 900


def test_the_queue_simulator_shows_their_phases_in_turn_and_says_so(rings):
    sentences = stand_ins(rings.network)
    assert [text.partition(":")[0] for text in sentences] == [
        f"intersection '{name}'" for name in ("A0", "A1", "B0", "B1")
    ]
    assert all("(NEMA) runs in SUMO only" in text for text in sentences)
    measures = run_of(QueueSimulator(rings))
    assert measures.arrived_veh > 200


def test_a_root_of_any_name_is_read(in_sumo):
    scenario = sumo_scenario(CASES / "additional-root" / "b.sumocfg")
    measures = run_of(in_sumo(scenario))
    assert measures.spawned_veh == 60
    assert measures.arrived_veh == pytest.approx(52, abs=1)
    assert scenario.dynamics.vehicle_space_m == 7 + 2.5  # of the type in the file with <add>


def test_a_rail_crossing_is_a_junction_that_sumo_runs(in_sumo):
    folder = CASES / "rail-crossing"
    files = SumoConfiguration(folder / "net.net.xml", (folder / "r.rou.xml",))
    scenario = sumo_scenario(files, horizon_s=900)
    assert [item.id for item in scenario.network.intersections] == ["C"]
    assert "X" in {junction.id for junction in scenario.network.junctions}
    measures = run_of(in_sumo(scenario))
    assert measures.spawned_veh == measures.arrived_veh == 150  # and 5 trains


def test_programs_and_options_of_the_files_reach_sumo(tmp_path, in_sumo):
    case = CASES / "additional-root"
    net = case / "g.net.xml"
    only_across = "GGGggrrrrr" * 2  # nobody to or from the sides that the flow joins
    phases = f'<phase duration="99999" state="{only_across}"/>'
    (tmp_path / "a.xml").write_text(
        "<tls>"
        + "".join(
            f'<tlLogic id="{name}" type="static" programID="red" offset="0">{phases}</tlLogic>'
            for name in ("A0", "A1", "B0", "B1")
        )
        + '<vType id="c"/></tls>'
    )
    text = f"""<x><net-file value="{net}"/><r value="{case / "b.rou.xml"}"/>
    <a value="a.xml"/><e value="300"/><step-length value="0.5"/></x>"""
    (tmp_path / "a.sumocfg").write_text(text)
    scenario = sumo_scenario(tmp_path / "a.sumocfg")
    simulator = in_sumo(scenario)
    measures = run_of(simulator)
    assert (measures.spawned_veh, measures.arrived_veh) == (30, 0)
    assert scenario.sumo is not None and scenario.sumo.options == (("step-length", "0.5"),)
    assert run_of(simulator, "max-pressure").arrived_veh > 15
