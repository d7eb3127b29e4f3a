"""The compiled queue simulator against a plain one: dicts, deques, one object per vehicle.

The twin was written from the specification (§2) and the docstrings. It counts headways in exact
fractions, where the kernel has floating-point numbers.
"""

from collections import defaultdict, deque
from dataclasses import dataclass, field
from fractions import Fraction

import numpy as np
import pytest

from dmil.demand import PoissonDemand
from dmil.network import check_network, grid
from dmil.scenarios import QueueDynamics, Scenario, SignalTiming
from dmil.seeding import stream
from dmil.simulation import QueueSimulator
from dmil.simulation.queue import kernel
from dmil.simulation.queue.layout import build_layout, build_trips, rules_of
from dmil.simulation.queue.state import (
    ARRIVED,
    NOBODY,
    OUTSIDE,
    REFUSED,
    VISITS,
    WAITING,
    WAITING_STEPS,
    initial_state,
)

CASES = [f"{network}-{n}" for network in ("grid", "tee", "mixed") for n in range(24)]


@dataclass(eq=False)
class Car:
    number: int
    route: list[int]
    place: int = 0
    joined: int = 0
    waited: int = 0
    arrived: int = -1


@dataclass
class Light:
    shown: int | None = None
    green_from: int = 0
    go_from: dict[int, int] = field(default_factory=dict)


class PlainQueues:
    """The queue simulator, as one would explain it."""

    def __init__(self, scenario, vehicles):
        self.network, self.rules = scenario.network, scenario.timing
        self.now = self.refused = self.visits = self.waiting_steps = self.blocked = 0
        self.lights = [Light() for _ in self.network.intersections]
        self.queues = {
            (i, j): deque()
            for i, node in enumerate(self.network.intersections)
            for j in range(len(node.movements))
        }
        self.headway, self.ready = {}, defaultdict(Fraction)
        for i, j in self.queues:
            lanes = self.network.intersections[i].movements[j].lanes
            flow = Fraction(lanes).limit_denominator(50)
            flow *= Fraction(scenario.dynamics.saturation_flow_veh_per_s).limit_denominator(50)
            self.headway[i, j] = 1 / flow
        self.waited_at = defaultdict(int)
        self.time_on, self.most_on = {}, {}
        for number, link in enumerate(self.network.links):
            self.time_on[number] = self._travel_time(link)
            self.most_on[number] = self._capacity(link, scenario.dynamics)
        self.on_link = {number: set() for number in self.time_on}
        self.moving = {number: deque() for number in self.time_on}
        self.outside = {number: deque() for number in self.time_on}
        self.cars = [Car(v, vehicles.route(v).tolist()) for v in range(len(vehicles))]
        self.departing = defaultdict(list)
        for car, second in zip(self.cars, vehicles.depart_s.tolist(), strict=True):
            self.departing[second].append(car)

    def _travel_time(self, link):
        seconds = round(link.length_m / link.speed_m_per_s)
        if link.start in self.network.fringe or link.end in self.network.fringe:
            return seconds
        return max(1, seconds)

    def _capacity(self, link, dynamics):
        if not dynamics.storage or link.length_m == 0 or link.end in self.network.fringe:
            return float("inf")
        return max(1, int(link.length_m * link.lanes / dynamics.vehicle_space_m))

    def decide(self, wanted):
        """Change the lights as far as the rules allow."""
        self.waited_at.clear()
        for node, light, phase in zip(self.network.intersections, self.lights, wanted, strict=True):
            if phase == light.shown:
                continue
            first = light.shown is None
            if not first and self.now - light.green_from < self.rules.min_green_s:
                self.refused += 1
                continue
            light.shown = phase
            light.green_from = self.now + (0 if first else self.rules.clearance_s)
            had_green, light.go_from = light.go_from, {}
            for j in node.phases[phase]:
                light.go_from[j] = had_green.get(j, light.green_from + self.rules.startup_lost_s)
            for j in node.unsignalled:
                light.go_from[j] = 0

    def step(self):
        """Departures, ends of links, discharge, measurements."""
        for car in self.departing[self.now]:
            car.joined = self.now
            self.outside[car.route[0]].append(car)
        for link, queue in self.outside.items():
            while queue and self.room_on(link):
                car = queue.popleft()
                car.waited += self.now - car.joined
                self.enter(car)
        for moving in self.moving.values():
            while moving and moving[0][0] == self.now:
                self.reach_end(moving.popleft()[1])
        for place, queue in self.queues.items():
            if self.now >= self.lights[place[0]].go_from.get(place[1], float("inf")):
                self.discharge(place, queue)
            self.waited_at[place] += len(queue)
        self.waiting_steps += sum(map(len, self.queues.values())) + self.waiting_outside
        self.now += 1

    def discharge(self, place, queue):
        while queue and self.ready[place] < self.now + 1:
            car = queue[0]
            if not self.room_on(car.route[car.place + 1]):
                self.blocked += 1
                return
            queue.popleft()
            self.ready[place] = max(self.ready[place], self.now) + self.headway[place]
            car.waited += self.now - car.joined
            self.on_link[car.route[car.place]].remove(car)
            car.place += 1
            self.enter(car)

    def room_on(self, link):
        return len(self.on_link[link]) < self.most_on[link]

    def enter(self, car):
        link = car.route[car.place]
        self.on_link[link].add(car)
        if self.time_on[link] == 0:
            self.reach_end(car)
        else:
            self.moving[link].append((self.now + self.time_on[link], car))

    def reach_end(self, car):
        if car.place == len(car.route) - 1:
            self.on_link[car.route[-1]].remove(car)
            car.arrived = self.now
            return
        self.queues[
            self.network.movement_index[car.route[car.place], car.route[car.place + 1]]
        ].append(car)
        car.joined = self.now
        self.visits += 1

    @property
    def waiting_outside(self):
        return sum(map(len, self.outside.values()))

    def approaching(self, within):
        counts = defaultdict(int)
        for moving in self.moving.values():
            for due, car in moving:
                if due < self.now + within and car.place < len(car.route) - 1:
                    counts[
                        self.network.movement_index[car.route[car.place], car.route[car.place + 1]]
                    ] += 1
        return counts


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
        check_network(network)
        interval_s = int(rng.choice([1, 2, 5, 10]))
        timing = SignalTiming(
            decision_interval_s=interval_s,
            clearance_s=int(rng.integers(0, min(interval_s, 5))),
            min_green_s=int(rng.choice([0, 0, 4, 15, 25])),
            startup_lost_s=int(rng.choice([0, 0, 1, 3])),
        )
        dynamics = QueueDynamics(
            saturation_flow_veh_per_s=float(rng.choice([1 / 3, 0.5, 0.7, 1, 1.5, 2])),
            storage=bool(rng.random() < 0.5),
            vehicle_space_m=float(rng.choice([7.5, 20])),
        )
        horizon_s = int(rng.integers(80, 160))
        scenario = Scenario(name, network, PoissonDemand(), timing, dynamics, horizon_s)
        longest = int(rng.integers(2, 9))
        vehicles = wander(network, horizon_s, rng.choice([0.3, 1, 4]), rng, longest)
        return scenario, vehicles, rng

    return make


def drawn_phases(network, shown, rng):
    """Draw phases at random; some intersections keep what they show."""
    drawn = rng.integers(0, [len(node.phases) for node in network.intersections])
    return np.where((shown >= 0) & (rng.random(shown.size) < 0.3), shown, drawn).astype(np.int32)


def table(counts, shape):
    filled = np.zeros(shape, np.int32)
    for place, count in counts.items():
        filled[place] = count
    return filled


def queued_vehicles(state, slot):
    """Walk along a linked list."""
    found, vehicle = [], state.front[slot]
    while vehicle != NOBODY:
        found.append(int(vehicle))
        vehicle = state.behind[vehicle]
    return found


def assert_same_state(state, twin):
    shape = state.queue_veh.shape
    lengths = {place: len(queue) for place, queue in twin.queues.items()}
    np.testing.assert_array_equal(state.queue_veh, table(lengths, shape))
    for (i, j), queue in twin.queues.items():
        assert queued_vehicles(state, i * shape[1] + j) == [car.number for car in queue]
    assert state.occupancy_veh.tolist() == [len(cars) for cars in twin.on_link.values()]
    assert state.arrived_s.tolist() == [car.arrived for car in twin.cars]
    assert state.waited_s.tolist() == [car.waited for car in twin.cars]
    counters = state.counters
    assert counters[ARRIVED] == sum(car.arrived >= 0 for car in twin.cars)
    assert counters[WAITING] == sum(lengths.values())
    assert counters[OUTSIDE] == twin.waiting_outside
    assert counters[WAITING_STEPS] == twin.waiting_steps
    assert counters[VISITS] == twin.visits
    assert counters[REFUSED] == twin.refused


@pytest.mark.parametrize("name", CASES)
def test_every_step_is_that_of_the_plain_twin(name, make_case):
    scenario, vehicles, rng = make_case(name)
    network, rules = scenario.network, scenario.timing
    layout = build_layout(scenario)
    trips = build_trips(network, layout, vehicles)
    state = initial_state(layout, trips, scenario.horizon_s)
    twin = PlainQueues(scenario, vehicles)
    for time_s in range(scenario.horizon_s):
        wanted = state.phase.copy()
        if time_s % rules.decision_interval_s == 0:
            wanted = drawn_phases(network, state.phase, rng)
            twin.decide(wanted.tolist())
        kernel.advance(
            layout,
            trips,
            state,
            wanted,
            1,
            rules_of(rules),
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
            queued_at.append(sum(map(len, twin.queues.values())) + twin.waiting_outside)
        assert_same_state(simulator.state, twin)
        np.testing.assert_array_equal(
            seen.approaching_veh,
            table(twin.approaching(scenario.timing.decision_interval_s), shape),
        )
        np.testing.assert_array_equal(simulator.state.waiting_steps, table(twin.waited_at, shape))
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
        met["refused"] += twin.refused
        met["blocked"] += twin.blocked
        arrived = [car for car in twin.cars if car.arrived >= 0]
        exits = scenario.network.exit_links
        met["out of the network"] += sum(car.route[-1] in exits for car in arrived)
        met["parked"] += sum(car.route[-1] not in exits for car in arrived)
        met["clearance"] += scenario.timing.clearance_s > 0
        met["start-up"] += scenario.timing.startup_lost_s > 0
        met["several per step"] += min(twin.headway.values()) < Fraction(1, 2)
        met["a part per step"] += max(twin.headway.values()) > 2
        met["steps"] += scenario.horizon_s
    assert len(met) == 10
    assert min(met.values()) >= 10, dict(met)
    assert met["steps"] > 5000
