"""The planner: it foresees what happens, nothing is better, and it says what it cannot do."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from dmil.controllers import RunContext, make_controller
from dmil.controllers.planner.beam import search
from dmil.controllers.planner.foresight import ForesightController, ForesightSettings, crossing_of
from dmil.demand import PoissonDemand, Vehicles
from dmil.errors import InputError
from dmil.network import grid
from dmil.rewards import diffusion
from dmil.scenarios import QueueDynamics, Scenario, SignalTiming, scenario
from dmil.seeding import stream
from dmil.simulation import QueueSimulator
from dmil.training import vehicles_of_seed
from dmil.training.phases import evaluate

TIMINGS = {
    "paper": SignalTiming(),
    "clearance": SignalTiming(decision_interval_s=5, clearance_s=3, startup_lost_s=1),
    "greens": SignalTiming(clearance_s=4, min_green_s=12, max_green_s=25, startup_lost_s=2),
}
DYNAMICS = {
    "paper": QueueDynamics(),
    "slow": QueueDynamics(saturation_flow_veh_per_s=0.4),
    "quick": QueueDynamics(saturation_flow_veh_per_s=1.5),
}


def wide(network):
    """Give every signalled movement of a network two lanes of its own."""
    nodes = tuple(
        replace(
            node,
            movements=tuple(
                replace(movement, lanes=(10 * j, 10 * j + 1) if j % 3 else (10 * j,))
                for j, movement in enumerate(node.movements)
            ),
        )
        for node in network.intersections
    )
    return replace(network, intersections=nodes)


def made(kind, *, timing="paper", dynamics="paper", horizon_s=600, load=3.0, tee=None):
    arguments = {"timing": TIMINGS[timing], "dynamics": DYNAMICS[dynamics]}
    if kind == "tee":
        demand = PoissonDemand({"E": 15.0, "W": 20.0, "S": 10.0})
        return Scenario("tee", tee, demand, *arguments.values(), horizon_s)
    found = scenario("grid:1x1", horizon_s=horizon_s, load=load, **arguments)
    return replace(found, network=wide(found.network)) if kind == "wide" else found


def situation_of(found, vehicles):
    return RunContext(found.network, found.timing, stream(0, "none"), vehicles, found.dynamics)


def waited(found, vehicles, controller):
    return evaluate(QueueSimulator(found), controller, vehicles, diffusion, 0).measures.wait_veh_s


@pytest.mark.parametrize("dynamics", DYNAMICS)
@pytest.mark.parametrize("timing", TIMINGS)
@pytest.mark.parametrize("kind", ["grid", "wide", "tee"])
def test_what_is_planned_is_what_is_measured(kind, timing, dynamics, tee):
    found = made(kind, timing=timing, dynamics=dynamics, tee=tee)
    vehicles = vehicles_of_seed(found, 5)
    planner = ForesightController(ForesightSettings(width=20))
    measured = waited(found, vehicles, planner)
    decisions = found.horizon_s // found.timing.decision_interval_s
    assert planner.planned_veh_s.size >= decisions
    assert measured == planner.planned_veh_s[:decisions].sum() > 0


@pytest.mark.parametrize("timing", TIMINGS)
def test_nothing_is_better_on_a_short_horizon(timing, tee):
    interval_s = TIMINGS[timing].decision_interval_s
    found = made("tee", timing=timing, horizon_s=6 * interval_s, tee=tee)
    simulator, searched = QueueSimulator(found), 0
    for seed in range(2):
        # Everybody is there before the last decision, and nothing happens after the horizon.
        vehicles = vehicles_of_seed(found, seed)
        vehicles = vehicles.take(np.flatnonzero(vehicles.depart_s < found.horizon_s - 5))
        crossing = crossing_of(situation_of(found, vehicles))
        arriving = np.zeros((found.horizon_s, 6), np.int32)
        seconds = min(len(crossing.arriving_veh), found.horizon_s)
        arriving[:seconds] = crossing.arriving_veh[:seconds]
        _, planned_veh_s = search(crossing._replace(arriving_veh=arriving), 1000)
        least = np.inf
        for phases in product(range(3), repeat=6):
            simulator.reset(vehicles)
            for phase in phases:
                simulator.advance(np.array([phase]))
            least = min(least, simulator.measures().wait_veh_s)
            searched += 1
        assert planned_veh_s.sum() == least > 0
    assert searched == 2 * 3**6


@pytest.mark.parametrize("load", [1.0, 3.0, 7.0])
def test_wider_beams_find_plans_as_good_and_all_beat_longest_queue_first(load):
    found = made("grid", load=load, horizon_s=500)
    vehicles = vehicles_of_seed(found, 6)
    crossing = crossing_of(situation_of(found, vehicles))
    costs = [search(crossing, width)[1].sum() for width in (3, 30, 300, 1000)]
    rival = waited(found, vehicles, make_controller("longest-queue-first"))
    assert costs[1] <= 1.01 * costs[0]
    assert costs[2] <= 1.001 * costs[1]
    assert costs[3] <= costs[2] < rival
    assert waited(found, vehicles, make_controller("foresight")) == costs[3]


def test_after_the_last_arrival_the_longest_queues_are_served():
    found = made("grid", horizon_s=600)
    vehicles = vehicles_of_seed(found, 1)
    early = vehicles.take(np.flatnonzero(vehicles.depart_s < 200))
    planner = make_controller("foresight")
    result = evaluate(QueueSimulator(found), planner, early, diffusion, 0).measures
    assert result.arrived_veh == len(early)
    assert result.queued_at[-1] == 0
    assert planner.planned_veh_s.size <= 20


def test_a_run_without_vehicles_needs_no_plan():
    found = made("grid", load=0.0)
    assert waited(found, vehicles_of_seed(found, 0), make_controller("foresight")) == 0


def test_a_run_that_does_not_follow_its_plan_ends():
    found = made("grid")
    vehicles = vehicles_of_seed(found, 2)
    planner = make_controller("foresight")
    wrong = replace(found, dynamics=QueueDynamics(saturation_flow_veh_per_s=0.3))
    planner.reset(situation_of(wrong, vehicles))
    simulator = QueueSimulator(found)
    seen = simulator.reset(vehicles)
    with pytest.raises(
        InputError, match=r"'foresight': the run does not follow .* vehicle-seconds"
    ):
        while seen.time_s < 600:
            seen = simulator.advance(planner.decide(seen, None))


def begin(network, vehicles=None, timing=None, dynamics=None):
    empty = Vehicles(np.zeros(0, np.int32), np.zeros(1, np.int32), np.zeros(0, np.int32))
    make_controller("foresight").reset(
        RunContext(
            network,
            timing or SignalTiming(),
            stream(0, "none"),
            empty if vehicles is None else vehicles,
            dynamics or QueueDynamics(),
        )
    )


def test_it_says_what_it_cannot_foresee():
    single = grid(1, 1)
    node = single.intersections[0]
    shared = (replace(node.movements[0], lanes=(1,)), *node.movements[1:])
    gives_way = ((1,), *((),) * 11)
    late = SignalTiming(clearance_s=8, startup_lost_s=3)
    for problem, arguments in {
        "has 2 intersections": (grid(1, 2),),
        "share lane 1": (replace(single, intersections=(replace(node, movements=shared),)),),
        "give way": (replace(single, intersections=(replace(node, gives_way=gives_way),)),),
        "take 11 s": (single, None, late),
        "finite number": (single, None, None, QueueDynamics(storage=True)),
    }.items():
        with pytest.raises(InputError, match=problem) as caught:
            begin(*arguments)
        assert "grid:1x1" in str(caught.value)
    with pytest.raises(InputError, match="does not get the journeys"):
        make_controller("foresight").reset(RunContext(single, SignalTiming(), stream(0, "none")))


def test_nobody_may_come_twice():
    network = grid(1, 1)
    links = [network.link_index[name] for name in ("W0>0,0", "0,0>E0")]
    around = np.array([*links, *links], np.int32)
    vehicles = Vehicles(np.zeros(1, np.int32), np.array([0, 4], np.int32), around)
    with pytest.raises(InputError, match="vehicle 0 crosses the intersection 2 times"):
        begin(network, vehicles)
