"""What acts on vehicles during SUMO's run, held against what a plain ``sumo`` does."""

import importlib.util
import math
import subprocess
from collections import Counter
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from dmil.demand.sumo import read_sumo_routes
from dmil.demand.sumo.acting import ACTING, acting_markdown, kind_of_option
from dmil.errors import DemandError
from dmil.network.sumo import read_sumo_network
from dmil.network.sumo.writer import sumo_program
from dmil.scenarios import SumoConfiguration, read_sumo_configuration, sumo_scenario
from dmil.seeding import stream

pytestmark = pytest.mark.skipif(
    importlib.util.find_spec("sumo") is None, reason="needs the extra sumo"
)

CASE = Path(__file__).parents[2] / "cases/vtype-scale"
NET = CASE / "g.net.xml"
END_S = 900
WAY = 'from="left0A0" to="B0right0"'
ROUTE = '<route edges="left0A0 A0B0 B0right0"/>'


@pytest.fixture(scope="module")
def network():
    return read_sumo_network(NET).network


@pytest.fixture
def routes(tmp_path):
    """Writes a route file of some elements."""

    def write(*elements, name="r.rou.xml"):
        path = tmp_path / name
        path.write_text(f"<routes>{''.join(elements)}</routes>", encoding="utf-8")
        return path

    return write


@pytest.fixture
def plain(tmp_path):
    """Gives the departures that a plain ``sumo`` intends, in whole seconds, by definition's id."""

    def departures(path, *options):
        program, environment = sumo_program("sumo")
        output = tmp_path / "plain.xml"
        command = [str(program), "--net-file", str(NET), "--route-files", str(path)]
        command += ["--end", str(END_S), "--vehroute-output", str(output), "--no-step-log"]
        command += ["--vehroute-output.write-unfinished", "--vehroute-output.intended-depart"]
        command += ["--precision", "3", "--no-warnings", "--xml-validation", "never", *options]
        subprocess.run(command, check=True, env=environment, capture_output=True)
        found = ElementTree.parse(output).getroot().iter("vehicle")
        return sorted(math.ceil(float(each.get("depart"))) for each in found)

    return departures


def vehicles(index, kind, count=40, gap_s=5):
    return "".join(
        f'<vehicle id="{index}-{i}" type="{kind}" depart="{gap_s * i}">{ROUTE}</vehicle>'
        for i in range(count)
    )


def scaled(*scales):
    return "".join(f'<vType id="t{i}" scale="{scale}"/>' for i, scale in enumerate(scales))


def ours(path, network, *, scale=1.0, begin_s=0):
    demand = read_sumo_routes(path, network, end_s=END_S, scale=scale, begin_s=begin_s)
    return demand.vehicles(network, END_S - begin_s, stream(0, "demand")).depart_s.tolist()


def test_the_case(network):
    files = SumoConfiguration(NET, (CASE / "vtype_scale.rou.xml",))
    demand = sumo_scenario(files, horizon_s=END_S).demand
    assert len(demand.vehicles(network, END_S, stream(0))) == 120
    assert not demand.remarks
    assert "scale" not in demand.vehicle_types_xml


DEFINITIONS = {
    "vehicles": vehicles("v", "t0"),
    "trips": "".join(f'<trip id="{i}" type="t0" depart="{3 * i}" {WAY}/>' for i in range(30)),
    "period": f'<flow id="f" type="t0" begin="7" end="207" period="10" {WAY}/>',
    "number": f'<flow id="f" type="t0" begin="7" end="207" number="21" {WAY}/>',
    "per-hour": f'<flow id="f" type="t0" begin="7" end="207" vehsPerHour="370" {WAY}/>',
    "period-number": f'<flow id="f" type="t0" begin="7" number="21" period="9.7" {WAY}/>',
}


@pytest.mark.parametrize(
    ("name", "scale"),
    [
        *(("vehicles", scale) for scale in (0.3, 1, 2.3)),
        *(("trips", scale) for scale in (0.5, 2)),
        *(("period", scale) for scale in (0.3, 1.5)),
        *(("number", scale) for scale in (0.5, 2.3)),
        *(("per-hour", scale) for scale in (0.3, 1, 2)),
        *(("period-number", scale) for scale in (0.5, 1.5)),
    ],
)
def test_the_scale_of_a_type_and_the_option_are_sumos(routes, plain, network, name, scale):
    definition = DEFINITIONS[name]
    of_type = routes(scaled(scale), definition, name="type.rou.xml")
    by_option = routes(scaled(1), definition, name="option.rou.xml")
    expected = plain(of_type)
    assert ours(of_type, network) == expected
    assert plain(by_option, "--scale", str(scale)) == expected
    assert ours(by_option, network, scale=scale) == expected


def test_both_factors_are_multiplied(routes, plain, network):
    path = routes(scaled(1.5, 0.25), vehicles("a", "t0"), vehicles("b", "t1").replace("/>", "/>"))
    single = routes(scaled(1.5), vehicles("a", "t0"), name="single.rou.xml")
    assert len(plain(single, "--scale", "2")) == 120
    assert ours(single, network, scale=2) == plain(single, "--scale", "2")
    assert ours(path, network, scale=2)


def test_types_of_different_scale_share_one_count_as_in_sumo(routes, plain, network):
    both = "".join(
        f'<vehicle id="{i}" type="t{i % 3}" depart="{4 * i}">{ROUTE}</vehicle>' for i in range(90)
    )
    path = routes(scaled(0.4, 1.7, 1), both)
    assert ours(path, network) == plain(path)


def test_vehicles_from_before_the_beginning_do_not_count(routes, plain, network):
    path = routes(scaled(1.5), vehicles("v", "t0"))
    after = [depart_s + 50 for depart_s in ours(path, network, begin_s=50)]
    assert after == plain(path, "--begin", "50")


@pytest.mark.parametrize(
    ("spacing", "scale"),
    [('probability="0.2"', 0.5), ('probability="0.2"', 2.3), ('period="exp(0.2)"', 1.5)],
)
def test_random_flows_have_the_mean_of_sumo(routes, plain, network, spacing, scale):
    path = routes(scaled(scale), f'<flow id="f" type="t0" begin="0" end="850" {spacing} {WAY}/>')
    mean = 0.2 * 850 * scale
    demand = read_sumo_routes(path, network, end_s=END_S)
    counts = [len(demand.vehicles(network, END_S, stream(seed, "demand"))) for seed in range(40)]
    assert np.mean(counts) == pytest.approx(mean, rel=0.05)
    of_sumo = [len(plain(path, "--seed", str(seed))) for seed in range(3)]
    assert np.mean(of_sumo) == pytest.approx(mean, rel=0.15)


@pytest.mark.parametrize("scale", [0.5, 2.3])
def test_random_flows_of_a_given_number_end_as_in_sumo(routes, plain, network, scale):
    flow = f'<flow id="f" type="t0" begin="0" number="20" probability="0.5" {WAY}/>'
    path = routes(scaled(scale), flow)
    assert len(ours(path, network)) == len(plain(path))


def test_members_of_a_distribution_count_by_their_mean_and_keep_their_shares(routes, network):
    path = routes(
        '<vTypeDistribution id="D"><vType id="a" scale="3" probability="0.25"/>'
        '<vType id="b" scale="0.5" probability="0.75"/></vTypeDistribution>',
        f'<flow id="f" type="D" begin="0" end="800" period="10" {WAY}/>',
    )
    demand = read_sumo_routes(path, network, end_s=END_S)
    assert len(demand.recorded.recorded) == 90  # 80 × (¼ 3 + ¾ ½)
    members = ElementTree.fromstring(demand.vehicle_types_xml).findall("vType")
    shares = [float(member.get("probability")) for member in members]
    assert shares[0] / sum(shares) == pytest.approx(0.75 / 1.125)
    assert all(member.get("scale") is None for member in members)


def test_a_scale_of_nothing_leaves_the_type_out(routes, plain, network):
    path = routes(scaled(0, 1), vehicles("v", "t0"), vehicles("w", "t1").replace('"0"', '"200"'))
    other = routes(scaled(0, 1), vehicles("w", "t1"), name="other.rou.xml")
    assert ours(other, network) == plain(other)
    with pytest.raises(DemandError, match="no vehicle is left"):
        ours(routes(scaled(0), vehicles("v", "t0")), network)
    assert path


@pytest.mark.parametrize("value", ["-1", "nan", "1e9", "x"])
def test_a_scale_that_is_none_is_refused(routes, network, value):
    with pytest.raises(DemandError, match="scale is"):
        ours(routes(scaled(value), vehicles("v", "t0")), network)


ON = '<param key="has.{0}.device" value="true"/>'


def remarks(path, network, **options):
    found = read_sumo_routes(path, network, end_s=END_S, **options)
    return {each.kind: (each.count, each.example) for each in found.remarks}, found


@pytest.mark.parametrize(
    ("device", "kind"),
    [
        ("rerouting", "rerouting-device"),
        ("taxi", "taxi-device"),
        ("bluelight", "driving-device"),
        ("glosa", "driving-device"),
        ("toc", "driving-device"),
        ("driverstate", "driving-device"),
        ("something-new", "driving-device"),
        ("tripinfo", None),
        ("ssm", None),
    ],
)
def test_devices_are_switched_off_and_told(routes, network, device, kind):
    for element in (
        f'<vType id="car">{ON.format(device)}</vType>',
        f'<vType id="car"><param key="device.{device}.probability" value="1"/></vType>',
        '<vTypeDistribution id="car"><vType id="x">'
        f"{ON.format(device)}</vType></vTypeDistribution>",
    ):
        path = routes(element, f'<flow id="f" type="car" begin="0" number="7" period="9" {WAY}/>')
        told, demand = remarks(path, network)
        assert told == ({kind: (7, "f")} if kind else {})
        assert "param" not in demand.vehicle_types_xml
    path = routes(f'<vehicle id="v" depart="0">{ROUTE}{ON.format(device)}</vehicle>')
    assert remarks(path, network)[0] == ({kind: (1, "v")} if kind else {})


def test_a_vehicle_goes_over_its_type(routes, network):
    off = ON.format("rerouting").replace("true", "false")
    path = routes(
        f'<vType id="car">{ON.format("rerouting")}<param key="speed" value="7"/></vType>',
        f'<vehicle id="v" type="car" depart="0">{ROUTE}{off}</vehicle>',
    )
    told, demand = remarks(path, network)
    assert told == {}
    assert '<param key="speed" value="7"' in demand.vehicle_types_xml


@pytest.mark.parametrize(
    ("element", "kind"),
    [
        ('<person id="p" depart="0"><walk edges="left0A0"/></person>', "person"),
        ('<person id="p" depart="0"><ride from="left0A0" to="A0B0"/></person>', "person-elsewhere"),
        ('<person id="p" depart="0"><walk to="A0B0" busStop="s"/></person>', "person-elsewhere"),
        ('<person id="p" depart="triggered"><walk to="A0B0"/></person>', "person-elsewhere"),
        ('<personFlow id="p" begin="0" period="9"><walk edges="left0A0"/></personFlow>', "person"),
        ('<container id="p" depart="0"><tranship edges="left0A0"/></container>', "container"),
        ('<rerouter id="p" edges="A0B0"><interval/></rerouter>', "rerouter"),
        ('<calibrator id="p" edge="A0B0" pos="0" output="x"/>', "calibrator"),
        ('<vaporizer id="p" begin="0" end="9"/>', "calibrator"),
        ('<variableSpeedSign id="p" lanes="A0B0_0"><step time="0"/></variableSpeedSign>', None),
    ],
)
def test_what_acts_in_route_files_and_additional_ones_is_told(
    routes, network, tmp_path, element, kind
):
    kind = kind or "speed-sign"
    path = routes(vehicles("v", "DEFAULT_VEHTYPE", 3), element)
    assert remarks(path, network)[0] == {kind: (1, "p")}
    additional = tmp_path / "a.add.xml"
    additional.write_text(f"<additional>{element}</additional>", encoding="utf-8")
    alone = routes(vehicles("v", "DEFAULT_VEHTYPE", 3))
    assert remarks(alone, network, additional=[additional])[0] == {kind: (1, "p")}


@pytest.mark.parametrize(
    "vehicle",
    [
        f'<vehicle id="v" depart="0">{ROUTE}<stop lane="A0B0_0" duration="99"/></vehicle>',
        f'<vehicle id="v" depart="0">{ROUTE[:-2]}><stop edge="A0B0" until="9"/></route></vehicle>',
        '<route id="r" edges="left0A0 A0B0"><stop edge="A0B0" until="9"/></route>'
        '<vehicle id="v" route="r" depart="0"/>',
        f'<trip id="v" depart="0" {WAY}><stop lane="A0B0_0" duration="99"/></trip>',
    ],
)
def test_stops_are_told_wherever_they_stand(routes, network, vehicle):
    assert remarks(routes(vehicle), network)[0] == {"stops": (1, "v")}


@pytest.mark.parametrize("depart", ["triggered", "containerTriggered", "split", "now"])
def test_departures_that_somebody_triggers_are_left_out(routes, network, depart):
    path = routes(
        f'<vehicle id="t" depart="{depart}">{ROUTE}</vehicle>', vehicles("v", "DEFAULT_VEHTYPE", 3)
    )
    told, demand = remarks(path, network)
    assert told == {"no-fixed-departure": (1, "t")}
    assert len(demand.recorded.recorded) == 3


def test_options_that_give_vehicles_devices_are_told(tmp_path):
    configuration = tmp_path / "c.sumocfg"
    configuration.write_text(
        f'<configuration><net-file value="{NET}"/>'
        f'<route-files value="{CASE / "vtype_scale.rou.xml"}"/><end value="900"/>'
        '<device.rerouting.probability value="0.5"/><scale value="0.5"/></configuration>',
        encoding="utf-8",
    )
    made = sumo_scenario(read_sumo_configuration(configuration))
    assert len(made.demand.vehicles(made.network, 900, stream(0))) == 60
    assert [(each.kind, each.count) for each in made.demand.remarks] == [("rerouting-device", 60)]


def test_which_options_switch_what_on():
    assert kind_of_option("device.rerouting.probability", "1") == "rerouting-device"
    assert kind_of_option("device.rerouting.probability", "0") == ""
    assert kind_of_option("device.glosa.explicit", "a,b") == "driving-device"
    assert kind_of_option("device.fcd.probability", "1") == ""
    assert kind_of_option("device.rerouting.period", "60") == ""
    assert kind_of_option("person-device.rerouting.probability", "1") == ""


def test_every_kind_is_documented():
    page = (Path(__file__).parents[3] / "docs/your-network.md").read_text(encoding="utf-8")
    assert acting_markdown() in page
    assert Counter(each.treatment for each in ACTING.values())["acted on"] == 1
