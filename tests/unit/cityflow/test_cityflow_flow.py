"""Reading CityFlow's flow files."""

from itertools import pairwise

import pytest

from dmil.demand import read_cityflow_flow
from dmil.errors import DemandError
from dmil.network import read_cityflow_roadnet
from dmil.seeding import stream

RNG = stream(0, "unused")


@pytest.fixture
def network(crossing, write):
    return read_cityflow_roadnet(write(crossing()[0]))


@pytest.fixture
def read(network, write):
    def read_flows(*flows, **options):
        return read_cityflow_flow(write(list(flows), "flow.json"), network, **options)

    return read_flows


def flow(route=("E_in", "W_out"), start=0, end=None, interval=1.0):
    end = start if end is None else end
    # What CityFlow's simulation of single vehicles needs is ignored.
    vehicle = {"length": 5.0, "maxSpeed": 11.1}
    return {
        "vehicle": vehicle,
        "route": list(route),
        "interval": interval,
        "startTime": start,
        "endTime": end,
    }


def departures(demand, horizon_s=3600):
    return demand.vehicles(demand.network, horizon_s, RNG).depart_s.tolist()


def cityflow_departures(flow, until_s):
    """CityFlow's own counting, step by step: a clock per flow that is emptied by every vehicle."""
    clock, second, seconds = flow["interval"], 0, []
    while second < until_s and (flow["endTime"] == -1 or second <= flow["endTime"]):
        if second >= flow["startTime"]:
            while clock >= flow["interval"]:
                seconds.append(second)
                clock -= flow["interval"]
            clock += 1
        second += 1
    return seconds


@pytest.mark.parametrize(
    ("start", "end", "interval", "expected"),
    [
        (7, 7, 1.0, [7]),
        (0, 4, 1.0, [0, 1, 2, 3, 4]),
        (10, 20, 5.0, [10, 15, 20]),
        (10, 19, 5.0, [10, 15]),
        (0, 3, 0.5, [0, 1, 1, 2, 2, 3, 3]),
        (2, 8, 2.5, [2, 5, 7]),
        (0, 1, 1 / 4, [0, 1, 1, 1, 1]),
        (3, 5, 100.0, [3]),
        # Nothing runs before second 0: who would begin earlier begins then.
        (-7, 4, 2.0, [0, 2, 4]),
        (-7, -3, 2.0, []),
        (6, 5, 1.0, []),
    ],
)
def test_vehicles_appear_when_cityflow_lets_them(read, start, end, interval, expected):
    entry = flow(start=start, end=end, interval=interval)
    assert departures(read(entry)) == expected == cityflow_departures(entry, 3600)


def test_a_flow_without_end_needs_a_horizon(read):
    entry = flow(start=2, end=-1, interval=3.0)
    with pytest.raises(
        DemandError, match=r"\[0\]: it has no end \(endTime is -1\).*Give horizon_s"
    ):
        read(entry)
    assert departures(read(entry, horizon_s=12)) == [2, 5, 8, 11] == cityflow_departures(entry, 12)
    assert departures(read(entry, horizon_s=2)) == []


def test_vehicles_are_sorted_and_keep_the_files_order_within_a_second(read, network):
    demand = read(
        flow(("S_in", "N_out"), start=9),
        flow(("N_in", "S_out"), start=4),
        flow(("E_in", "N_out"), start=9),
    )
    vehicles = demand.vehicles(network, 10, RNG)
    assert vehicles.depart_s.tolist() == [4, 9, 9]
    routes = [[network.links[k].id for k in vehicles.route(v)] for v in range(3)]
    assert routes == [["N_in", "S_out"], ["S_in", "N_out"], ["E_in", "N_out"]]


def test_two_roads_with_a_gap_are_origin_and_destination(two_crossings, write):
    network = read_cityflow_roadnet(write(two_crossings))
    assert len(network.intersections) == 2
    path = write([flow(("E_in", "wN_out"))], "flow.json")
    vehicles = read_cityflow_flow(path, network).vehicles(network, 10, RNG)
    assert [network.links[k].id for k in vehicles.route(0)] == ["E_in", "W_out", "wN_out"]


def test_roads_that_are_not_adjacent_are_anchor_points(two_crossings, write):
    network = read_cityflow_roadnet(write(two_crossings))
    roads = ("E_in", "wN_out"), ("E_in", "W_out", "wN_out"), ("E_in", "E_in", "W_out", "wN_out")
    path = write([flow(route) for route in roads], "flow.json")
    vehicles = read_cityflow_flow(path, network).vehicles(network, 10, RNG)
    for vehicle in range(3):
        way = [network.links[k].id for k in vehicles.route(vehicle)]
        assert way == ["E_in", "W_out", "wN_out"]


def test_what_cityflow_drops_is_dropped_and_counted(two_crossings, write):
    network = read_cityflow_roadnet(write(two_crossings))
    path = write(
        [
            flow(start=5),
            flow(("E_in", "wW_out", "wW_in"), end=3),  # the second lies the other way
            flow(("E_in",)),
            flow(("N_in", "N_in")),
            flow(start=10, end=9),
            flow(start=-9, end=-4),
        ],
        "flow.json",
    )
    demand = read_cityflow_flow(path, network)
    assert departures(demand) == [5]
    assert [(each.kind, each.count, each.example) for each in demand.remarks] == [
        ("no-way", 4, "[1]"),
        ("one-road", 2, "[2]"),
        ("ends-first", 2, "[4]"),
    ]
    assert read_cityflow_flow(write([flow()], "flow.json"), network).remarks == ()


def test_a_vehicle_may_park_inside_the_network(two_crossings, write):
    network = read_cityflow_roadnet(write(two_crossings))
    path = write([flow(("E_in", "W_out"))], "flow.json")
    vehicles = read_cityflow_flow(path, network).vehicles(network, 10, RNG)
    assert [network.links[k].id for k in vehicles.route(0)] == ["E_in", "W_out"]


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        (flow(("E_in", "nowhere")), r"\[1\]: its route is over 'nowhere', which the network does"),
        (flow(()), r"\[1\]\.route: .*at least 1 item"),
        (flow(interval=0), r"\[1\]\.interval: .*greater than 0, but it is 0"),
        (flow(interval=float("nan")), r"\[1\]\.interval: .*finite"),
        (flow(start="soon"), r"\[1\]\.startTime: .*'soon'"),
        ({"route": ["E_in", "W_out"]}, r"\[1\]\.interval: this field is missing"),
        (5, r"\[1\]: "),
    ],
)
def test_a_wrong_entry_is_named(read, entry, message):
    with pytest.raises(DemandError, match=message) as caught:
        read(flow(), entry)
    assert "flow.json" in str(caught.value)


def test_the_vehicle_is_named_by_its_entry_in_the_file(read):
    with pytest.raises(DemandError, match=r"flow\.json: \[1\]: its route is over 'q'"):
        read(flow(end=50), flow(("q", "W_out")))


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("", "the file is empty"),
        ('[{"route": ["E_in"', "cut off in the middle"),
        ("route;start", "not JSON"),
        ("{}", "expected a CityFlow flow file"),
    ],
)
def test_a_file_that_is_no_flow_is_refused(network, tmp_path, content, message):
    path = tmp_path / "flow.json"
    path.write_text(content)
    with pytest.raises(DemandError, match=message):
        read_cityflow_flow(path, network)


def test_a_missing_file_is_refused(network, tmp_path):
    with pytest.raises(DemandError, match="there is no such file"):
        read_cityflow_flow(tmp_path / "flow.json", network)


@pytest.mark.data
@pytest.mark.parametrize(
    ("folder", "roadnet", "name", "count"),
    [
        ("jinan_3x4", "roadnet_3_4.json", "anon_3_4_jinan_real.json", 6295),
        ("jinan_3x4", "roadnet_3_4.json", "anon_3_4_jinan_real_2000.json", 4365),
        ("jinan_3x4", "roadnet_3_4.json", "anon_3_4_jinan_real_2500.json", 5494),
        ("hangzhou_4x4", "roadnet_4_4.json", "anon_4_4_hangzhou_real.json", 2983),
        ("hangzhou_4x4", "roadnet_4_4.json", "anon_4_4_hangzhou_real_5816.json", 6984),
    ],
)
def test_recorded_vehicles_are_all_read(data, folder, roadnet, name, count):
    network = read_cityflow_roadnet(data / folder / roadnet)
    demand = read_cityflow_flow(data / folder / name, network)
    vehicles = demand.vehicles(network, 3600, RNG)
    assert (len(vehicles), vehicles.dropped) == (count, 0)
    entries = set(network.entry_links)
    for vehicle in range(count):
        route = vehicles.route(vehicle).tolist()
        assert route[0] in entries
        assert all(pair in network.movement_index for pair in pairwise(route))
