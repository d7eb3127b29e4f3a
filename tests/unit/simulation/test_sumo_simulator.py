"""SUMO behind the protocol of all simulators."""

import gc
import importlib.util
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import fields, replace
from multiprocessing import get_context
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from dmil.errors import InputError, MissingExtraError, SimulationError, UnknownNameError
from dmil.scenarios import scenario
from dmil.simulation import SIMULATORS, SumoSimulator, make_simulator
from dmil.simulation.timing import ACTUATED, PROGRAM
from dmil.testing import check_simulator
from dmil.training import vehicles_of_seed

pytestmark = pytest.mark.skipif(
    importlib.util.find_spec("libsumo") is None or importlib.util.find_spec("sumo_rl") is None,
    reason="needs the extra sumo",
)


@pytest.fixture(scope="module")
def cologne():
    return scenario("resco/cologne1", horizon_s=300)


@pytest.fixture(scope="module")
def drivers(cologne):
    return vehicles_of_seed(cologne, 0)


@pytest.fixture(scope="module")
def simulator(cologne):
    """One for several tests: every run begins with a reset, which leaves nothing of the last."""
    made = SumoSimulator(cologne)
    yield made
    made.close()


@pytest.fixture(scope="module")
def known(simulator, drivers):
    """The measures of a run with seed 1."""
    return drive(simulator, drivers)


def drive(simulator, drivers, choose=lambda k: k // 2, seed=1):
    """Run to the horizon with the phases that ``choose`` gives for every decision."""
    counts = [len(item.phases) for item in simulator.network.intersections]
    observation, k = simulator.reset(drivers, seed), 0
    while observation.time_s < simulator.horizon_s:
        wanted = choose(k)
        phases = [wanted % count if wanted >= 0 else wanted for count in counts]
        observation = simulator.advance(np.array(phases, np.int32))
        k += 1
    return simulator.measures()


def total(measures):
    return {
        item.name: getattr(measures, item.name)
        for item in fields(measures)
        if item.name not in ("arrived_at", "queued_at", "co2_g", "fuel_g", "person_delay_s")
    }


@pytest.mark.parametrize(("name", "model"), [("grid:1x1", "meso"), ("resco/cologne1", "micro")])
def test_it_conforms(name, model):
    made = scenario(name, horizon_s=200)
    check_simulator(lambda: SumoSimulator(made, model=model))


def test_the_seed_decides_how_drivers_differ(simulator, drivers, known):
    first, again, other = total(known), *(total(drive(simulator, drivers, seed=k)) for k in (1, 2))
    assert first == again
    assert first != other
    assert first["spawned_veh"] == other["spawned_veh"] > 100


def test_measures_under_way_are_those_of_a_run_that_ends_there(simulator, drivers, cologne):
    short = SumoSimulator(replace(cologne, horizon_s=150))
    ended = total(drive(short, drivers))
    short.close()
    simulator.reset(drivers, 1)
    for k in range(15):
        simulator.advance(np.array([k // 2 % 4], np.int32))
    under_way = total(simulator.measures())
    # SUMO writes two decimals.
    # What only CityFlow measures is no number.
    assert under_way == pytest.approx(ended, abs=0.01 * len(drivers), nan_ok=True)


@pytest.fixture(scope="module", params=["micro", "meso"])
def summarised(request, cologne, drivers, tmp_path_factory):
    """The measures of a run with emissions, and the steps of SUMO's own summary."""
    file = tmp_path_factory.mktemp("summary") / "summary.xml"
    summary = ["--summary-output", str(file)]
    options = {"model": request.param, "emissions": True}
    simulator = SumoSimulator(cologne, **options, further_options=lambda files: summary)
    measures = drive(simulator, drivers, lambda k: k // 4)
    simulator.close()
    return measures, [step.attrib for step in ElementTree.parse(file).iter("step")]


def test_seconds_and_waiting_are_those_of_sumos_summary(summarised):
    measures, steps = summarised
    halting, outside, arrived = (
        np.array([int(step[name]) for step in steps]) for name in ("halting", "waiting", "arrived")
    )
    assert outside.sum() > 0
    assert measures.arrived_at.tolist() == arrived.tolist()
    # What halts is seen at decisions; who is outside, in every second.
    decided = slice(9, None, 10)
    assert measures.queued_at[decided].tolist() == (halting + outside)[decided].tolist()
    known = np.interp(np.arange(1, 301), np.arange(0, 301, 10), [0, *halting[decided]])
    assert measures.queued_at.tolist() == (np.rint(known) + outside).tolist()
    # SUMO's trips count a speed of exactly 0.1 m/s as halting, and parts of seconds if mesoscopic.
    assert measures.wait_veh_s == pytest.approx(halting.sum() + outside.sum(), rel=0.03)


def test_the_own_program_is_what_sumo_does_by_itself(simulator, drivers, cologne, tmp_path):
    measures = drive(simulator, drivers, lambda k: PROGRAM)
    sumo = Path(importlib.util.find_spec("sumo").submodule_search_locations[0])
    folder, trips = simulator._process.folder, tmp_path / "trips.xml"
    begin_s = cologne.sumo.begin_s
    options = f"-n {cologne.sumo.net_file} -r {folder / 'vehicles.rou.xml'} --seed 1 --no-step-log"
    options += f" -b {begin_s} -e {begin_s + 300} --time-to-teleport -1 --tripinfo-output {trips}"
    subprocess.run(
        [sumo / "bin" / "sumo", *options.split()],
        check=True,
        env={**os.environ, "SUMO_HOME": str(sumo)},
    )

    def ended(text):
        lines = [line.strip() for line in text.splitlines() if "<tripinfo " in line]
        return [line for line in lines if 'arrival="-1.00"' not in line]

    found = ended((folder / "output.xml").read_text())
    assert found == ended(trips.read_text())
    assert len(found) == measures.arrived_veh > 50


def test_actuated_control_and_phases_at_the_same_time():
    three = scenario("resco/cologne3", horizon_s=200)
    simulator = SumoSimulator(three)
    drivers = vehicles_of_seed(three, 0)
    simulator.reset(drivers)
    for _ in range(20):
        observation = simulator.advance(np.array([ACTUATED, 0, PROGRAM], np.int32))
    assert observation.phase.tolist() == [-1, 0, -1]
    mixed = total(simulator.measures())
    program, actuated = (
        total(drive(simulator, drivers, lambda k, kind=kind: kind, seed=0))
        for kind in (PROGRAM, ACTUATED)
    )
    assert mixed != program != actuated
    simulator.close()


def test_a_network_without_programs_refuses_them():
    grid = scenario("grid:1x1", horizon_s=100)
    simulator = SumoSimulator(grid)
    simulator.reset(vehicles_of_seed(grid, 0))
    for wanted in (PROGRAM, ACTUATED):
        with pytest.raises(InputError, match="no program"):
            simulator.advance(np.array([wanted], np.int32))
    simulator.close()


def test_emissions_on_request(summarised):
    measures, _ = summarised
    # A litre of petrol has about 0.75 kg and makes 2.3 kg of carbon dioxide.
    assert measures.co2_g / measures.fuel_g == pytest.approx(2.3 / 0.75, rel=0.1)
    assert 20 < measures.fuel_g / measures.spawned_veh < 500


def test_without_request_there_are_no_emissions(known):
    assert np.isnan(known.co2_g)


@pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="needs Linux's /proc")
def test_a_death_of_the_run_alone_is_an_error_too(simulator, drivers):
    simulator.reset(drivers)
    pid = simulator._process._process.pid
    (run,) = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    os.kill(int(run), signal.SIGSEGV)
    with pytest.raises(SimulationError, match=r"cologne1: SUMO failed: .*code 139"):
        simulator.advance(np.array([0]))
    assert drive(simulator, drivers).arrived_veh > 0


def test_runs_do_not_depend_on_what_ran_before(simulator, drivers, known):
    for seed in range(3):
        simulator.reset(drivers, seed)
        simulator.advance(np.array([seed]))
    assert total(drive(simulator, drivers)) == total(known)


def test_a_death_is_an_error_and_the_next_reset_lives(simulator, drivers):
    simulator.reset(drivers)
    folder = simulator._process.folder
    os.killpg(simulator._process._process.pid, signal.SIGKILL)
    with pytest.raises(SimulationError, match=r"cologne1: SUMO failed: .*-9"):
        simulator.advance(np.array([0], np.int32))
    assert not folder.exists()
    with pytest.raises(InputError, match="no run is under way"):
        simulator.measures()
    assert drive(simulator, drivers).arrived_veh > 50


def test_sumo_says_which_route_it_refuses(simulator, drivers):
    wrong = replace(drivers, route_links=drivers.route_links[::-1].copy())
    with pytest.raises(SimulationError, match=r"SUMO failed: .*No connection between edge"):
        drive(simulator, wrong)


def test_sumo_says_which_network_it_refuses(cologne, drivers, tmp_path):
    (tmp_path / "cut.net.xml").write_bytes(cologne.sumo.net_file.read_bytes()[:20_000])
    files = replace(cologne.sumo, net_file=tmp_path / "cut.net.xml")
    simulator = SumoSimulator(replace(cologne, sumo=files))
    with pytest.raises(SimulationError, match=r"SUMO failed: .*cut\.net\.xml"):
        simulator.reset(drivers)


def test_before_a_reset_nothing_runs(cologne):
    simulator = SumoSimulator(cologne)
    for call in (simulator.measures, lambda: simulator.advance(np.array([0], np.int32))):
        with pytest.raises(InputError, match="no run is under way"):
            call()


def test_after_the_horizon_a_run_is_over(simulator, drivers):
    drive(simulator, drivers)
    with pytest.raises(InputError, match="run is over"):
        simulator.advance(np.array([0], np.int32))


def gone(pid):
    """Whether a process has ended, waiting a little."""
    for _ in range(1200):  # two minutes: the machine may be busy
        try:
            state = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0]
        except FileNotFoundError:
            return True
        if state == "Z":
            return True
        time.sleep(0.1)
    return False


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="needs the processes of Linux")
def test_the_process_ends_with_its_simulator(cologne, drivers):
    simulator = SumoSimulator(cologne)
    simulator.reset(drivers)
    pid, folder = simulator._process._process.pid, simulator._process.folder
    os.kill(pid, signal.SIGINT)  # Ctrl-C is for the parent
    simulator.advance(np.array([0], np.int32))
    del simulator
    gc.collect()
    assert gone(pid)
    assert not folder.exists()


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="needs the processes of Linux")
def test_the_process_ends_with_a_killed_parent():
    code = """
import time
from dmil.scenarios import scenario
from dmil.simulation import SumoSimulator
from dmil.training import vehicles_of_seed
made = scenario("resco/cologne1", horizon_s=100)
simulator = SumoSimulator(made)
simulator.reset(vehicles_of_seed(made, 0))
print(simulator._process._process.pid, simulator._process.folder, flush=True)
time.sleep(600)
"""
    with subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, text=True
    ) as parent:
        pid, folder = parent.stdout.readline().split()
        parent.kill()
    assert gone(pid)
    assert not Path(folder).exists()


def arrivals(seed):
    made = scenario("resco/cologne1", horizon_s=100)
    simulator = SumoSimulator(made)
    return drive(simulator, vehicles_of_seed(made, 0), seed=seed).travel_veh_s


def test_many_at_once_in_worker_processes():
    with ProcessPoolExecutor(2, mp_context=get_context("forkserver")) as pool:
        found = list(pool.map(arrivals, [3, 4, 3]))
    assert found[0] == found[2] == arrivals(3)
    assert found[0] != found[1]


def test_two_simulators_in_turns(simulator, cologne, drivers):
    one, two = simulator, SumoSimulator(cologne)
    one.reset(drivers, 1)
    two.reset(drivers, 1)
    for k in range(30):
        phases = np.array([k % 4], np.int32)
        assert one.advance(phases).queue_veh.tolist() == two.advance(phases).queue_veh.tolist()
    two.close()


def test_simulators_by_name(cologne):
    assert set(SIMULATORS) == {"queue", "sumo", "sumo-meso", "cityflow"}
    # CityFlow has tests of its own: it runs its own files, where it is installed.
    for name in set(SIMULATORS) - {"cityflow"}:
        assert make_simulator(cologne, name).horizon_s == 300
    with pytest.raises(UnknownNameError, match="'sumo'"):
        make_simulator(cologne, "summo")


def test_without_sumo_the_error_names_the_extra(monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(MissingExtraError, match=r"dmil\[sumo\]"):
        make_simulator(scenario("grid:1x1"), "sumo")
