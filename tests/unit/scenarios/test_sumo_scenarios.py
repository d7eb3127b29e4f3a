"""Scenarios from SUMO's files, and those of the RESCO benchmark."""

import gzip
import importlib.util
import pickle
import shutil
import subprocess
from pathlib import Path

import pytest

from dmil.errors import DemandError, InputError, MissingExtraError, UnknownNameError
from dmil.network.sumo.writer import sumo_program
from dmil.scenarios import (
    PLAN,
    QueueDynamics,
    SignalTiming,
    SumoConfiguration,
    read_sumo_configuration,
    scenario,
    scenario_names,
    sumo_scenario,
)
from dmil.scenarios.names import find_resco_configuration
from dmil.scenarios.recipe import ScenarioRecipe
from dmil.seeding import stream

CROSSING = ("--grid", "--grid.number", "1", "--grid.attach-length", "100", "-j", "traffic_light")
RESCO = {
    "resco/cologne1": (1, 2015, 5.8),
    "resco/cologne3": (3, 2856, 5.8),
    "resco/cologne8": (8, 2046, 5.8),
    "resco/ingolstadt1": (1, 1716, 7.569),
    "resco/ingolstadt7": (7, 3030, 7.588),
    "resco/ingolstadt21": (21, 4280, 7.587),
    "resco/grid4x4": (16, 1473, 7.5),
    "resco/arterial4x4": (16, 2484, 7.5),
}
"""Intersections, vehicles of the hour, metres that a vehicle takes up."""


@pytest.fixture(scope="session")
def crossing(tmp_path_factory):
    pytest.importorskip("sumo", reason="needs the extra sumo")
    path = tmp_path_factory.mktemp("crossing") / "x.net.xml"
    program, environment = sumo_program("netgenerate")
    command = [str(program), *CROSSING, "--no-turnarounds", "--output-file", str(path)]
    subprocess.run(command, check=True, capture_output=True, env=environment, timeout=120)
    return path


@pytest.fixture
def folder(crossing, tmp_path):
    """A folder with a network, routes from second 25200 to 25899, and additional types."""
    shutil.copy(crossing, tmp_path / "x.net.xml")
    trips = "".join(
        f'<trip id="{k}" type="short" depart="{25200 + 100 * k}" from="left0A0" to="A0right0"/>'
        for k in range(8)
    )
    (tmp_path / "a.rou.xml").write_text(f"<routes>{trips}</routes>")
    more = '<routes><flow id="f" begin="25200" end="25300" number="4" from="top0A0" to="A0left0"/>'
    (tmp_path / "b c.rou.xml.gz").write_bytes(gzip.compress(f"{more}</routes>".encode()))
    types = '<additional><vType id="short" length="3" minGap="2"/></additional>'
    (tmp_path / "types.add.xml").write_text(types)
    return tmp_path


LONG = """<configuration>
<input><net-file value="x.net.xml"/><route-files value="a.rou.xml, b%20c.rou.xml.gz"/>
<additional-files value="types.add.xml"/></input>
<time><begin value="7:00:00"/><end value="26000"/></time>
<output><tripinfo-output value="t.xml"/></output>
<processing><time-to-teleport value="-1"/></processing>
</configuration>"""
SHORT = """<sumoConfiguration><n v="x.net.xml"/><r value="a.rou.xml,b c.rou.xml.gz"/>
<additional value="types.add.xml"/><b value="25200"/><e value="26000"/></sumoConfiguration>"""


FILES = '<r value="a.rou.xml,b c.rou.xml.gz"/>\n<additional value="types.add.xml"/>'


def written(folder, text, name="x.sumocfg"):
    (folder / name).write_text(text)
    return folder / name


@pytest.mark.parametrize("text", [LONG, SHORT])
def test_a_configuration_names_files_beside_it_and_times(folder, text):
    found = read_sumo_configuration(written(folder, text))
    told = (("time-to-teleport", "-1"),) if text == LONG else ()
    assert found == SumoConfiguration(
        folder / "x.net.xml",
        (folder / "a.rou.xml", folder / "b c.rou.xml.gz"),
        (folder / "types.add.xml",),
        25200,
        26000.0,
        for_sumo=told,
    )


def test_steps_of_another_length_and_a_scale_are_not_lost(folder):
    text = SHORT.replace("<n ", '<step-length value="0.3"/><scale value="2"/><n ')
    path = written(folder, text)
    found = read_sumo_configuration(path)
    assert (found.unused, found.scale, found.for_sumo) == (("step-length=0.3",), 2.0, ())
    made = sumo_scenario(path)
    assert len(made.demand.vehicles(made.network, 800, stream(0))) == 24
    path = written(folder, SHORT.replace("<n ", '<step-length value="0.20"/><n '))
    assert read_sumo_configuration(path).for_sumo == (("step-length", "0.2"),)
    made = sumo_scenario(path)
    assert made.sumo is not None and made.sumo.options == (("step-length", "0.2"),)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('<n v="x.net.xml"/>', "", "x.sumocfg: it names no net-file.*--net and --routes"),
        ("<n ", '<horizon value="1"/><n ', r"line 1, column 20: SUMO has no option 'horizon'"),
        ("<n ", '<begin value="1"/><n ', r"the option begin is given twice"),
        (
            "<n ",
            '<load-state value="s.xml"/><n ',
            r"load-state \(s.xml\) cannot be followed: a run",
        ),
        ('<n v="x.net.xml"/>', "<n/>", "x.sumocfg: it names no net-file"),
        ('<b value="25200"/>', '<b value="dawn"/>', "begin is 'dawn'; expected seconds"),
        ('<b value="25200"/>', '<b value="0.5"/>', "begin is '0.5'; expected whole seconds"),
        ("<n ", '<scale value="0"/><n ', "scale is '0'; expected a number above 0"),
        ("<n ", '<scale value="x"/><n ', "scale is 'x'"),
        ("sumoConfiguration", "net", "its root element is <net>"),
        ("</sumoConfiguration>", "", "cut off"),
        ("<sumoC", "<!DOCTYPE a><sumoC", "DOCTYPE"),
    ],
)
def test_a_wrong_configuration_is_an_error_with_its_place(folder, old, new, message):
    path = written(folder, SHORT.replace(old, new))
    with pytest.raises(InputError, match=message):
        read_sumo_configuration(path)


def test_options_without_a_value_count_as_not_given_as_in_sumo(folder):
    text = SHORT.replace('<e value="26000"/>', "<sloppy-insert/><end/>")
    assert read_sumo_configuration(written(folder, text)).end_s is None


def test_a_configuration_without_vehicles_can_be_read_but_not_be_run(folder):
    path = written(folder, SHORT.replace(FILES, ""))
    assert read_sumo_configuration(path).route_files == ()
    with pytest.raises(InputError, match=r"x.sumocfg: it names no route-files; .*\(--net and"):
        sumo_scenario(path)


def test_a_missing_file_is_named(folder):
    with pytest.raises(InputError, match=r"gone.sumocfg: there is no such file"):
        read_sumo_configuration(folder / "gone.sumocfg")
    (folder / "types.add.xml").unlink()
    with pytest.raises(InputError, match=r"types.add.xml: there is no such file"):
        sumo_scenario(written(folder, SHORT))


def test_a_scenario_decides_as_in_resco_and_keeps_the_times_of_its_plans(folder):
    path = written(folder, LONG)
    made = sumo_scenario(path)
    assert (made.name, scenario(f"sumo:{path}").name) == ("sumo:x", f"sumo:{path}")
    assert made.timing == SignalTiming(decision_interval_s=10, **PLAN)
    space_m = round((8 * 5 + 4 * 7.5) / 12, 3)
    assert made.dynamics == QueueDynamics(
        saturation_flow_veh_per_s=0.5, storage=True, vehicle_space_m=space_m
    )
    assert made.horizon_s == 800
    vehicles = made.demand.vehicles(made.network, 800, stream(0))
    assert vehicles.depart_s.tolist() == [0, 0, 25, 50, 75, 100, 200, 300, 400, 500, 600, 700]
    assert made.sumo is not None
    assert (made.sumo.net_file, made.sumo.begin_s) == (folder / "x.net.xml", 25200)
    assert [made.sumo.kinds[kind] for kind in vehicles.kind[:2]] == [{"type": "short"}, {}]
    assert made.sumo.beside.types_xml == '<vType id="short" length="3" minGap="2" />\n'
    assert [signal.id for signal in made.sumo.signals] == ["A0"]
    copy = pickle.loads(pickle.dumps(made))
    assert copy.demand.vehicles(copy.network, 800, stream(0)).depart_s.tolist() == (
        vehicles.depart_s.tolist()
    )


def test_begin_horizon_and_the_rest_can_be_chosen(folder):
    path = written(folder, SHORT)
    timing, dynamics = SignalTiming(decision_interval_s=5), QueueDynamics()
    name = f"sumo:{path}"
    made = scenario(name, begin_s=25500, horizon_s=300, timing=timing, dynamics=dynamics, load=2)
    assert (made.name, made.horizon_s, made.timing) == (name, 300, timing)
    assert made.dynamics == dynamics
    departures = made.demand.vehicles(made.network, 300, stream(0)).depart_s.tolist()
    assert departures == [0, 0, 100, 100, 200, 200]
    assert scenario(name, begin_s=25500).horizon_s == 500
    derived = scenario(name, phases="derived").network.intersections[0]
    assert derived.phases != made.network.intersections[0].phases


def test_without_an_end_the_last_departure_decides(folder):
    path = written(folder, SHORT.replace('<e value="26000"/>', ""))
    assert sumo_scenario(path).horizon_s == 1200
    assert sumo_scenario(path, begin_s=25800).horizon_s == 600
    assert sumo_scenario(path, horizon_s=100).horizon_s == 100


def test_a_beginning_without_vehicles_is_named(folder):
    path = written(folder, SHORT.replace('<b value="25200"/>', ""))
    with pytest.raises(DemandError, match=r"no vehicle departs .*Set the begin to 25200 \(--beg"):
        sumo_scenario(path, horizon_s=3600)
    with pytest.raises(InputError, match="would begin at 30000 s and end at 26000 s"):
        sumo_scenario(path, begin_s=30000)


def test_sumo_looks_for_the_ways_of_trips_where_there_are_any(folder, monkeypatch, tmp_path):
    path = written(folder, LONG)
    monkeypatch.setenv("DMIL_CACHE", str(tmp_path / "cache"))
    made, free = sumo_scenario(path), scenario(f"sumo:{path}", routing="free-flow")
    assert made.sumo is not None and free.sumo is not None
    assert (made.sumo.routing, free.sumo.routing) == ("sumo", "free-flow")
    assert made.demand.remarks == ()
    assert [(each.kind, each.count) for each in free.demand.remarks] == [("free-flow", 12)]
    assert len(list((tmp_path / "cache").rglob("*.txt"))) == 1
    given = SumoConfiguration(folder / "x.net.xml", (folder / "own.rou.xml",))
    edges = '<vehicle id="0" depart="0"><route edges="left0A0 A0right0"/></vehicle>'
    (folder / "own.rou.xml").write_text(f"<routes>{edges}</routes>")
    assert sumo_scenario(given, routing="sumo").sumo.routing is None
    recipe = ScenarioRecipe(scenario=f"sumo:{path}", routing="free-flow")
    assert recipe.build().sumo.routing == "free-flow"


def test_without_sumo_trips_drive_the_ways_of_free_flow(folder, monkeypatch):
    def absent(name):
        raise MissingExtraError("sumo")

    monkeypatch.setattr("dmil.demand.sumo.routing.sumo_program", absent)
    made = sumo_scenario(written(folder, SHORT))
    assert made.sumo.routing == "free-flow"
    assert [each.kind for each in made.demand.remarks] == ["free-flow"]
    with pytest.raises(MissingExtraError, match=r"pip install 'dmil\[sumo\]'"):
        sumo_scenario(written(folder, SHORT), routing="sumo")


def test_a_recipe_of_files(folder):
    given = {"net": folder / "x.net.xml", "routes": (folder / "b c.rou.xml.gz",)}
    recipe = ScenarioRecipe(**given, begin_s=25200, horizon_s=60, phases="program", load=2.0)
    made = ScenarioRecipe.model_validate_json(recipe.model_dump_json()).build()
    assert (made.name, made.horizon_s, made.timing.clearance_s) == ("sumo:x", 60, None)
    departures = made.demand.vehicles(made.network, 60, stream(0)).depart_s.tolist()
    assert departures == [0, 0, 25, 25, 50, 50]
    for wrong in ({"net": given["net"]}, {"routes": given["routes"]}, given | {"flow": "f.json"}):
        with pytest.raises(InputError, match="or both net and routes"):
            ScenarioRecipe(**wrong).build()
    cityflow = {"roadnet": "r.json", "flow": "f.json"}
    with pytest.raises(InputError, match="roadnet and flow and begin_s;"):
        ScenarioRecipe(**cityflow, begin_s=4).build()


def test_other_scenarios_have_no_beginning():
    for options in ({"begin_s": 5}, {"phases": "derived"}, {"routing": "sumo"}):
        with pytest.raises(InputError, match="'grid:2x2' has no begin, phases or routing"):
            scenario("grid:2x2", **options)


@pytest.mark.parametrize("name", RESCO)
def test_the_scenarios_of_resco(name):
    pytest.importorskip("sumolib", reason="needs the extra sumo")
    # Single vehicles in the largest network take SUMO half a minute.
    routing = "mesoscopic" if name == "resco/ingolstadt21" else None
    made = scenario(name, routing=routing)
    vehicles = made.demand.vehicles(made.network, made.horizon_s, stream(0))
    intersections, count, space_m = RESCO[name]
    assert (made.name, made.horizon_s, len(vehicles)) == (name, 3600, count)
    # The benchmark has times of its own for one of its networks.
    interval_s, clearance_s = (5, 2) if name == "resco/arterial4x4" else (10, 3)
    assert made.timing == SignalTiming(decision_interval_s=interval_s, clearance_s=clearance_s)
    assert len(made.network.intersections) == intersections
    assert made.dynamics.vehicle_space_m == space_m
    assert vehicles.dropped == 0
    assert made.sumo is not None and made.sumo.begin_s in (0, 25200, 57600)
    left_out = {remark.kind: remark.count for remark in made.demand.remarks}
    expected = {"resco/cologne3": {"before-begin": 1638}, "resco/ingolstadt21": {"after-end": 3}}
    assert left_out == expected.get(name, {"after-end": 1} if "7" in name else {})


def test_the_names_of_resco_are_listed_and_misspelt_ones_corrected():
    assert set(RESCO) == {name for name in scenario_names() if name.startswith("resco/")}
    with pytest.raises(UnknownNameError, match="Did you mean 'resco/cologne1'") as caught:
        scenario("resco/colgne1")
    assert "grid:" not in str(caught.value)


def test_without_the_package_one_command_installs_it(monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(MissingExtraError, match=r"pip install 'dmil\[sumo\]'"):
        find_resco_configuration("resco/cologne1")


def test_a_package_without_the_files_is_named(monkeypatch, tmp_path):
    spec = importlib.util.find_spec("email")
    monkeypatch.setattr(spec, "submodule_search_locations", [str(tmp_path)])
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: spec)
    with pytest.raises(InputError, match=r"does not have the scenario 'cologne1'.*Install it"):
        find_resco_configuration("resco/cologne1")


def test_the_files_of_resco_are_found_without_importing_their_package():
    pytest.importorskip("sumo", reason="needs the extra sumo")
    path = find_resco_configuration("resco/grid4x4")
    assert isinstance(path, Path) and path.name == "grid4x4.sumocfg"


@pytest.mark.parametrize("name", ["osm.poly.xml", "houses.poi.xml.gz"])
def test_scenery_that_was_not_handed_on_is_no_obstacle(tmp_path, name):
    (tmp_path / "city.sumocfg").write_text(
        f'<configuration><net-file value="n.net.xml"/><additional-files value="a.add.xml,{name}"/>'
        "</configuration>"
    )
    found = read_sumo_configuration(tmp_path / "city.sumocfg")
    assert [file.name for file in found.additional_files] == ["a.add.xml"]
    (tmp_path / name).touch()
    found = read_sumo_configuration(tmp_path / "city.sumocfg")
    assert [file.name for file in found.additional_files] == ["a.add.xml", name]
