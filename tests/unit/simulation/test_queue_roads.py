"""Real roads in the queue simulator: junctions, shared lanes, priority, own programs."""

from dataclasses import replace

import numpy as np
import pytest

from dmil.demand import FileDemand
from dmil.errors import InputError
from dmil.network import (
    Intersection,
    Junction,
    Link,
    Movement,
    Program,
    RoadNetwork,
    Stage,
    check_network,
)
from dmil.scenarios import QueueDynamics, scenario
from dmil.seeding import stream
from dmil.simulation import QueueSimulator
from dmil.simulation.queue.layout import build_layout, build_trips
from dmil.simulation.timing import PROGRAM


def vehicles_on(network, *journeys):
    """Make vehicles from (departure, link ids)."""
    seconds, routes = zip(*journeys, strict=True)
    return FileDemand.from_routes(network, seconds, routes).vehicles(network, 999, stream(0, "no"))


@pytest.fixture
def through_junctions():
    """A signal X that is reached over junctions without signals: P>J>X and Q>J, then X>K>Z."""
    ways = {"P>J": 30.0, "Q>J": 20.0, "J>X": 50.0, "X>K": 10.0, "K>Z": 14.0}
    links = tuple(Link(id, *id.split(">"), length_m, 10.0, 1) for id, length_m in ways.items())

    def way(first, second):
        return Movement(first, second, "straight", 0, (0,))

    merge = Junction("J", (way("P>J", "J>X"), replace(way("Q>J", "J>X"), approach=1)))
    exit_ = Junction("K", (way("X>K", "K>Z"),))
    signal = Intersection("X", (way("J>X", "X>K"),), (frozenset({0}),), frozenset())
    position_m = {node: (0.0, 0.0) for node in "PQJXKZ"}
    network = RoadNetwork(
        "junctions", links, (signal,), ("P", "Q", "Z"), position_m, (merge, exit_)
    )
    check_network(network)
    dynamics = QueueDynamics(storage=True, vehicle_space_m=10.0)
    return replace(scenario("grid:1x1"), network=network, dynamics=dynamics)


def test_junctions_without_signals_lie_within_legs(through_junctions):
    made, layout = through_junctions, build_layout(through_junctions)
    routes = (["P>J", "J>X", "X>K", "K>Z"], ["J>X", "X>K"], ["Q>J"])
    vehicles = vehicles_on(made.network, *((0, route) for route in routes))
    trips = build_trips(made, layout, vehicles)
    assert trips.movement_offset.tolist() == [0, 1, 2, 2]
    # 30 + 50 m and 10 + 14 m at 10 m/s; 50 m and 10 m; 20 m.
    assert trips.leg_s.tolist() == [8, 2, 5, 1, 2]
    legs = [made.network.links[k].id for k in trips.leg_link]
    assert legs == ["J>X", "K>Z", "J>X", "X>K", "Q>J"]
    # The approach has the room of all links that only lead to it.
    assert layout.capacity_veh[made.network.link_index["J>X"]] == 10


def test_measured_link_times_take_the_place_of_free_flow(through_junctions):
    made = replace(through_junctions, link_time_s=(4.0, 2.0, 7.0, 1.0, 1.4), horizon_s=40)
    vehicles = vehicles_on(made.network, (0, ["P>J", "J>X", "X>K", "K>Z"]))
    simulator = QueueSimulator(made)
    simulator.reset(vehicles)
    for _ in range(4):
        simulator.advance(np.array([0]))
    measures = simulator.measures()
    # 11 + 2 s instead of 8 + 2 s, and no wait.
    assert (measures.travel_veh_s, measures.wait_veh_s) == (13, 0)
    assert measures.time_loss_veh_s == 3


def test_who_shares_a_lane_with_red_waits_behind_it(tee):
    node = tee.intersections[0]
    movements = tuple(replace(m, lanes=(0,)) for m in node.movements)
    network = replace(tee, intersections=(replace(node, movements=movements),))
    made = replace(scenario("grid:1x1"), network=network, horizon_s=30)
    # Both from the East on one lane: the left turn at its head has red in phase 0.
    vehicles = vehicles_on(network, (0, ["E>T", "T>S"]), (1, ["E>T", "T>W"]))
    simulator = QueueSimulator(made)
    simulator.reset(vehicles)
    assert simulator.advance(np.array([0])).queue_veh[0, :2].tolist() == [1, 1]
    assert simulator.advance(np.array([1])).queue_veh[0, :2].tolist() == [0, 0]


@pytest.mark.parametrize(("gap_wait_s", "crossed_at_s"), [(20, 10), (2, 6), (0, 4)])
def test_who_gives_way_waits_for_the_others_queue_but_not_for_ever(tee, gap_wait_s, crossed_at_s):
    node = tee.intersections[0]
    gives_way = ((), (3,), (), (), (), ())  # left from the East yields to straight from the West
    phases = (frozenset({0, 1, 2, 3}), frozenset({2, 5}))
    network = replace(tee, intersections=(replace(node, gives_way=gives_way, phases=phases),))
    dynamics = QueueDynamics(gap_wait_s=gap_wait_s)
    made = replace(scenario("grid:1x1"), network=network, dynamics=dynamics, horizon_s=20)
    others = [(0, ["W>T", "T>E"])] * 6
    vehicles = vehicles_on(network, (0, ["E>T", "T>S"]), *others)
    simulator = QueueSimulator(made)
    simulator.reset(vehicles)
    simulator.advance(np.array([0]))
    simulator.advance(np.array([0]))
    # All reach the stop line at 4 s; the others leave from 4 to 9 s, one a second.
    assert simulator.state.waited_s[0] == crossed_at_s - 4


def test_the_own_program_runs_without_a_controller(tee):
    stages = (Stage(7.0, frozenset({0})), Stage(3.0, frozenset()), Stage(6.0, frozenset({0, 1})))
    node = replace(tee.intersections[0], program=Program(stages, offset_s=-2.0))
    network = replace(tee, intersections=(node,))
    made = replace(scenario("grid:1x1"), network=network, horizon_s=60)
    # Left from the East, green from 8 to 14 s of every 16 s; the plan is 2 s ahead.
    vehicles = vehicles_on(network, *((t, ["E>T", "T>S"]) for t in (0, 3, 12, 25)))
    simulator = QueueSimulator(made)
    simulator.reset(vehicles)
    for _ in range(6):
        observation = simulator.advance(np.array([PROGRAM]))
    assert observation.phase.tolist() == [-1]
    # At the stop line at 4, 7, 16 and 29 s; they go at 8, 9, 24 and 29 s and drive 2 s more.
    assert simulator.state.arrived_s.tolist() == [10, 11, 26, 31]


def test_without_a_program_there_is_none_to_follow(tee):
    simulator = QueueSimulator(replace(scenario("grid:1x1"), network=tee))
    simulator.reset(vehicles_on(tee, (0, ["E>T", "T>S"])))
    with pytest.raises(InputError, match=r"phase -1; expected .* no program of its own"):
        simulator.advance(np.array([PROGRAM]))
