"""The queue simulator against results of queueing and traffic-flow theory, one phenomenon each."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from dmil.demand import FileDemand, PoissonDemand
from dmil.demand.routes import router
from dmil.network import Intersection, Link, Movement, RoadNetwork, check_network, grid
from dmil.scenarios import QueueDynamics, Scenario, SignalTiming
from dmil.seeding import stream
from dmil.simulation import QueueSimulator

GREEN, RED = 0, 1
"""Phases of the crossing: the stream from A goes, or the one from B."""


def crossing(approach_m=0.0, lanes=1):
    """Two streams, A>X>C and B>X>D, that cross and never go together."""
    return _chain("crossing", ["X"], approach_m, lanes)


def tandem(inner_m, approach_m=0.0):
    """Two crossings one behind the other: A>X>Y>C, each with a cross stream of its own."""
    network = _chain("tandem", ["X", "Y"], approach_m, 1)
    links = (replace(k, length_m=inner_m) if k.id == "X>Y" else k for k in network.links)
    return replace(network, links=tuple(links))


def _chain(name, nodes, approach_m, lanes):
    path = ["A", *nodes, "C"]
    links = [
        Link(f"{a}>{b}", a, b, 0.0 if b == "C" else approach_m, 10.0, lanes)
        for a, b in pairwise(path)
    ]
    intersections, fringe = [], ["A", "C"]
    for k, node in enumerate(nodes):
        before, after = path[k], path[k + 2]
        side = [f"B{node}", f"D{node}"]
        fringe += side
        links += [Link(f"{side[0]}>{node}", side[0], node, approach_m, 10.0, lanes)]
        links += [Link(f"{node}>{side[1]}", node, side[1], 0.0, 10.0, 1)]
        movements = (
            Movement(f"{before}>{node}", f"{node}>{after}", "straight", 0, tuple(range(lanes))),
            Movement(f"{side[0]}>{node}", f"{node}>{side[1]}", "straight", 1, tuple(range(lanes))),
        )
        intersections.append(
            Intersection(node, movements, (frozenset({0}), frozenset({1})), frozenset())
        )
    position_m = {node: (float(k), 0.0) for k, node in enumerate((*path, *fringe[2:]))}
    network = RoadNetwork(name, tuple(links), tuple(intersections), tuple(fringe), position_m)
    check_network(network)
    return network


def start(network, horizon_s, depart_s, route, *, timing=None, **dynamics):
    """Begin a run of vehicles that all take one route."""
    scenario = Scenario(
        network.name,
        network,
        PoissonDemand(),
        timing or SignalTiming(decision_interval_s=1),
        QueueDynamics(**dynamics),
        horizon_s,
    )
    demand = FileDemand.from_routes(network, depart_s, [route] * len(depart_s))
    simulator = QueueSimulator(scenario)
    simulator.reset(demand.vehicles(network, horizon_s, stream(0, "not used")))
    return simulator


def show(simulator, phase_at):
    """Run to the horizon; `phase_at(time_s)` is what every intersection shows."""
    for time_s in range(0, simulator.horizon_s, simulator.decision_interval_s):
        simulator.advance(np.full(len(simulator.network.intersections), phase_at(time_s), np.int32))
    return simulator.measures()


STRAIGHT = ["A>X", "X>C"]


# --- Saturation flow -------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("lanes", "flow_veh_per_s"),
    [
        (1, 1.0),
        (1, 0.5),
        (1, 1 / 3),
        (1, 0.4),
        (2, 0.75),
        (2, 1.0),
        (3, 1.0),
        (3, 0.4),
    ],
)
def test_a_standing_queue_discharges_at_saturation_flow(lanes, flow_veh_per_s):
    network, count = crossing(lanes=lanes), 40
    horizon_s = round(count / (lanes * flow_veh_per_s)) + 5
    simulator = start(
        network, horizon_s, [0] * count, STRAIGHT, saturation_flow_veh_per_s=flow_veh_per_s
    )
    show(simulator, lambda time_s: GREEN)
    # The k-th vehicle of a lane crosses k headways after its first, in the step of that moment.
    headway_s = 1 / flow_veh_per_s
    expected = [math.floor(k // lanes * headway_s + 1e-6) for k in range(count)]
    assert simulator.state.arrived_s.tolist() == expected


def test_a_platoon_that_arrives_at_saturation_flow_does_not_wait():
    simulator = start(crossing(), 50, range(50), STRAIGHT)
    measures = show(simulator, lambda time_s: GREEN)
    assert (measures.arrived_veh, measures.wait_veh_s) == (50, 0)


# --- A fixed cycle ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("every_s", "red_s", "cycle_s"),
    [(2, 20, 40), (2, 7, 20), (3, 20, 60), (5, 40, 60), (11, 30, 66)],
)
def test_the_uniform_delay_of_a_fixed_cycle_is_a_triangle(every_s, red_s, cycle_s):
    # One vehicle every a steps, red for R steps of a cycle of C. Vehicle k of a cycle arrives at
    # k·a and crosses at R + k while there is a queue: it waits R − k(a−1), until that is 0. With m
    # vehicles delayed the sum is m·R − (a−1)·m(m−1)/2; where (a−1) divides R it is
    # R(R + a−1) / (2(a−1)), which for many small steps is the textbook's triangle of area
    # R² q/(2(1−q)), q = 1/a.
    assert cycle_s % every_s == 0
    cycles = 6
    simulator = start(crossing(), cycles * cycle_s, range(0, cycles * cycle_s, every_s), STRAIGHT)
    measures = show(simulator, lambda time_s: RED if time_s % cycle_s < red_s else GREEN)
    delayed = math.ceil(red_s / (every_s - 1))
    assert delayed + red_s <= cycle_s  # the queue is gone before the next red
    sum_s = delayed * red_s - (every_s - 1) * delayed * (delayed - 1) // 2
    if red_s % (every_s - 1) == 0:
        assert sum_s == red_s * (red_s + every_s - 1) / (2 * (every_s - 1))
    assert measures.wait_veh_s == cycles * sum_s
    assert measures.wait_per_arrived_s == pytest.approx(sum_s * every_s / cycle_s, rel=1e-12)


@pytest.mark.parametrize(("red_s", "cycle_s"), [(30, 60), (12, 20), (7, 10)])
@pytest.mark.parametrize("flow_veh_per_s", [1.0, 0.5])
def test_capacity_is_the_green_ratio_times_saturation_flow(red_s, cycle_s, flow_veh_per_s):
    # One arrival per step is more than any of these signals can serve.
    cycles, green_s = 12, cycle_s - red_s
    simulator = start(
        crossing(),
        cycles * cycle_s,
        range(cycles * cycle_s),
        STRAIGHT,
        saturation_flow_veh_per_s=flow_veh_per_s,
    )
    measures = show(simulator, lambda time_s: RED if time_s % cycle_s < red_s else GREEN)
    served = math.ceil(green_s * flow_veh_per_s)
    assert measures.arrived_veh == cycles * served
    # The queue grows by the difference of demand and capacity, cycle by cycle.
    at_end_of_cycle = measures.queued_at[cycle_s - 1 :: cycle_s]
    assert np.diff(at_end_of_cycle).tolist() == [cycle_s - served] * (cycles - 1)


# --- Free flow -------------------------------------------------------------------------------


def without_conflicts(network):
    """Let everybody go at the same time."""
    return replace(
        network,
        intersections=tuple(
            replace(node, phases=(frozenset(range(len(node.movements))),), unsignalled=frozenset())
            for node in network.intersections
        ),
    )


def test_a_lonely_vehicle_needs_five_seconds_per_inner_link():
    network = without_conflicts(grid(3, 4))
    ways = router(network)
    for origin in network.fringe:
        for destination in set(network.fringe) - {origin}:
            for way, _ in ways.between_nodes(origin, destination):
                route = [network.links[k].id for k in way]
                measures = show(start(network, 40, [3], route), lambda time_s: 0)
                assert (measures.arrived_veh, measures.wait_veh_s) == (1, 0)
                assert measures.travel_time_s == 5 * (len(route) - 2)
                assert measures.visits == len(route) - 1


def test_a_vehicle_straight_across_the_papers_network_needs_twenty_seconds():
    route = ["W2>2,0", "2,0>2,1", "2,1>2,2", "2,2>2,3", "2,3>2,4", "2,4>E2"]
    simulator = start(grid(5, 5), 60, [7], route, timing=SignalTiming())
    measures = show(simulator, lambda time_s: 0)
    assert simulator.state.arrived_s.tolist() == [27]
    assert measures.wait_veh_s == 0


def test_roads_take_their_length_over_their_speed():
    # 84 m and 126 m at 10 m/s are 8 s and 13 s in whole steps.
    network = without_conflicts(tandem(inner_m=126.0, approach_m=84.0))
    simulator = start(network, 60, [5], ["A>X", "X>Y", "Y>C"])
    show(simulator, lambda time_s: 0)
    assert simulator.state.arrived_s.tolist() == [5 + 8 + 13]


# --- Lost time -------------------------------------------------------------------------------


def arrivals_after_a_change(**timing):
    """Queue 30 vehicles, give way to the other stream for 20 s, then green; when do they arrive?"""
    rules = SignalTiming(decision_interval_s=10, **timing)
    simulator = start(crossing(), 100, [0] * 30, STRAIGHT, timing=rules)
    show(simulator, lambda time_s: RED if time_s < 20 else GREEN)
    return simulator.state.arrived_s


def test_without_lost_time_a_queue_starts_with_the_green():
    assert arrivals_after_a_change().tolist() == list(range(20, 50))


@pytest.mark.parametrize("lost_s", [1, 2, 7])
def test_start_up_lost_time_shifts_the_discharge(lost_s):
    shifted = arrivals_after_a_change(startup_lost_s=lost_s)
    np.testing.assert_array_equal(shifted, arrivals_after_a_change() + lost_s)


@pytest.mark.parametrize("clearance_s", [1, 4, 9])
def test_clearance_and_start_up_lost_time_add_up(clearance_s):
    shifted = arrivals_after_a_change(clearance_s=clearance_s, startup_lost_s=3)
    np.testing.assert_array_equal(shifted, arrivals_after_a_change() + clearance_s + 3)


@pytest.mark.parametrize("clearance_s", [0, 1, 3, 5])
def test_clearance_reduces_capacity_by_its_share(clearance_s):
    # Two overloaded streams take turns of 10 s; every turn after the first loses the clearance.
    network, cycles = crossing(), 15
    rules = SignalTiming(decision_interval_s=10, clearance_s=clearance_s)
    scenario = Scenario(
        "both", network, PoissonDemand(), rules, QueueDynamics(), horizon_s=20 * cycles
    )
    routes = [STRAIGHT, ["BX>X", "X>DX"]] * 200
    simulator = QueueSimulator(scenario)
    demand = FileDemand.from_routes(network, [0] * 400, routes)
    simulator.reset(demand.vehicles(network, 20 * cycles, stream(0, "not used")))
    measures = show(simulator, lambda time_s: GREEN if time_s % 20 < 10 else RED)
    assert measures.arrived_veh == 2 * cycles * (10 - clearance_s) + clearance_s


def test_minimum_green_makes_a_hasty_controller_wait():
    # Asked to change every 10 s, the signal changes every 30 s.
    rules = SignalTiming(decision_interval_s=10, min_green_s=25)
    simulator = start(crossing(), 120, [0] * 120, STRAIGHT, timing=rules)
    shown = []
    while len(shown) < 12:
        before = simulator.advance(np.array([RED if not shown or shown[-1] == GREEN else GREEN]))
        shown.append(int(before.phase[0]))
    assert shown == ([RED] * 3 + [GREEN] * 3) * 2
    assert simulator.measures().overruled == 8
    assert simulator.measures().arrived_veh == 60


# --- Spillback -------------------------------------------------------------------------------


def test_a_full_road_stops_the_queue_behind_it_and_loses_nobody():
    # 30 m of one lane hold 4 vehicles of 7.5 m. Y is red for 40 s while X is green.
    network = tandem(inner_m=30.0, approach_m=60.0)
    simulator = start(network, 80, range(20), ["A>X", "X>Y", "Y>C"], storage=True)
    inner, entry = network.link_index["X>Y"], network.link_index["A>X"]
    on_inner, on_entry, arrived = [], [], []
    for time_s in range(80):
        simulator.advance(np.array([GREEN, RED if time_s < 40 else GREEN], np.int32))
        on_inner.append(int(simulator.state.occupancy_veh[inner]))
        on_entry.append(int(simulator.state.occupancy_veh[entry]))
        arrived.append(simulator.measures().arrived_veh)
    # The first needs 6 s to X; one per second enters the inner road until its 4 places are taken.
    assert on_inner[:40] == [0] * 6 + [1, 2, 3] + [4] * 31
    # Then the entry road fills to its 8 places, and the other vehicles wait outside.
    assert max(on_entry) == 8
    assert on_entry[20:40] == [8] * 20
    assert simulator.measures().queued_at[39] == 20 - simulator.measures().arrived_at[39]
    assert arrived[39] == 0
    # A vehicle that leaves makes a place, which X, earlier in the order, fills 1 s later; the next
    # vehicle then drives 3 s. So 4 cross Y in every 4 s: one per second, and nobody is lost.
    assert arrived[40:60] == list(range(1, 21))
    assert arrived[-1] == 20
    assert simulator.state.occupancy_veh.sum() == 0


def test_unlimited_storage_never_stops_a_queue():
    network = tandem(inner_m=30.0, approach_m=60.0)
    simulator = start(network, 40, range(20), ["A>X", "X>Y", "Y>C"])
    for _ in range(40):
        simulator.advance(np.array([GREEN, RED], np.int32))
    assert simulator.state.queue_veh.tolist() == [[0, 0], [20, 0]]


@pytest.mark.parametrize("road_m", [3.0, 7.0, 8.0])
def test_the_shortest_road_holds_one_vehicle(road_m):
    network = tandem(inner_m=road_m)
    simulator = start(network, 60, [0] * 10, ["A>X", "X>Y", "Y>C"], storage=True)
    inner = network.link_index["X>Y"]
    for _ in range(60):
        simulator.advance(np.array([GREEN, GREEN], np.int32))
        assert simulator.state.occupancy_veh[inner] <= 1
    assert simulator.measures().arrived_veh == 10
