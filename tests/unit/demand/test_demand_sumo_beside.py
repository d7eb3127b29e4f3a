"""What SUMO runs beside the vehicles of the demand: bicycles, stops, rerouters."""

from xml.etree import ElementTree

import pytest

BICYCLE = '<vType id="b" vClass="bicycle"/>'
CAR = '<vehicle id="car" depart="1"><route edges="ACROSS"/></vehicle>'
ROUTE = '<route id="r" edges="ACROSS"/>'
HALT = '<busStop id="halt" lane="0,0>0,1_0" startPos="9" endPos="29"/>'


def elements(text):
    return list(ElementTree.fromstring(f"<x>{text}</x>"))


def inner(demand):
    return [elements(text) for text in demand.beside.inner_xml]


def remarks(demand):
    return {each.kind: each.count for each in demand.remarks}


def test_bicycles_are_sumos_alone_and_their_ids_are_no_numbers(read):
    demand = read(
        BICYCLE + '<vehicle id="7" type="b" depart="9"><route edges="lane 0,1>E0"/></vehicle>'
        '<flow id="8" type="b" begin="9.5" end="30" period="10" from="W0>0,0" to="lane"/>',
        additional=[CAR],
        end_s=25,
    )
    first, second, third = elements(demand.beside.vehicles_xml)
    assert [each.tag for each in (first, second, third)] == ["vehicle", "trip", "trip"]
    assert (first.get("id"), first.get("depart"), first.get("type")) == ("beside:7.0", "9.000", "b")
    assert first[0].get("edges") == "lane 0,1>E0"
    assert third.attrib == {
        "id": "beside:8.2",
        "depart": "19.500",
        "type": "b",
        "from": "W0>0,0",
        "to": "lane",
    }
    assert len(demand.recorded.recorded) == 1
    assert remarks(demand) == {"after-end": 1, "no-road-vehicle": 3}


def test_bicycles_of_a_distribution_are_sumos_alone_too(read):
    demand = read(
        '<vTypeDistribution id="d"><vType id="c"/><vType id="b" vClass="bicycle"/>'
        "</vTypeDistribution>"
        + CAR
        + ROUTE
        + '<flow id="f" type="d" begin="2" number="40" period="1" route="r"/>'
    )
    aside = remarks(demand)["no-road-vehicle"]
    assert 5 < aside < 35
    assert len(demand.recorded.recorded) == 41 - aside
    found = elements(demand.beside.vehicles_xml)
    assert len({each.get("id") for each in found}) == len(found) == aside
    assert {each.get("type") for each in found} == {"b"}
    assert demand.vehicle_space_m == 7.5


def test_flows_at_random_stay_flows_under_a_scale(read):
    demand = read(
        BICYCLE
        + CAR
        + '<flow id="p" type="b" begin="2" end="30" probability="0.2" from="q" to="r"/>'
        '<flow id="e" type="b" begin="3" number="5" period="exp(0.25)" from="q" to="r"/>',
        scale=2,
        end_s=20,
    )
    found = [each.attrib for each in elements(demand.beside.vehicles_xml)]
    assert {**found[0]} == {
        "id": "beside:p.0", "type": "b", "from": "q", "to": "r",
        "begin": "2.000", "end": "20.000", "probability": "0.4",
    }  # fmt: skip
    assert (found[1]["period"], found[1]["number"]) == ("exp(0.5)", "10")


def test_routes_that_sumo_alone_needs_come_with_those_that_they_name(read):
    both = f'{ROUTE}<route id="other" edges="x y"/><routeDistribution id="d" routes="r other"/>'
    demand = read(both + BICYCLE + CAR + '<vehicle id="v" type="b" depart="2" route="d"/>')
    found = [(each.tag, each.get("id")) for each in elements(demand.beside.definitions_xml)]
    assert found == [("route", "r"), ("route", "other"), ("routeDistribution", "d")]
    assert elements(demand.beside.vehicles_xml)[0].get("route") == "d"
    assert read(both + CAR).beside.definitions_xml == ""


def test_rerouters_and_signs_stand_behind_what_they_name(read, tmp_path):
    acting = (
        '<rerouter id="w" edges="0,0>0,1"><interval begin="0" end="9">'
        '<routeProbReroute id="r"/></interval></rerouter>'
        '<variableSpeedSign id="s" lanes="0,0>0,1_0" file="limits.xml"/>'
    )
    demand = read(CAR, additional=[acting.replace("<rerouter", ROUTE + "<rerouter", 1), HALT])
    found = elements(demand.beside.definitions_xml)
    assert [each.get("id") for each in found] == ["halt", "r", "w", "s"]
    assert found[3].get("file") == str(tmp_path / "limits.xml")
    assert remarks(demand) == {"rerouter": 1, "speed-sign": 1}


@pytest.mark.parametrize(
    "stop",
    ['lane="0,0>0,1_0"', 'edge="0,0>0,1"', 'busStop="halt"'],
)
def test_stops_are_handed_on_wherever_they_are_named(read, stop):
    stop = f'<stop {stop} duration="20"/>'
    ways = (
        f'<vehicle id="a" depart="0"><route edges="ACROSS"/>{stop}</vehicle>'
        f'<vehicle id="b" depart="1"><route edges="ACROSS">{stop}</route></vehicle>'
        f'<route id="r" edges="ACROSS">{stop}</route><vehicle id="c" depart="2" route="r"/>'
        f'<trip id="d" depart="3" from="W0>0,0" to="0,1>E0">{stop}</trip>'
    )
    demand = read(ways, additional=[HALT])
    assert remarks(demand) == {"stops": 4}
    (only,) = inner(demand)  # all are alike
    assert only[0].attrib == ElementTree.fromstring(stop).attrib


def test_a_trip_goes_by_way_of_its_stops(read):
    trip = '<trip id="d" depart="3" from="W0>0,0" to="0,1>E0">{}</trip>'
    demand = read(trip.format('<stop edge="1,0>1,1" duration="20"/>'))
    assert "1,0>1,1" in [
        demand.recorded.network.links[k].id for k in demand.recorded.recorded.route(0)
    ]
    assert dict(demand.trips[0])["via"] == "1,0>1,1"
    assert remarks(demand) == {"stops": 1}
    assert remarks(read(trip.format('<stop edge="W0>0,0" duration="20"/>'))) == {"stops": 1}


@pytest.mark.parametrize(
    "stop",
    [
        'edge="1,0>1,1" duration="20"',
        'edge="0,0>0,1"',
        'edge="0,0>0,1" duration="20" triggered="true"',
        'busStop="unknown" duration="20"',
    ],
)
def test_stops_that_cannot_be_made_are_told_and_dropped(read, stop):
    demand = read(f'<vehicle id="a" depart="0"><route edges="ACROSS"/><stop {stop}/></vehicle>')
    assert remarks(demand) == {"stops-off": 1}
    assert inner(demand) == [[]]


def test_times_of_stops_move_with_the_vehicles_of_a_flow(read):
    flow = '<flow id="f" {} begin="10" number="2" period="60" route="r"/>'
    route = '<route id="r" edges="ACROSS"><stop edge="0,0>0,1" until="50"/></route>'
    demand = read(route + flow.format(""))
    kinds = demand.recorded.recorded.kind.tolist()
    assert [inner(demand)[kind][0].get("until") for kind in kinds] == ["50", "110"]
    bicycles = elements(read(CAR + BICYCLE + route + flow.format('type="b"')).beside.vehicles_xml)
    assert [each.find("route/stop").get("until") for each in bicycles] == ["50", "110"]


def test_sumo_keeps_the_rerouting_device_and_no_other(read):
    on = '<param key="has.{}.device" value="true"/>'
    given = on.format("rerouting") + on.format("taxi")
    demand = read(
        f'<vType id="t">{given}</vType>'
        f'<vehicle id="v" type="t" depart="1"><route edges="ACROSS"/>{given}</vehicle>'
    )
    (kept,) = elements(demand.beside.types_xml)[0].findall("param")
    assert kept.get("key") == "has.rerouting.device"
    assert [each.get("key") for each in inner(demand)[0]] == ["has.rerouting.device"]
    assert "param" not in demand.vehicle_types_xml
