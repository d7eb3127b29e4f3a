from dataclasses import replace

import numpy as np
import pytest

from dmil.demand import FileDemand, Vehicles
from dmil.errors import DemandError, DmilError, InputError
from dmil.network import grid
from dmil.scenarios import QueueDynamics, SignalTiming, scenario
from dmil.seeding import stream
from dmil.simulation import QueueSimulator
from dmil.simulation.queue.layout import UNLIMITED_VEH, build_layout, build_trips

NOBODY = Vehicles(np.zeros(0, np.int32), np.zeros(1, np.int32), np.zeros(0, np.int32))


def vehicles_on(network, *journeys):
    """Make vehicles from (departure, link ids)."""
    seconds, routes = zip(*journeys, strict=True)
    return FileDemand.from_routes(network, seconds, routes).vehicles(network, 999, stream(0, "no"))


@pytest.fixture
def simulator():
    made = QueueSimulator(scenario("grid:2x2", horizon_s=25))
    made.reset(NOBODY)
    return made


# --- Bad input -------------------------------------------------------------------------------


@pytest.mark.parametrize("phase", [-1, 8, 2**40])
def test_a_phase_that_does_not_exist(simulator, phase):
    with pytest.raises(InputError, match=rf"intersection '1,0': .*chose phase {phase}; .*0 to 7"):
        simulator.advance(np.array([0, 7, phase, 9]))


def test_a_phase_that_only_others_have(mixed_network):
    made = replace(scenario("grid:2x3"), network=mixed_network)
    simulator = QueueSimulator(made)
    simulator.reset(NOBODY)
    counts = [len(node.phases) for node in mixed_network.intersections]
    short = int(np.argmin(counts))
    assert counts[short] < max(counts)
    phases = np.array(counts) - 1
    simulator.advance(phases)
    phases[short] += 1
    place = f"intersection '{mixed_network.intersections[short].id}'"
    with pytest.raises(InputError, match=f"{place}.*from 0 to {counts[short] - 1}"):
        simulator.advance(phases)


@pytest.mark.parametrize(
    "phases", [np.zeros(3, int), np.zeros((2, 2), int), np.array(0), np.zeros(4)]
)
def test_phases_of_another_shape_or_type(simulator, phases):
    with pytest.raises(
        InputError, match=r"grid:2x2: .*shape .* type .*each of the 4 intersections"
    ):
        simulator.advance(phases)


def test_a_refused_call_changes_nothing(simulator):
    simulator.advance(np.zeros(4, int))
    before = [array.tobytes() for array in simulator.state]
    with pytest.raises(InputError):
        simulator.advance(np.array([0, 1, 2, 8]))
    assert before == [array.tobytes() for array in simulator.state]


@pytest.mark.parametrize("kind", [np.int8, np.uint8, np.int64, list])
def test_any_whole_numbers_are_phases(simulator, kind):
    phases = [3, 1, 4, 1] if kind is list else np.array([3, 1, 4, 1], kind)
    assert simulator.advance(phases).phase.tolist() == [3, 1, 4, 1]


def test_a_run_ends_at_its_horizon(simulator):
    times = [simulator.advance(np.zeros(4, int)).time_s for _ in range(3)]
    assert times == [10, 20, 25]
    with pytest.raises(InputError, match=r"grid:2x2: the run is over: its horizon is 25 s.*reset"):
        simulator.advance(np.zeros(4, int))
    simulator.reset(NOBODY)
    assert simulator.advance(np.zeros(4, int)).time_s == 10


@pytest.mark.parametrize("call", [lambda s: s.advance(np.zeros(4, int)), lambda s: s.measures()])
def test_a_call_before_the_first_reset(call):
    with pytest.raises(InputError, match=r"grid:2x2: no run has begun.*reset"):
        call(QueueSimulator(scenario("grid:2x2")))


def test_a_route_over_links_that_no_movement_joins(simulator):
    network = simulator.network
    links = ["E0>0,1", "0,1>0,0", "0,0>W0", "E1>1,1", "0,0>N0"]
    route = np.array([network.link_index[link] for link in links], np.int32)
    vehicles = Vehicles(np.array([0, 4], np.int32), np.array([0, 3, 5], np.int32), route)
    with pytest.raises(
        DemandError, match=r"vehicle 1: .*'E1>1,1' to '0,0>N0'.*no movement"
    ) as caught:
        simulator.reset(vehicles)
    assert isinstance(caught.value, DmilError)
    assert "belong together" in str(caught.value)


# --- What is seen ----------------------------------------------------------------------------


def test_nothing_is_shown_before_the_first_decision(simulator):
    seen = simulator.reset(NOBODY)
    assert seen.time_s == 0
    assert seen.phase.tolist() == [-1] * 4
    assert seen.phase_elapsed_s.tolist() == [0] * 4
    assert seen.queue_veh.shape == seen.approaching_veh.shape == (4, 12)
    assert seen.queue_veh.dtype == seen.approaching_veh.dtype == np.int32


def test_an_observation_does_not_change_afterwards():
    made = scenario("grid:1x2", horizon_s=30)
    simulator = QueueSimulator(made)
    vehicles = made.demand.vehicles(made.network, 30, stream(1, "demand"))
    first = simulator.reset(vehicles)
    seen = simulator.advance(np.array([0, 0]))
    arrays = [getattr(seen, name).copy() for name in ("queue_veh", "approaching_veh", "phase")]
    simulator.advance(np.array([1, 1]))
    assert first.queue_veh.sum() == 0
    assert (seen.queue_veh == arrays[0]).all()
    assert (seen.approaching_veh == arrays[1]).all()
    assert (seen.phase == arrays[2]).all()


def test_approaching_vehicles_are_those_on_their_way_for_the_next_interval():
    # Three crossings of 50 m roads (5 s), decisions every 4 s. From the West straight on is 7.
    made = scenario("grid:1x2", horizon_s=30, timing=SignalTiming(decision_interval_s=4))
    simulator = QueueSimulator(made)
    route = ["W0>0,0", "0,0>0,1", "0,1>E0"]
    simulator.reset(vehicles_on(made.network, *((second, route) for second in (0, 1, 2, 3))))
    seen = simulator.advance(np.array([0, 2]))
    # They enter the road at 0, 1, 2, 3 s and reach its end at 5, 6, 7, 8 s: the last not before 8.
    assert seen.approaching_veh[1, 7] == seen.approaching_veh.sum() == 3
    seen = simulator.advance(np.array([0, 2]))
    assert (seen.queue_veh[1, 7], seen.approaching_veh[1, 7]) == (3, 1)
    seen = simulator.advance(np.array([0, 2]))
    assert (seen.queue_veh[1, 7], seen.approaching_veh.sum()) == (4, 0)


def test_vehicles_on_their_last_link_approach_nothing(tee):
    made = replace(scenario("grid:1x1", horizon_s=30), network=tee)
    simulator = QueueSimulator(made)
    simulator.reset(vehicles_on(tee, (5, ["S>T", "T>E"])))
    seen = simulator.advance(np.array([0]))  # at 9 s it turns right into a road of 2 s
    assert simulator.state.occupancy_veh.sum() == 1
    assert seen.queue_veh.sum() == seen.approaching_veh.sum() == 0


def test_phase_elapsed_counts_from_green():
    timing = SignalTiming(decision_interval_s=10, clearance_s=4)
    simulator = QueueSimulator(scenario("grid:1x1", timing=timing))
    simulator.reset(NOBODY)
    elapsed = [simulator.advance(np.array([phase])).phase_elapsed_s[0] for phase in (0, 0, 1, 1, 2)]
    assert elapsed == [10, 20, 6, 16, 6]


def test_padding_stays_empty(mixed_network, wander):
    simulator = QueueSimulator(replace(scenario("grid:2x3", horizon_s=60), network=mixed_network))
    simulator.reset(wander(mixed_network, 60, 3.0, stream(0, "padding")))
    for _ in range(6):
        seen = simulator.advance(np.zeros(len(mixed_network.intersections), int))
        assert seen.queue_veh.sum() > 0
        for i, node in enumerate(mixed_network.intersections):
            assert not seen.queue_veh[i, len(node.movements) :].any()
            assert not seen.approaching_veh[i, len(node.movements) :].any()


def test_a_run_without_vehicles(simulator):
    for _ in range(3):
        assert simulator.advance(np.zeros(4, int)).queue_veh.sum() == 0
    measures = simulator.measures()
    assert (measures.spawned_veh, measures.arrived_veh, measures.wait_veh_s) == (0, 0, 0)


def test_a_vehicle_that_parks_or_only_passes_by(tee):
    simulator = QueueSimulator(replace(scenario("grid:1x1", horizon_s=30), network=tee))
    simulator.reset(vehicles_on(tee, (0, ["E>T"]), (1, ["S>T", "T>W"])))
    simulator.advance(np.array([2]))
    # The first ends where its only link ends, 4 s on; the other drives on over 2 s.
    assert simulator.state.arrived_s.tolist() == [4, 1 + 4 + 2]


# --- Roads -----------------------------------------------------------------------------------


def test_travel_times_and_room_come_from_the_roads(tee):
    dynamics = QueueDynamics(storage=True)
    layout = build_layout(replace(scenario("grid:1x1"), network=tee, dynamics=dynamics))
    # 40 m on two lanes hold 10.67 vehicles; roads out of the network never fill.
    assert layout.capacity_veh.tolist() == [10] * 3 + [UNLIMITED_VEH] * 3


def test_entries_without_length_hold_any_number_and_inner_roads_take_a_second():
    network = grid(1, 2)
    short = tuple(replace(link, length_m=min(link.length_m, 1.0)) for link in network.links)
    dynamics = QueueDynamics(storage=True)
    made = replace(scenario("grid:1x2", dynamics=dynamics), network=replace(network, links=short))
    layout = build_layout(made)
    inner = [network.link_index["0,0>0,1"], network.link_index["0,1>0,0"]]
    vehicles = vehicles_on(network, (0, ["W0>0,0", "0,0>0,1", "0,1>E0"]))
    assert build_trips(made, layout, vehicles).leg_s.tolist() == [0, 1, 0]
    assert layout.capacity_veh[inner].tolist() == [1, 1]
    others = np.delete(np.arange(len(short)), inner)
    assert set(layout.capacity_veh[others]) == {UNLIMITED_VEH}


def test_without_storage_no_road_fills():
    assert set(build_layout(scenario("grid:2x2")).capacity_veh) == {UNLIMITED_VEH}


def test_lanes_are_numbered_in_the_order_of_the_movements_they_serve(tee):
    node = tee.intersections[0]
    lanes = ((1,), (0, 1), (0,), (1,), (1,), (0,))
    movements = tuple(replace(m, lanes=k) for m, k in zip(node.movements, lanes, strict=True))
    network = replace(tee, intersections=(replace(node, movements=movements),))
    dynamics = QueueDynamics(saturation_flow_veh_per_s=0.5)
    layout = build_layout(replace(scenario("grid:1x1"), network=network, dynamics=dynamics))
    assert layout.lane_offset.tolist() == [0, 1, 3, 4, 5, 6, 7]
    assert layout.lanes.tolist() == [0, 1, 0, 2, 3, 4, 5]
    assert layout.lane_count == 6
    assert layout.headway_s.tolist() == [2.0] * 6


def test_journeys_name_the_queues_on_the_way():
    made = scenario("grid:1x2")
    network = made.network
    vehicles = vehicles_on(network, (3, ["W0>0,0", "0,0>0,1", "0,1>N1"]), (8, ["N0>0,0", "0,0>W0"]))
    trips = build_trips(made, build_layout(made), vehicles)
    assert trips.depart_s.tolist() == [3, 8]
    # From the West straight on is 7, from the West left 8, from the North right 3.
    assert trips.movements.tolist() == [7, 12 + 8, 3]
    assert trips.movement_offset.tolist() == [0, 2, 3]
    legs = [network.links[k].id for k in trips.leg_link]
    assert legs == ["W0>0,0", "0,0>0,1", "0,1>N1", "N0>0,0", "0,0>W0"]
    assert trips.leg_s.tolist() == [0, 5, 0, 0, 0]
