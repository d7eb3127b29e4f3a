"""The guard for shared lanes: nobody waits for ever behind a movement that has red."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from dmil.controllers import RunContext, make_controller
from dmil.controllers.rules.shared_lanes import SharedLaneGuard, rivals_of_lanes
from dmil.controllers.variants import parse_variant
from dmil.network import grid
from dmil.rewards import make_reward
from dmil.scenarios import SignalTiming
from dmil.scenarios.recipe import ScenarioRecipe
from dmil.seeding import stream
from dmil.simulation import Observation, make_simulator
from dmil.training import evaluate, vehicles_of_seed
from dmil.training.flow import FlowRecorder, locks

CASE = Path(__file__).parents[3] / "cases" / "factored-stuck"
RULES = ["max-pressure", "longest-queue-first", "factored", "lookahead"]
SEEING = ["max-pressure,approaching=true", "longest-queue-first,approaching=true"]
EW_F, EW_L, NS_F = range(3)


@pytest.fixture
def crossing(one_lane):
    """The paper's intersection with one lane a side."""
    return one_lane(grid(1, 1))


def context(network, interval_s=10):
    return RunContext(network, SignalTiming(decision_interval_s=interval_s), stream(0, "guard"))


def movements(network, direction):
    return [
        j
        for j, movement in enumerate(network.intersections[0].movements)
        if movement.turn == direction
    ]


def see(network, shown, **queues):
    """What is seen when every movement of a direction has such a queue."""
    queue_veh = np.zeros((1, len(network.intersections[0].movements)), np.int32)
    for direction, count in queues.items():
        queue_veh[0, movements(network, direction)] = count
    shown = np.array([shown], np.int32)
    none = np.zeros_like(queue_veh)
    return Observation(queue_veh, none, shown, np.zeros(1, np.int32), 0, none.astype(float))


def watched(guard, *observations):
    for each in observations:
        owed_veh = guard.owed_veh(each)
    return owed_veh.copy()


def test_rivals_share_a_lane_and_have_another_light(crossing):
    (node,) = crossing.intersections
    for j, rivals in enumerate(rivals_of_lanes(node)):
        for k in rivals:
            assert node.movements[j].from_link == node.movements[k].from_link
            assert any((j in phase) != (k in phase) for phase in node.phases)
    assert sum(map(len, rivals_of_lanes(node))) == 8  # straight and left of each side
    together = replace(node, phases=(frozenset(range(len(node.movements))),))
    assert not any(rivals_of_lanes(together))
    assert not any(rivals_of_lanes(grid(1, 1).intersections[0]))


def test_without_lanes_that_can_get_stuck_there_is_no_guard():
    for guard in (SharedLaneGuard(context(grid(1, 1))),):
        assert (guard.needed, guard.bytes_total) == (False, 0)
        assert not watched(guard, *[see(grid(1, 1), EW_F, straight=3, left=2)] * 5).any()


def test_red_counts_once_a_green_lane_did_not_move(crossing):
    guard = SharedLaneGuard(context(crossing))
    stuck = see(crossing, EW_F, straight=3, left=2)
    left = movements(crossing, "left")
    assert not watched(guard, stuck).any()  # the green may have begun late in the interval
    owed_veh = watched(guard, stuck)
    np.testing.assert_allclose(owed_veh[0, left], 0.2 * 20)
    assert watched(guard, stuck)[0, left[0]] > owed_veh[0, left[0]]


@pytest.mark.parametrize(
    "after",
    [{"straight": 2, "left": 2}, {"straight": 3, "left": 0}],
    ids=["somebody left", "nobody else waits"],
)
def test_a_lane_that_moves_or_whose_rivals_do_not_wait_is_not_stuck(crossing, after):
    guard = SharedLaneGuard(context(crossing))
    before = see(crossing, EW_F, straight=3, left=2)
    assert not watched(guard, before, see(crossing, EW_F, **after)).any()


def test_what_was_seen_fades_and_green_pays_what_is_owed(crossing):
    guard = SharedLaneGuard(context(crossing))
    stuck = see(crossing, EW_F, straight=3, left=2)
    watched(guard, stuck, stuck)
    served = watched(guard, see(crossing, EW_L, straight=3, left=2))
    west_east = [j for j in sorted(crossing.intersections[0].phases[EW_L])]
    assert not served[0, west_east].any()
    gone = [see(crossing, EW_L)] * 400
    later = watched(guard, *gone, *[see(crossing, NS_F, left=1)] * 2)
    assert 0 < later.max() < 0.1


def test_the_interval_does_not_change_what_time_is_worth(crossing):
    stuck = see(crossing, EW_F, straight=3, left=2)
    owed_veh = [
        watched(SharedLaneGuard(context(crossing, interval_s)), *[stuck] * count).max()
        for interval_s, count in ((5, 12), (10, 6))
    ]
    assert owed_veh[0] == pytest.approx(owed_veh[1])


@pytest.mark.parametrize("name", RULES)
def test_with_a_guard_all_come_to_green_and_without_one_phase_stays_for_ever(crossing, name):
    """As if straight were stuck behind left: nobody moves, whatever is green."""
    late = {}
    for guard in (True, False):
        controller, phase, phases = make_controller(name, {"guard": guard}), EW_F, []
        controller.reset(context(crossing))
        for _ in range(40):
            (phase,) = controller.decide(see(crossing, phase, straight=9, left=2), None)
            phases.append(phase)
        late[guard] = set(phases[10:])
    everybody = frozenset().union(*(crossing.intersections[0].phases[p] for p in late[True]))
    assert {*movements(crossing, "left"), *movements(crossing, "straight")} <= everybody
    assert len(late[False]) == 1


@pytest.mark.parametrize("name", RULES)
def test_what_cannot_get_stuck_is_controlled_as_without(name):
    recipe = ScenarioRecipe(scenario="grid:2x2", horizon_s=600, load=2.0)
    delays = {run(recipe, "queue", f"{name},guard={guard}") for guard in ("true", "false")}
    assert len(delays) == 1


def run(recipe, simulator, label, seed=0):
    scenario, variant = recipe.build(), parse_variant(label)
    vehicles = vehicles_of_seed(scenario, seed)
    controller = make_controller(variant.name, variant.options)
    made = make_simulator(scenario, simulator)
    measures = evaluate(made, controller, vehicles, make_reward("diffusion"), seed).measures
    return measures.arrived_veh, measures.delay_s


@pytest.mark.parametrize("load", [0.5, 1.0, 1.5])
@pytest.mark.parametrize("simulator", ["queue", pytest.param("sumo", marks=pytest.mark.slow)])
def test_one_lane_a_side_and_a_phase_for_left_turns(simulator, load):
    """Better than the file's own plan in both simulators, where it was stuck for the whole run."""
    pytest.importorskip("libsumo", reason="needs the extra sumo")
    recipe = ScenarioRecipe(
        net=CASE / "net.net.xml", routes=(CASE / "r.rou.xml",), horizon_s=900, load=load
    )
    scenario = recipe.build()
    vehicles = vehicles_of_seed(scenario, 0)
    made, recorder, flows, arrived = make_simulator(scenario, simulator), FlowRecorder(), [], []
    labels = [*RULES, *SEEING]
    if simulator == "sumo" and load != 1.0:  # every rule at one of the other loads
        labels = labels[load > 1.0 :: 2]
    for label in ("program", *labels):
        variant = parse_variant(label)
        controller = make_controller(variant.name, variant.options)
        reward = make_reward("diffusion")
        done = evaluate(made, controller, vehicles, reward, 0, observers=[recorder])
        flows.append(recorder.flow)
        arrived.append(done.measures.arrived_veh)
    assert locks(flows) == [()] * len(flows)
    if load == 1.0:
        assert min(arrived[1:]) > 1.15 * arrived[0]
    assert min(arrived[1:]) > 0.7 * arrived[0]
