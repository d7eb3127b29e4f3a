"""Networks and routes of SUMO on the command line."""

import tomllib

import pytest

from dmil.scenarios.names import find_resco_configuration
from dmil.scenarios.recipe import ScenarioRecipe
from dmil.simulation.sumo.files import run_files

NAME = "resco/cologne1"


@pytest.fixture
def files():
    pytest.importorskip("sumo", reason="needs the extra sumo")
    path = find_resco_configuration(NAME)
    return ("--net", path.with_suffix(".net.xml"), "--routes", path.with_suffix(".rou.xml"))


def test_files_and_name_are_the_same_scenario(dmil, files):
    fast = ("--steps", "300", "--controller", "longest-queue-first")
    named = dmil.json("simulate", "--scenario", NAME, *fast)
    # The benchmark's rules of timing; files of one's own follow the plan in them.
    rules = ("--clearance", "3", "--all-red", "0", "--min-green", "0", "--max-green", "0")
    ours = dmil.json("simulate", *files, "--begin", "25200", *rules, *fast)
    assert ours["scenario"] == "sumo:cologne1"
    assert ours["runs"] == named["runs"]
    assert ours["runs"][0]["spawned_veh"] > 100


def test_the_phases_can_be_derived(dmil, files):
    run = ("simulate", "--scenario", NAME, "--steps", "300", "--controller", "longest-queue-first")
    assert dmil.json(*run, "--phases", "derived")["runs"] != dmil.json(*run)["runs"]
    dmil(*run, "--phases", "all", code=2)
    assert "expected one of derived, program" in dmil.err


def test_the_printed_file_gives_the_same(dmil, files, tmp_path):
    text = dmil("simulate", *files, "--begin", "25200", "--phases", "derived", "--print-config")
    values = tomllib.loads(text)
    assert values["routes"] == [str(files[3])]
    assert (values["net"], values["begin_s"], values["phases"]) == (str(files[1]), 25200, "derived")
    assert values["horizon_s"] == 3600
    assert "clearance_s" not in values["timing"]  # that of the plan
    file = tmp_path / "file.toml"
    file.write_text(text)
    assert dmil("simulate", "--config", file, "--print-config") == text


def test_where_the_ways_of_trips_are_from_is_recorded(dmil, files):
    run = ("simulate", "--scenario", NAME, "--steps", "300", "--print-config")
    assert tomllib.loads(dmil(*run))["routing"] == "sumo"
    assert tomllib.loads(dmil(*run, "--routing", "free-flow"))["routing"] == "free-flow"
    assert "routing" not in tomllib.loads(dmil("simulate", "--scenario", "grid:2x2", *run[3:]))
    dmil(*run, "--routing", "shortest", code=2)
    assert "expected one of free-flow, mesoscopic, sumo" in dmil.err


def test_a_policy_remembers_its_files(dmil, files, tmp_path):
    policy = tmp_path / "p.npz"
    begin = ("--begin", "25200", "--steps", "60")
    dmil("train", *files, *begin, "--episodes", "1", "--out", policy)
    found = dmil.json("simulate", "--policy", policy, "--begin", "25500")
    assert (found["scenario"], found["horizon_s"]) == ("sumo:cologne1", 60)
    earlier = dmil.json("simulate", "--policy", policy)
    assert earlier["runs"][0]["spawned_veh"] != found["runs"][0]["spawned_veh"]


def test_a_scenario_of_resco_is_described(dmil, files):
    found = dmil.json("scenarios", NAME)
    assert (found["intersections"], found["vehicles_of_seed_0"]) == (1, 2015)
    assert (found["horizon_s"], found["clearance_s"], found["storage"]) == (3600, 3, True)
    assert NAME in dmil("scenarios")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--scenario", "resco/cologne2"), "Did you mean 'resco/cologne"),
        (("--scenario", "sumo:gone.sumocfg"), "gone.sumocfg: there is no such file"),
        (("--scenario", "grid:2x2", "--begin", "5"), "has no begin, phases or routing"),
        (("--net", "a.net.xml"), "only net; expected either the name of a scenario"),
        (("--scenario", NAME, "--begin", "-1"), "--begin: found -1; expected at least 0"),
        (("--scenario", NAME, "--begin", "90000"), "would begin at 90000 s and end at 28800 s"),
        (("--scenario", NAME, "--begin", "0", "--steps", "60"), "Set the begin to 25205"),
    ],
)
def test_what_cannot_be_is_said(dmil, files, arguments, message):
    dmil("simulate", *arguments, code=2)
    assert message in " ".join(dmil.err.split())


def test_routes_of_another_network_are_refused(dmil, files):
    other = find_resco_configuration("resco/grid4x4").with_name("grid4x4_1.rou.xml")
    dmil("simulate", *files[:3], other, code=2)
    assert "which the network 'cologne1' does not have" in dmil.err


def test_vehicles_that_block_a_junction_can_be_ignored(dmil, tmp_path):
    pytest.importorskip("libsumo", reason="needs the extra sumo")
    run = ("simulate", "--scenario", NAME, "--steps", "300", "--ignore-junction-blocker", "10")
    values = tomllib.loads(dmil(*run, "--print-config"))
    assert values["ignore_junction_blocker_s"] == 10
    scenario = ScenarioRecipe(scenario=NAME, horizon_s=300, ignore_junction_blocker_s=10).build()
    assert run_files(scenario, tmp_path).further_options[-1] == ("ignore-junction-blocker", "10")
    grid = ScenarioRecipe(scenario="grid:1x1", ignore_junction_blocker_s=7).build()
    assert run_files(grid, tmp_path).further_options == (("ignore-junction-blocker", "7"),)
    assert dmil.json(*run, "--simulator", "sumo")["runs"][0]["spawned_veh"] > 100
    dmil(*run, code=2)
    assert "the simulator queue knows no vehicles that block a junction" in dmil.err
    dmil(*run[:-1], "0", code=2)
    assert "--ignore-junction-blocker: found 0; expected at least 1" in dmil.err


def test_the_arterial_has_the_benchmarks_own_times(dmil):
    times = ("decision_interval_s", "clearance_s")
    usual, own = (dmil.json("scenarios", f"resco/{name}") for name in ("grid4x4", "arterial4x4"))
    assert [usual[name] for name in times] == [10, 3] and [own[name] for name in times] == [5, 2]


def test_a_comparison_says_that_blockers_were_ignored(dmil):
    pytest.importorskip("libsumo", reason="needs the extra sumo")
    rules = ("--controller", "max-pressure", "--controller", "longest-queue-first")
    run = ("evaluate", "--scenario", NAME, "--steps", "300", "--simulator", "sumo", *rules)
    said = dmil(*run, "--seeds", "1", "--jobs", "1", "--ignore-junction-blocker", "10")
    assert "seed 0, junction blockers ignored after 10 s" in said.splitlines()[0]
