"""The compiled queue simulator against the plain one, step by step."""

from collections import defaultdict
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from dmil.demand import PoissonDemand
from dmil.network import Junction, Program, Stage, check_network, grid
from dmil.network.permissions import Classes, Permissions
from dmil.scenarios import PLAN, QueueDynamics, Scenario, SignalTiming
from dmil.scenarios.model import SumoFiles
from dmil.seeding import stream
from dmil.simulation import QueueSimulator
from dmil.simulation.queue import kernel
from dmil.simulation.queue.layout import build_layout, build_trips
from dmil.simulation.queue.state import (
    ARRIVED,
    NOBODY,
    OUTSIDE,
    OUTSIDE_STEPS,
    OVERRULED,
    STOPS,
    VISITS,
    WAITING,
    WAITING_STEPS,
    initial_state,
)
from dmil.simulation.timing import rules_of
from tests.differential.plain_queues import PlainQueues

CASES = [f"{network}-{n}" for network in ("grid", "tee", "mixed", "unsignalled") for n in range(12)]
CASES += [f"classes-{n}" for n in range(8)]
CAR, BUS = Classes({"passenger"}), Classes({"bus"})


@pytest.fixture(scope="module")
def make_case(tee, mixed_network, varied, wander):
    """A function from the name of a case to its scenario, vehicles and stream of decisions."""

    def make(name):
        kind, number = name.split("-")
        rng = stream(int(number), "queue twin", kind)
        networks = {"tee": tee, "mixed": mixed_network}
        network = networks.get(kind) or grid(*map(int, rng.integers(1, 5, 2)))
        if rng.random() < 0.75:
            network = varied(network, rng)
        if kind == "unsignalled":
            network = without_some_signals(varied(grid(2, 3), rng), rng)
        if kind == "classes":
            network = with_permissions(network, rng)
        check_network(network)
        interval_s = int(rng.choice([1, 2, 5, 10]))
        timing = SignalTiming(
            decision_interval_s=interval_s,
            clearance_s=int(rng.integers(0, min(interval_s, 5))),
            min_green_s=int(rng.choice([0, 0, 4, 15, 25])),
            max_green_s=int(rng.choice([0, 25, 40])),
            startup_lost_s=int(rng.choice([0, 0, 1, 3])),
            clearance_kind="all-stop" if int(number) % 2 else "kept",
        )
        if rng.random() < 0.4:
            network = with_programs(network, rng)
            timing = timing.model_copy(update=PLAN)
        dynamics = QueueDynamics(
            saturation_flow_veh_per_s=float(rng.choice([1 / 3, 0.5, 0.7, 1, 1.5, 2])),
            storage=bool(rng.random() < 0.5),
            vehicle_space_m=float(rng.choice([7.5, 20])),
            gap_wait_s=int(rng.choice([0, 3, 20])),
            start_wave_veh_per_s=float(rng.choice([0, 1, 2])),
        )
        horizon_s = int(rng.integers(80, 160))
        scenario = Scenario(name, network, PoissonDemand(), timing, dynamics, horizon_s)
        longest = int(rng.integers(2, 9))
        vehicles = wander(network, horizon_s, rng.choice([0.3, 1, 4]), rng, longest)
        if kind == "classes":
            sumo = SumoFiles(Path("none"), (), kinds=({}, {}, {}), classes=(CAR, BUS, CAR | BUS))
            scenario = replace(scenario, sumo=sumo)
            vehicles = replace(vehicles, kind=rng.integers(0, 3, len(vehicles)).astype(np.int32))
        return scenario, vehicles, rng

    return make


def without_some_signals(network, rng):
    """Take the signals from some intersections; somebody gives way at each, some take turns."""
    taken = [node for node in network.intersections[1:] if rng.random() < 0.5]
    junctions = []
    for node in taken:
        count = len(node.movements)
        foes = [set() for _ in range(count)]
        for i in range(count):
            for k in rng.permutation(count)[: rng.integers(0, 4)].tolist():
                if k < i:
                    foes[i].add(k)
                    if rng.random() < 0.3:
                        foes[k].add(i)
        foes[1].add(0)
        junctions.append(Junction(node.id, node.movements, tuple(tuple(sorted(f)) for f in foes)))
    left = tuple(node for node in network.intersections if node not in taken)
    return replace(network, intersections=left, junctions=tuple(junctions))


def with_programs(network, rng):
    """Give every intersection a plan whose greens and clearances differ."""

    def stages(phases):
        for p in rng.permutation(len(phases)):
            least_s = int(rng.integers(2, 15))
            longest_s = int(rng.choice([0, least_s + 10]))
            yield Stage(20, phases[p], min_s=least_s, max_s=longest_s or None)
            for yellow in (phases[p], frozenset()):
                yield Stage(int(rng.integers(1, 5)), frozenset(), True, yellow=yellow)

    return replace(
        network,
        intersections=tuple(
            replace(item, program=Program(tuple(stages(item.phases))))
            for item in network.intersections
        ),
    )


def with_permissions(network, rng):
    """Draw who may use which lane for which movement, and close lanes."""
    links = tuple(
        replace(link, closed=frozenset(rng.permutation(link.lanes)[1:][: rng.integers(3)].tolist()))
        for link in network.links
    )
    lanes = {link.id: link.lanes for link in links}
    kinds = (CAR, BUS, CAR | BUS)
    ways = {
        (each.from_link, each.to_link): {
            lane: kinds[rng.integers(3)] for lane in range(lanes[each.from_link])
        }
        for node in network.intersections
        for each in node.movements
    }
    everyone = {link.id: (CAR | BUS,) * link.lanes for link in links}
    return replace(network, links=links, permissions=Permissions(everyone, ways))


def drawn_phases(network, shown, rng):
    """Draw phases at random; some intersections keep what they show."""
    drawn = rng.integers(0, [len(node.phases) for node in network.intersections])
    return np.where((shown >= 0) & (rng.random(shown.size) < 0.3), shown, drawn).astype(np.int32)


def table(counts, shape):
    filled = np.zeros(shape, np.int32)
    for place, count in counts.items():
        if place[0] < shape[0]:  # not at a junction without signals
            filled[place] = count
    return filled


def queued_vehicles(state, lane):
    """Walk along a linked list."""
    found, vehicle = [], state.front[lane]
    while vehicle != NOBODY:
        found.append(int(vehicle))
        vehicle = state.behind[vehicle]
    return found


def assert_same_state(state, twin):
    lengths = twin.queued()
    shape = (len(twin.lights), state.queue_veh.shape[1])
    np.testing.assert_array_equal(state.queue_veh[: shape[0]], table(lengths, shape))
    assert state.queue_veh.sum() == sum(lengths.values())
    for number, queue in enumerate(twin.lanes.values()):
        assert queued_vehicles(state, number) == [car.number for car in queue]
        assert state.lane_veh[number] == len(queue)
    assert state.occupancy_veh.tolist() == [len(cars) for cars in twin.on_link.values()]
    assert state.arrived_s.tolist() == [car.arrived for car in twin.cars]
    assert state.waited_s.tolist() == [car.waited for car in twin.cars]
    counters = state.counters
    assert counters[ARRIVED] == sum(car.arrived >= 0 for car in twin.cars)
    assert counters[WAITING] == sum(lengths.values())
    assert counters[OUTSIDE] == twin.waiting_outside
    assert counters[WAITING_STEPS] == twin.waiting_steps
    assert counters[VISITS] == twin.visits
    assert counters[OVERRULED] == twin.overruled
    assert counters[OUTSIDE_STEPS] == twin.outside_steps
    assert counters[STOPS] == twin.stops


@pytest.mark.parametrize("name", CASES)
def test_every_step_is_that_of_the_plain_twin(name, make_case):
    scenario, vehicles, rng = make_case(name)
    network, rules = scenario.network, scenario.timing
    layout = build_layout(scenario)
    trips = build_trips(scenario, layout, vehicles)
    state = initial_state(layout, trips, scenario.horizon_s)
    twin = PlainQueues(scenario, vehicles)
    intersections, _, width = layout.signals.served.shape
    lowest = np.full(intersections, -1, np.int32)
    counts = np.empty((2, intersections, width), np.int32)
    shown, waiting_veh = np.empty((2, intersections), np.int32), np.empty((intersections, width))
    given = rules_of(rules, network)
    # Without a decision nobody is overruled. For an array that can be changed it would be compiled.
    unlimited = given._replace(max_green_s=np.zeros_like(given.max_green_s))
    unlimited.max_green_s.flags.writeable = False
    for time_s in range(scenario.horizon_s):
        wanted, decides = state.phase.copy(), time_s % rules.decision_interval_s == 0
        if decides:
            wanted = drawn_phases(network, state.phase, rng)
            twin.decide(wanted.tolist())
        now = given if decides else unlimited
        assert kernel.advance_and_observe(
            layout, trips, state, wanted, lowest, 1, now, counts, shown, waiting_veh
        )
        twin.step()
        assert_same_state(state, twin)


@pytest.mark.parametrize("name", CASES)
def test_every_observation_and_measure_is_that_of_the_plain_twin(name, make_case):
    scenario, vehicles, rng = make_case(name)
    simulator, twin = QueueSimulator(scenario), PlainQueues(scenario, vehicles)
    seen = simulator.reset(vehicles)
    shape = seen.queue_veh.shape
    arrived_at, queued_at = [], []
    while seen.time_s < scenario.horizon_s:
        wanted = drawn_phases(scenario.network, seen.phase, rng)
        seen = simulator.advance(wanted)
        twin.decide(wanted.tolist())
        while twin.now < seen.time_s:
            twin.step()
            arrived_at.append(sum(car.arrived >= 0 for car in twin.cars))
            queued_at.append(sum(map(len, twin.lanes.values())) + twin.waiting_outside)
        assert_same_state(simulator.state, twin)
        np.testing.assert_array_equal(seen.queue_veh, table(twin.standing(), shape))
        np.testing.assert_array_equal(
            seen.approaching_veh,
            table(twin.approaching(scenario.timing.decision_interval_s), shape),
        )
        waited = simulator.state.waiting_steps[: shape[0]]
        np.testing.assert_array_equal(waited, table(twin.waited_at, shape))
        assert seen.phase.tolist() == [light.shown for light in twin.lights]
        ages = [max(0, twin.now - light.green_from) for light in twin.lights]
        assert seen.phase_elapsed_s.tolist() == ages
    measures = simulator.measures()
    assert measures.arrived_at.tolist() == arrived_at
    assert measures.queued_at.tolist() == queued_at
    assert measures.spawned_veh == len(twin.cars)
    arrived = [car for car in twin.cars if car.arrived >= 0]
    assert measures.arrived_veh == len(arrived)
    assert measures.arrived_wait_veh_s == sum(car.waited for car in arrived)
    assert measures.wait_veh_s == twin.waiting_steps == sum(queued_at)
    assert measures.travel_veh_s == sum(
        (car.arrived if car.arrived >= 0 else twin.now) - depart_s
        for car, depart_s in zip(twin.cars, vehicles.depart_s.tolist(), strict=True)
    )


def test_the_cases_meet_every_rule(make_case):
    met = defaultdict(int)
    for name in CASES:
        scenario, vehicles, rng = make_case(name)
        twin = PlainQueues(scenario, vehicles)
        shown = np.full(len(twin.lights), -1, np.int32)
        for time_s in range(scenario.horizon_s):
            if time_s % scenario.timing.decision_interval_s == 0:
                twin.decide(drawn_phases(scenario.network, shown, rng).tolist())
                shown = np.array([light.shown for light in twin.lights], np.int32)
            twin.step()
            met["outside"] += twin.waiting_outside
            twin.standing()
        met["overruled"] += twin.overruled
        met["yielded"] += twin.yielded
        met["impatient"] += twin.impatient
        met["stops"] += twin.stops
        met["started"] += twin.started
        met["gap too short"] += twin.short_gaps
        met["just behind another"] += twin.behind
        met["in turn"] += twin.turns
        met["blocked"] += twin.blocked
        arrived = [car for car in twin.cars if car.arrived >= 0]
        exits = scenario.network.exit_links
        met["out of the network"] += sum(car.route[-1] in exits for car in arrived)
        met["parked"] += sum(car.route[-1] not in exits for car in arrived)
        met["clearance"] += bool(scenario.timing.clearance_s)
        met["all-stop"] += bool(twin.times.all_stop.any())
        met["clearance of the plan"] += scenario.timing.clearance_s is None
        met["start-up"] += scenario.timing.startup_lost_s > 0
        met["several per step"] += twin.headway < 1
        met["a part per step"] += twin.headway > 1
        met["steps"] += scenario.horizon_s
    assert len(met) == 19
    assert min(met.values()) >= 10, dict(met)
    assert met["steps"] > 5000
