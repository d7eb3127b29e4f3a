"""Which junctions are said to have locked: those that stand still, not those that are only full."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from dmil.controllers import make_controller
from dmil.controllers.variants import parse_variant
from dmil.rewards import make_reward
from dmil.scenarios.recipe import ScenarioRecipe
from dmil.simulation import make_simulator
from dmil.training import evaluate, vehicles_of_seed
from dmil.training.flow import Flow, FlowRecorder, locks, locks_of, undelayed

STUCK = Path(__file__).parents[2] / "cases" / "factored-stuck"
TIME_S = np.arange(0, 1810, 10, dtype=np.int32)
SIMULATORS = ["queue", pytest.param("sumo", marks=pytest.mark.slow)]


def flow(veh_per_10_s, queue_veh=5):
    """The flow of one junction: vehicles that cross it in every 10 s, and its queue."""
    crossing = np.broadcast_to(veh_per_10_s, TIME_S.size - 1)
    passed = np.concatenate([[0], np.cumsum(crossing)])
    queue = np.broadcast_to(queue_veh, TIME_S.size)
    return Flow(TIME_S, queue[:, None].astype(np.int32), passed[:, None].astype(np.int32))


def test_a_junction_that_nobody_crosses_any_more_is_locked_from_then_on():
    crossing = np.where(TIME_S[:-1] < 1240, 4, 0)
    (fine, (lock,)) = locks([flow(4), flow(crossing)])
    assert fine == ()
    assert 1180 <= lock.since_s <= 1240


def test_a_trickle_is_a_lock_where_another_controller_lets_many_through():
    trickle = np.where(np.arange(TIME_S.size - 1) % 10 == 0, 2, 0)
    assert locks([flow(4), flow(trickle)])[1][0].since_s == 0
    assert locks([flow(trickle), flow(trickle)]) == [(), ()]


def test_a_full_junction_is_not_locked_though_its_queue_never_empties():
    assert locks([flow(4, 80), flow(2, 200), flow(1, 300)]) == [(), (), ()]


def test_a_junction_whose_queue_emptied_later_is_not_locked():
    queue = np.where(TIME_S == 1700, 0, 5)
    crossing = np.where(TIME_S[:-1] < 300, 4, 0)
    assert locks([flow(4), flow(crossing, queue)]) == [(), ()]


def test_a_run_too_short_to_tell_has_no_locks():
    short = Flow(TIME_S[:20], np.ones((20, 1), np.int32), np.zeros((20, 1), np.int32))
    assert locks([short]) == [()]


def run_all(recipe, simulator, controllers, seed=0):
    scenario = recipe.build()
    made, recorder = make_simulator(scenario, simulator), FlowRecorder()
    vehicles, flows, measured = vehicles_of_seed(scenario, seed), [], []
    for name in controllers:
        chosen = parse_variant(name)
        controller = make_controller(chosen.name, chosen.options)
        reward = make_reward("diffusion")
        run = evaluate(made, controller, vehicles, reward, seed, observers=[recorder])
        flows.append(recorder.flow)
        measured.append(run.measures)
    return flows, measured


def stuck(**changes):
    return ScenarioRecipe(
        net=STUCK / "net.net.xml", routes=(STUCK / "r.rou.xml",), horizon_s=900, **changes
    )


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_a_shared_lane_that_is_never_served_is_named_in_both_simulators(simulator):
    pytest.importorskip("libsumo", reason="needs the extra sumo")
    flows, measured = run_all(stuck(), simulator, ["program", "max-pressure,guard=false"])
    plan, rule = locks(flows)
    assert plan == ()
    assert [lock.intersection for lock in rule] == [0]
    assert rule[0].since_s <= 120
    assert measured[1].arrived_veh < 0.2 * measured[0].arrived_veh


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_three_times_the_demand_is_no_lock_in_either_simulator(simulator):
    pytest.importorskip("libsumo", reason="needs the extra sumo")
    flows, measured = run_all(stuck(load=3.0), simulator, ["program", "fixed-cycle"])
    assert measured[0].arrived_veh < 0.65 * measured[0].spawned_veh
    assert (flows[0].queue_veh[30:] > 0).all()
    assert locks(flows) == [(), ()]


@pytest.mark.parametrize("load", [5, 12])
def test_grids_far_beyond_capacity_are_not_locked(load):
    recipe = ScenarioRecipe(scenario="grid:3x3", horizon_s=1200, load=load)
    flows, _ = run_all(recipe, "queue", ["fixed-cycle", "random", "max-pressure"])
    assert locks(flows) == [(), (), ()]


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_everybody_crosses_the_one_junction_once(simulator):
    pytest.importorskip("libsumo", reason="needs the extra sumo")
    (found,), (measures,) = run_all(stuck(load=0.2), simulator, ["program"])
    crossed = int(found.passed_veh[-1, 0])
    assert measures.arrived_veh <= crossed <= measures.spawned_veh
    assert crossed - measures.arrived_veh <= 10
    assert (np.diff(found.passed_veh[:, 0]) >= 0).all()
    assert found.time_s[-1] == 900


def test_what_would_flow_without_delay_is_what_the_routes_say():
    scenario = ScenarioRecipe(scenario="grid:1x2", horizon_s=600).build()
    vehicles, network = vehicles_of_seed(scenario, 0), scenario.network
    found = undelayed(network, vehicles, TIME_S)
    crossed = np.zeros_like(found.passed_veh)
    for v, depart_s in enumerate(vehicles.depart_s):
        at_s = float(depart_s)
        route = vehicles.route_links[vehicles.route_offset[v] : vehicles.route_offset[v + 1]]
        for here, there in pairwise(route.tolist()):
            at_s += network.free_flow_time_s[here]
            crossed[at_s <= TIME_S, network.movement_index[here, there][0]] += 1
    assert (found.passed_veh == crossed).all() and crossed[-1].sum() > 100
    assert (found.queue_veh == 0).all()


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_one_run_alone_tells_that_its_junction_locked(simulator):
    pytest.importorskip("libsumo", reason="needs the extra sumo")
    recipe = stuck()
    scenario, (program, blocked) = recipe.build(), ["program", "max-pressure,guard=false"]
    flows, _ = run_all(recipe, simulator, [program, blocked])
    vehicles = vehicles_of_seed(scenario, 0)
    assert locks_of(flows[0], scenario.network, vehicles) == ()
    assert len(locks_of(flows[1], scenario.network, vehicles)) == 1
