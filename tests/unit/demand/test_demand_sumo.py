"""The reader of SUMO's route files: vehicles, trips, routes, types, and what is left out."""

import pickle

import pytest

from dmil.demand import ScalableDemand, read_sumo_routes
from dmil.errors import DemandError
from dmil.network import grid
from dmil.seeding import stream
from tests.unit.demand.conftest import ACROSS, NETWORK, ids, kinds

ONE = '<vehicle id="v" depart="0"><route edges="ACROSS"/></vehicle>'

BICYCLE = '<vType id="b" vClass="bicycle"/>'


def drawn(demand, horizon_s=3600, seed=0):
    return demand.vehicles(NETWORK, horizon_s, stream(seed))


@pytest.mark.parametrize("zipped", [False, True])
def test_vehicles_with_routes_of_their_own_and_by_name(read, zipped):
    demand = read(
        '<route id="r" edges="W0>0,0 0,0>N0"/>'
        '<vehicle id="a" depart="1.2"><route edges="ACROSS"/></vehicle>'
        '<vehicle id="b" depart="0:00:03" route="r"/>',
        zipped=zipped,
    )
    vehicles = drawn(demand)
    assert isinstance(demand, ScalableDemand)
    assert vehicles.depart_s.tolist() == [2, 3]
    assert [ids(vehicles, 0), ids(vehicles, 1)] == [ACROSS.split(), ["W0>0,0", "0,0>N0"]]
    assert (demand.last_departure_s, demand.remarks) == (3, ())


def test_times_are_counted_from_the_beginning(read):
    text = "".join(
        f'<vehicle id="{depart}" depart="{depart}"><route edges="ACROSS"/></vehicle>'
        for depart in ("9.999", "10", "10.5", "begin", "18.2", "19", "19.5", "30")
    )
    demand = read(text, begin_s=10, end_s=20)
    assert drawn(demand, 10).depart_s.tolist() == [0, 1, 9, 9]
    # The one that departs at the beginning stands after a later one; 19.5 would be second 20.
    assert kinds(demand) == {
        "before-begin": (1, "9.999"),
        "after-end": (2, "19.5"),
        "unsorted": (1, "begin"),
    }


def test_lines_of_public_transport_need_not_be_sorted_nor_do_others_behind_them(read):
    text = "".join(
        f'<flow id="{begin}" {line} begin="{begin}" end="99" number="1" route="r"/>'
        for begin, line in ((9, 'line="1"'), (3, 'line="2"'), (4, ""), (2, 'line="3"'))
    )
    demand = read(f'<route id="r" edges="ACROSS"/>{text}')
    assert drawn(demand).depart_s.tolist() == [3, 4, 9]
    assert kinds(demand) == {"unsorted": (1, "2")}  # as SUMO 1.28 reads it


def test_trips_take_the_fastest_way_through_their_via_edges(read):
    demand = read(
        '<trip id="a" depart="0" from="W0>0,0" to="0,1>E0"/>'
        '<trip id="b" depart="1" from="W0>0,0" to="0,1>E0" via="1,0>1,1"/>'
        '<trip id="c" depart="2" from="W0>0,0" to="W0>0,0"/>'
        '<trip id="d" depart="3" fromJunction="W0" toJunction="E1"/>'
        '<trip id="e" depart="4" fromJunction="W0" to="0,0>N0"/>'
    )
    vehicles = drawn(demand)
    assert ids(vehicles, 0) == ACROSS.split()
    assert ids(vehicles, 1) == ["W0>0,0", "0,0>1,0", "1,0>1,1", "1,1>0,1", "0,1>E0"]
    assert ids(vehicles, 2) == ["W0>0,0"]
    route = ids(vehicles, 3)
    assert (route[0], route[-1], len(route)) == ("W0>0,0", "1,1>E1", 4)
    assert ids(vehicles, 4) == ["W0>0,0", "0,0>N0"]


def test_a_route_can_repeat_and_a_distribution_draws_among_routes(read):
    demand = read(
        '<route id="loop" edges="0,0>0,1 0,1>1,1 1,1>1,0 1,0>0,0" repeat="1"/>'
        '<vehicle id="round" depart="0" route="loop"/>'
        '<routeDistribution id="some"><route id="n" edges="W0>0,0 0,0>N0" probability="3"/>'
        '<route refId="loop" probability="0"/><route edges="W0>0,0" probability="1"/>'
        "</routeDistribution>"
        '<routeDistribution id="named" routes="n loop" probabilities="1 1"/>'
        '<flow id="f" begin="1" end="401" number="400" route="some"/>'
        '<vehicle id="last" depart="500" route="named"/>'
    )
    vehicles = drawn(demand)
    assert ids(vehicles, 0) == ["0,0>0,1", "0,1>1,1", "1,1>1,0", "1,0>0,0"] * 2
    assert vehicles.depart_s.tolist() == [*range(401), 500]
    two = sum(len(ids(vehicles, vehicle)) == 2 for vehicle in range(1, 401))
    assert 260 < two < 340
    assert two == sum(len(ids(drawn(demand), vehicle)) == 2 for vehicle in range(1, 401))
    assert drawn(demand, seed=1).route_links.tobytes() != vehicles.route_links.tobytes()


def test_a_flow_of_one_route_and_the_draws_share_one_order(read):
    demand = read(
        '<flow id="p" begin="0" end="50" probability="1"><route edges="W0>0,0"/></flow>'
        '<flow id="f" begin="0" end="50" period="10" from="W0>0,0" to="0,0>N0"/>'
    )
    vehicles = drawn(demand)
    assert vehicles.depart_s.tolist() == sorted([*range(50), *range(0, 50, 10)])
    assert [len(ids(vehicles, vehicle)) for vehicle in (0, 1, 2)] == [2, 1, 1]


def test_what_sumo_needs_to_know_of_a_vehicle_is_kept(read):
    demand = read(
        '<vType id="car" length="4" minGap="1.5"><param key="k" value="v"/></vType>'
        '<vehicle id="a" type="car" depart="0" departLane="best" departSpeed="max" arrival="9">'
        '<route edges="ACROSS"/></vehicle>'
        f"{ONE.replace('0', '1', 1)}"
        '<trip id="c" type="car" depart="2" departLane="best" departSpeed="max" '
        'from="W0>0,0" to="0,0>N0"/>'
    )
    car = {"type": "car", "departLane": "best", "departSpeed": "max"}
    assert [demand.kinds[kind] for kind in drawn(demand).kind] == [car, {}, car]
    assert demand.vehicle_types_xml == (
        '<vType id="car" length="4" minGap="1.5"><param key="k" value="v" /></vType>\n'
    )
    assert demand.vehicle_space_m == pytest.approx((2 * 5.5 + 7.5) / 3, abs=0.001)
    twice = drawn(demand.scaled(2)).kind
    assert [demand.kinds[kind] for kind in twice] == [car, car, {}, {}, car, car]


def test_the_space_of_a_vehicle_follows_its_class_and_its_distribution(read):
    demand = read(
        '<vType id="bus" vClass="bus"/><vType id="long" length="9.5"/>'
        '<vTypeDistribution id="mixed" vTypes="bus long" probabilities="1 3"/>'
        '<vTypeDistribution id="own"><vType id="t" vClass="truck" probability="1"/>'
        '<vType refId="bus" probability="0"/></vTypeDistribution>'
        '<vehicle id="a" type="mixed" depart="0"><route edges="ACROSS"/></vehicle>'
        '<vehicle id="b" type="own" depart="0"><route edges="ACROSS"/></vehicle>'
    )
    mixed, own = (14.5 + 3 * 12.0) / 4, 7.1 + 2.5
    assert demand.vehicle_space_m == pytest.approx((mixed + own) / 2, abs=0.001)


def test_additional_files_give_types_and_routes_and_their_other_definitions_are_counted(read):
    demand = read(
        '<vehicle id="a" type="car" route="r" depart="0"/>',
        additional=[
            '<vType id="car" length="3"/><busStop id="stop" lane="x_0"/><tlLogic id="t"/>',
            '<route id="r" edges="ACROSS"/><rerouter id="w"/>',
        ],
    )
    assert demand.vehicle_space_m == 5.5
    assert kinds(demand) == {"rerouter": (1, "w")}


def test_vehicles_of_additional_files_drive_in_any_order_and_alone(read):
    vehicle = '<vehicle id="{}" depart="{}"><route edges="ACROSS"/></vehicle>'
    more = [vehicle.format("b", 9) + vehicle.format("c", 3)]
    demand = read(vehicle.format("a", 5), additional=more)
    assert demand.recorded.recorded.depart_s.tolist() == [3, 5, 9]
    assert kinds(demand) == {}


@pytest.mark.parametrize(
    ("text", "kind", "count"),
    [
        ('<trip id="x" depart="5" from="0,0>W0" to="W0>0,0"/>', "no-way", 1),
        ('<vehicle id="x" depart="5"><route edges="W0>0,0 0,1>E0"/></vehicle>', "no-way", 1),
        ('<trip id="x" depart="5" from="W0>0,0" to="E9"/>', "unknown-road", 1),
        ('<trip id="x" depart="5" from="W0>0,0" to="0,0>N0" via="E9"/>', "unknown-road", 1),
        ('<trip id="x" depart="5" fromJunction="Q" to="0,0>N0"/>', "unknown-road", 1),
        ('<trip id="x" depart="5" from="W0>0,0" toJunction="Q"/>', "unknown-road", 1),
        ('<trip id="x" depart="triggered" from="a" to="b"/>', "no-fixed-departure", 1),
        ('<flow id="x" begin="triggered" number="2" from="a" to="b"/>', "no-fixed-departure", 1),
        ('<trip id="x" depart="5" fromTaz="1" toTaz="2"/>', "zone", 1),
        ('<trip id="x" depart="5" from="W0>0,0"><stop lane="l"/></trip>', "stops-only", 1),
        ('<trip id="x" depart="5"><stop lane="l"/></trip>', "stops-only", 1),
        (f'{BICYCLE}<trip id="x" type="b" depart="5" from="q" to="q"/>', "no-road-vehicle", 1),
        (f'{BICYCLE}<flow id="x" type="b" end="9" number="4" route="q"/>', "no-road-vehicle", 4),
        ('<trip id="x" type="DEFAULT_BIKETYPE" depart="5" from="q"/>', "no-road-vehicle", 1),
        ('<person id="x" depart="5"><walk edges="q"/></person>', "person", 1),
        ('<personFlow id="x" begin="5" end="9" number="2"/>', "person-elsewhere", 1),
    ],
)
def test_what_cannot_be_simulated_is_left_out_and_counted(read, text, kind, count):
    demand = read(f"{ONE}{text}")
    assert len(drawn(demand)) == 1
    assert kinds(demand) == {kind: (count, "x")}
    assert len(demand.remarks[0].text) > 20


def test_stops_and_parameters_are_noted_and_their_vehicles_drive(read):
    demand = read(
        '<trip id="x" depart="0" from="W0>0,0" to="0,0>N0" departEdge="1">'
        '<stop lane="l"/><param key="k" value="v"/></trip>'
    )
    assert len(drawn(demand)) == 1
    assert kinds(demand) == {"stops-off": (1, "x"), "parameters": (1, "x"), "route-part": (1, "x")}


def test_a_remark_names_the_road(read):
    demand = read(f'{ONE}<trip id="x" depart="5" from="W0>0,0" to="E9"/>')
    assert demand.remarks[0].text.endswith("(at 'E9')")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<vehicle depart='0'/>", r"line 2, column 1: vehicle '': its attribute 'id' is missing"),
        ('<trip id="x" from="a" to="b"/>', "trip 'x': its attribute 'depart' is missing"),
        ('<trip id="x" depart="soon" from="a" to="b"/>', "depart is 'soon'; expected seconds"),
        ('<trip id="x" depart="-1" from="a" to="b"/>', "depart is '-1'"),
        ('<trip id="x" depart="1:2" from="a" to="b"/>', "depart is '1:2'"),
        ('<trip id="x" depart="1e99" from="a" to="b"/>', "depart is '1e99'"),
        ('<trip id="x" depart="0" from="W0>0,0"/>', "trip 'x': it has no 'to'"),
        ('<trip id="x" depart="0" to="W0>0,0"/>', "trip 'x': it has no 'from'"),
        ('<vehicle id="x" depart="0"/>', "vehicle 'x': it has no route"),
        ('<vehicle id="x" depart="0" route="r"/>', "vehicle 'x': there is no route 'r'"),
        (f'{ONE}<trip id="v" depart="0" from="a" to="b"/>', "another vehicle of this id"),
        ('<vehicle id="x" type="t" depart="0"/>', "vehicle 'x': there is no vehicle type 't'"),
        ('<vType id="t"/><vType id="t"/>', "vType 't': there is another vehicle type of this id"),
        ('<vType id="t" length="0"/>', "length is '0'; expected a number of 0.1 or more"),
        ('<vType id="t" minGap="wide"/>', "minGap is 'wide'"),
        ('<vTypeDistribution id="t"/>', "vTypeDistribution 't': it has no types"),
        ('<vTypeDistribution id="t" vTypes="a"/>', "there is no vehicle type 'a'"),
        (f'{BICYCLE}<vTypeDistribution id="t" vTypes="b" probabilities="1 2"/>', "expected 1 num"),
        ('<route id="r" edges="a"/><route id="r" edges="a"/>', "another route of this id"),
        ('<route id="r"/>', "route 'r': its attribute 'edges' is missing"),
        ('<routeDistribution id="r"/>', "routeDistribution 'r': it has no routes"),
        ('<routeDistribution id="r" routes="q"/>', "there is no route 'q'"),
    ],
)
def test_what_sumo_would_refuse_is_an_error_with_its_place(read, text, message):
    with pytest.raises(DemandError, match=message) as caught:
        read(text)
    assert "routes.xml, line 2, column" in str(caught.value)


def test_the_routes_of_another_network_are_one_error(read):
    text = "".join(f'<trip id="t{k}" depart="{k}" from="A{k}" to="B"/>' for k in range(20))
    with pytest.raises(DemandError, match="'t0': it goes over 'A0', which the network") as caught:
        read(text)
    assert "so do 20 of 20 vehicles" in str(caught.value)
    assert "check that network and routes belong together" in str(caught.value).lower()


def test_if_no_vehicle_departs_in_time_the_first_departure_is_named(read):
    text = ONE.replace('depart="0"', 'depart="25205.5"')
    message = r"no vehicle departs from 0 s on and before 3600 s.*the first is at 25205.5 s"
    with pytest.raises(DemandError, match=f"{message}.*Set the begin to 25205"):
        read(text, end_s=3600)
    with pytest.raises(DemandError, match=r"no vehicle departs from 30000 s on; .*Set the begin"):
        read(text, begin_s=30000)
    assert len(drawn(read(text, begin_s=25205))) == 1


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", r"routes.xml: no vehicle; expected .*Name the files that have them; where a program"),
        (
            '<person id="p" depart="0"><walk edges="q"/></person>',
            "routes.xml: no vehicle; expected",
        ),
        (
            '<trip id="x" depart="5" from="0,0>W0" to="W0>0,0"/>',
            "no vehicle is left of 1; 1 cannot",
        ),
    ],
)
def test_there_must_be_a_vehicle(read, text, message):
    with pytest.raises(DemandError, match=message):
        read(text)


def test_what_is_no_route_file_is_refused(read, tmp_path):
    with pytest.raises(DemandError, match=r"its root element is <net>.*a SUMO network"):
        read("", root="net")
    with pytest.raises(DemandError, match=r"gone.xml: there is no such file"):
        read_sumo_routes(tmp_path / "gone.xml", NETWORK)
    path = tmp_path / "cut.xml"
    path.write_text('<routes>\n<trip id="a" depart="0" from=')
    with pytest.raises(DemandError, match="cut off"):
        read_sumo_routes([path], NETWORK)
    path.write_text('<!DOCTYPE routes [<!ENTITY a SYSTEM "/etc/hosts">]><routes>&a;</routes>')
    with pytest.raises(DemandError, match="DOCTYPE"):
        read_sumo_routes(path, NETWORK)


def test_several_files_are_each_in_order_of_their_own(tmp_path):
    for name, depart in (("late", 9), ("early", 2)):
        (tmp_path / name).write_text(
            f'<routes><trip id="{name}" depart="{depart}" from="W0>0,0" to="0,0>N0"/></routes>'
        )
    demand = read_sumo_routes([tmp_path / "late", tmp_path / "early"], NETWORK)
    assert drawn(demand).depart_s.tolist() == [2, 9]
    assert demand.remarks == ()


def test_nothing_is_drawn_where_nothing_is_random(read):
    rng, untouched = stream(1), stream(1)
    read(ONE).vehicles(NETWORK, 100, rng)
    assert rng.random() == untouched.random()


def test_the_demand_can_be_scaled_travels_and_knows_its_network(read):
    demand = read(
        f'{ONE}<flow id="f" begin="1" end="9" probability="1" route="r"/>'.replace(
            ONE, f'<route id="r" edges="ACROSS"/>{ONE}'
        )
    )
    assert len(drawn(demand.scaled(2).scaled(1.5))) == 27
    assert drawn(demand, 5).dropped == 0
    copy = pickle.loads(pickle.dumps(demand))
    assert drawn(copy).route_links.tobytes() == drawn(demand).route_links.tobytes()
    with pytest.raises(DemandError, match="not on 'grid:1x2'"):
        demand.vehicles(grid(1, 2), 10, stream(0))
    with pytest.raises(DemandError, match="the horizon is 0 s"):
        drawn(demand, 0)
