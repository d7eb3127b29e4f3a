"""What holds for every network, demand, timing and sequence of phases."""

from dataclasses import astuple, dataclass
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dmil.compilation import TypedOnce
from dmil.demand import PoissonDemand, Vehicles
from dmil.network import grid
from dmil.scenarios import QueueDynamics, Scenario, SignalTiming
from dmil.seeding import stream
from dmil.simulation import QueueSimulator
from dmil.simulation.queue import kernel
from dmil.simulation.queue.layout import Layout, build_layout, build_trips
from dmil.simulation.queue.state import (
    ARRIVED,
    NEXT_VEHICLE,
    NOBODY,
    OUTSIDE,
    WAITING,
    WAITING_STEPS,
    State,
    Trips,
    initial_state,
)
from dmil.simulation.timing import NEVER_S, rules_of

STEPS = 60


@st.composite
def timings(draw):
    interval_s = draw(st.sampled_from([1, 3, 10]))
    return SignalTiming(
        decision_interval_s=interval_s,
        clearance_s=draw(st.integers(0, min(interval_s - 1, 4))),
        min_green_s=draw(st.sampled_from([0, 5, 20])),
        max_green_s=draw(st.sampled_from([0, 25])),
        startup_lost_s=draw(st.integers(0, 3)),
    )


DYNAMICS = st.builds(
    QueueDynamics,
    saturation_flow_veh_per_s=st.sampled_from([0.4, 1.0, 2.5]),
    storage=st.booleans(),
    vehicle_space_m=st.sampled_from([5.0, 30.0]),
    gap_wait_s=st.sampled_from([0, 20]),
)
CHANCE = {
    "kind": st.sampled_from(["tee", "mixed", "grid:1x1", "grid:2x2", "grid:3x1"]),
    "as_built": st.booleans(),
    "seed": st.integers(0, 10_000),
    "veh_per_s": st.sampled_from([0.1, 1.0, 3.0]),
    "timing": timings(),
    "dynamics": DYNAMICS,
}


@dataclass
class Drive:
    """A run one step at a time."""

    scenario: Scenario
    vehicles: Vehicles
    layout: Layout
    trips: Trips
    state: State
    rng: np.random.Generator
    advance: TypedOnce

    @property
    def network(self):
        return self.scenario.network

    def step(self, time_s):
        """Run one second; at a decision ask for random phases. Return what was asked for."""
        timing = self.scenario.timing
        wanted, rules = self.state.phase.copy(), rules_of(timing, self.network)
        if time_s % timing.decision_interval_s:  # no decision: nobody is overruled
            rules = rules._replace(max_green_s=np.zeros_like(rules.max_green_s))
            rules.max_green_s.flags.writeable = False  # as the kernel is compiled for the simulator
        else:
            wanted[:] = self.rng.integers(0, self.layout.signals.phase_count)
        size = wanted.size, self.state.queue_veh.shape[1]
        seen = np.empty((2, *size), np.int32), np.empty((2, wanted.size), np.int32), np.empty(size)
        arrays, lowest = (self.layout, self.trips, self.state), np.full(wanted.size, -1, np.int32)
        assert self.advance(*arrays, wanted, lowest, 1, rules, *seen)
        return wanted


@pytest.fixture(scope="session")
def begin(tee, mixed_network, varied, wander):
    """A function that starts a run from what hypothesis drew."""

    def start(kind, as_built, seed, veh_per_s, timing, dynamics):
        rng = stream(seed, "properties")
        networks = {"tee": tee, "mixed": mixed_network}
        network = networks.get(kind) or grid(int(kind[5]), int(kind[7]))
        network = network if as_built else varied(network, rng)
        scenario = Scenario(kind, network, PoissonDemand(), timing, dynamics, STEPS)
        vehicles = wander(network, STEPS, veh_per_s, rng, int(rng.integers(1, 8)))
        layout = build_layout(scenario)
        trips = build_trips(scenario, layout, vehicles)
        state = initial_state(layout, trips, STEPS)
        return Drive(
            scenario, vehicles, layout, trips, state, rng, TypedOnce(kernel.advance_and_observe)
        )

    return start


def members(front, behind):
    """Return every linked list as a list of vehicles; one that runs in a circle fails."""
    lists = []
    for vehicle in front.tolist():
        found = []
        while vehicle != NOBODY:
            assert len(found) < behind.size, "the list has no end"
            found.append(vehicle)
            vehicle = int(behind[vehicle])
        lists.append(found)
    return lists


def everyone(state):
    """Return queued, moving and outside vehicles, list by list."""
    return [
        members(front, state.behind)
        for front in (state.front, state.due_front, state.outside_front)
    ]


def crossings(drive, visit_before):
    """Return (intersection, movement) of every vehicle that crossed since; nobody crosses two."""
    crossed = drive.state.visit - visit_before
    assert set(crossed.tolist()) <= {0, 1}
    movements = drive.trips.movements[visit_before[crossed == 1]]
    return [divmod(movement, drive.state.queue_veh.shape[1]) for movement in movements.tolist()]


def count(lists):
    return sum(map(len, lists))


def bytes_of(state):
    return b"".join(array.tobytes() for array in state)


@given(**CHANCE)
def test_every_spawned_vehicle_is_in_exactly_one_place(begin, **chance):
    drive = begin(**chance)
    state = drive.state
    for time_s in range(STEPS):
        drive.step(time_s)
        queued, moving, outside = everyone(state)
        arrived = np.flatnonzero(state.arrived_s >= 0).tolist()
        spawned = int((drive.vehicles.depart_s <= time_s).sum())
        places = [v for lists in (queued, moving, outside) for found in lists for v in found]
        assert sorted(places + arrived) == list(range(spawned))
        assert state.counters[NEXT_VEHICLE] == spawned
        assert state.counters[ARRIVED] == len(arrived) == state.arrived_at[time_s]
        assert state.counters[WAITING] == count(queued) == state.queue_veh.sum()
        assert state.counters[OUTSIDE] == count(outside)
        assert state.queued_at[time_s] == count(queued) + count(outside)


@given(**CHANCE)
def test_lists_and_counts_agree_and_no_link_is_overfull(begin, **chance):
    drive = begin(**chance)
    state, layout, trips = drive.state, drive.layout, drive.trips
    for time_s in range(STEPS):
        drive.step(time_s)
        queued, moving, outside = everyone(state)
        assert [len(found) for found in queued] == state.lane_veh.tolist()
        movements = [trips.movements[state.visit[v]] for found in queued for v in found]
        counts = np.bincount(movements, minlength=state.queue_veh.size)
        np.testing.assert_array_equal(counts, state.queue_veh.ravel())
        for front, back, lists in (
            (state.front, state.back, queued),
            (state.due_front, state.due_back, moving),
            (state.outside_front, state.outside_back, outside),
        ):
            assert all(back[k] == found[-1] for k, found in enumerate(lists) if found)
            assert all((front[k] == NOBODY) == (not found) for k, found in enumerate(lists))
        on_link = np.zeros(layout.capacity_veh.size, int)
        for vehicle in (v for lists in (queued, moving) for found in lists for v in found):
            on_link[trips.leg_link[state.visit[vehicle] + vehicle]] += 1
        np.testing.assert_array_equal(on_link, state.occupancy_veh)
        assert (state.occupancy_veh <= layout.capacity_veh).all()


@given(**CHANCE)
def test_nobody_crosses_on_red(begin, **chance):
    drive = begin(**chance)
    state, network = drive.state, drive.network
    for time_s in range(STEPS):
        shown, visit = state.phase.copy(), state.visit.copy()
        drive.step(time_s)
        for i, j in crossings(drive, visit):
            assert state.go_from_s[i, j] <= time_s
            node = network.intersections[i]
            assert j in node.phases[state.phase[i]] | node.unsignalled
            # During a clearance only what had green before goes on.
            if time_s < state.green_from_s[i] and shown[i] != state.phase[i]:
                assert j in node.phases[shown[i]] | node.unsignalled


@given(**CHANCE)
def test_nobody_overtakes_in_a_queue(begin, **chance):
    drive = begin(**chance)
    state = drive.state
    for time_s in range(STEPS):
        before = members(state.front, state.behind)
        drive.step(time_s)
        for old, new in zip(before, members(state.front, state.behind), strict=True):
            left = [vehicle for vehicle in old if vehicle in new]
            assert left == old[len(old) - len(left) :], "one went before those ahead of it"
            assert left == new[: len(left)], "one came in before those who waited"


@given(**CHANCE)
def test_go_from_tells_red_from_green(begin, **chance):
    drive = begin(**chance)
    for time_s in range(STEPS):
        drive.step(time_s)
        for i, node in enumerate(drive.network.intersections):
            green = node.phases[drive.state.phase[i]] | node.unsignalled
            go_from_s = drive.state.go_from_s[i]
            assert {j for j in range(go_from_s.size) if go_from_s[j] != NEVER_S} == green


@given(**CHANCE)
def test_two_movements_that_no_phase_serves_together_never_go_in_one_step(begin, **chance):
    drive = begin(**chance)
    state = drive.state
    for time_s in range(STEPS):
        visit = state.visit.copy()
        drive.step(time_s)
        went = [set() for _ in drive.network.intersections]
        for i, j in crossings(drive, visit):
            went[i].add(j)
        for node, movements in zip(drive.network.intersections, went, strict=True):
            signalled = movements - node.unsignalled
            assert any(signalled <= phase for phase in node.phases)


@given(**CHANCE)
def test_waits_are_not_negative_and_add_up(begin, **chance):
    drive = begin(**chance)
    state = drive.state
    last = np.zeros_like(state.waited_s)
    for time_s in range(STEPS):
        drive.step(time_s)
        assert (state.waited_s >= last).all()
        last = state.waited_s.copy()
        queued, _, outside = everyone(state)
        waiting = [v for lists in (queued, outside) for found in lists for v in found]
        ongoing = time_s + 1 - state.joined_s[waiting]
        assert (ongoing >= 1).all()
        assert state.waited_s.sum() + ongoing.sum() == state.counters[WAITING_STEPS]
        assert state.counters[WAITING_STEPS] == state.queued_at[: time_s + 1].sum()
    done = state.arrived_s >= 0
    depart_s = drive.vehicles.depart_s
    assert (depart_s[done] + state.waited_s[done] <= state.arrived_s[done]).all()


@given(**CHANCE)
def test_queues_are_in_the_order_in_which_they_were_joined(begin, **chance):
    drive = begin(**chance)
    for time_s in range(STEPS):
        drive.step(time_s)
        queued, _, outside = everyone(drive.state)
        for found in queued + outside:
            joined_s = drive.state.joined_s[found].tolist()
            assert all(first <= second for first, second in pairwise(joined_s))


@given(**CHANCE)
def test_a_vehicle_takes_its_driving_time_and_its_waits(begin, **chance):
    drive = begin(**chance)
    for time_s in range(STEPS):
        drive.step(time_s)
    state, vehicles = drive.state, drive.vehicles
    for vehicle in np.flatnonzero(state.arrived_s >= 0).tolist():
        first, last = drive.trips.movement_offset[vehicle : vehicle + 2] + vehicle
        driving_s = drive.trips.leg_s[first : last + 1].sum()
        taken_s = state.arrived_s[vehicle] - vehicles.depart_s[vehicle]
        assert taken_s == driving_s + state.waited_s[vehicle]


@given(**CHANCE)
@settings(max_examples=30)
def test_the_same_seed_gives_the_same_bytes(begin, **chance):
    first, second = begin(**chance), begin(**chance)
    for time_s in range(STEPS):
        first.step(time_s)
        second.step(time_s)
    assert bytes_of(first.state) == bytes_of(second.state)


@given(**CHANCE)
@settings(max_examples=30)
def test_a_whole_interval_is_its_single_seconds_and_a_reset_forgets(begin, **chance):
    drive = begin(**chance)
    interval_s = drive.scenario.timing.decision_interval_s
    wanted = [drive.step(time_s) for time_s in range(STEPS)][::interval_s]
    simulator = QueueSimulator(drive.scenario)
    for _ in range(2):
        simulator.reset(drive.vehicles)
        for phases in wanted:
            simulator.advance(phases)
        # What is counted since the last call is the only thing that the calls decide.
        arrays = {**simulator.state._asdict(), "waiting_steps": drive.state.waiting_steps}
        assert bytes_of(State(**arrays)) == bytes_of(drive.state)


@given(**CHANCE)
@settings(max_examples=30)
def test_vehicles_beyond_the_horizon_change_nothing(begin, **chance):
    drive = begin(**chance)
    depart_s, offset, links, *_ = astuple(drive.vehicles)
    late = Vehicles(
        np.append(depart_s, np.int32(STEPS)),
        np.append(offset, np.int32(offset[-1] + 1)),
        np.append(links, np.int32(drive.network.entry_links[0])),
    )
    results = []
    for vehicles in (drive.vehicles, late):
        simulator = QueueSimulator(drive.scenario)
        observation = simulator.reset(vehicles)
        rng = stream(chance["seed"], "late")
        while observation.time_s < STEPS:
            phases = rng.integers(0, [len(node.phases) for node in drive.network.intersections])
            observation = simulator.advance(phases)
        results.append(astuple(simulator.measures()))
    np.testing.assert_equal(*results)  # what the simulator does not know is NaN in both
