"""Webster's plan: flows, phases, cycle, splits."""

import math
from dataclasses import replace

import numpy as np
import pytest

from dmil.controllers import RunContext, make_controller
from dmil.controllers.rules.webster import (
    WebsterController,
    WebsterSettings,
    covers,
    critical_ratios,
    flow_ratios,
    intervals_allowed,
    mean_flows,
    split,
    webster_cycle_s,
    whole_intervals,
)
from dmil.demand import Vehicles
from dmil.errors import InputError
from dmil.network import grid
from dmil.rewards import diffusion
from dmil.scenarios import QueueDynamics, SignalTiming, scenario
from dmil.seeding import stream
from dmil.simulation import Observation, QueueSimulator
from dmil.training import vehicles_of_seed
from dmil.training.phases import evaluate

EW_F, EW_L, NS_F, NS_L, E_FL, N_FL, W_FL, S_FL = range(8)


def journeys(network, *counts, seconds=1000):
    """Return vehicles that take ways given as (from, to, how many), evenly over the seconds."""
    index, rows = network.link_index, []
    for start, goal, count in counts:
        route = [index[f"{start}>0,0"], index[f"0,0>{goal}"]]
        rows += [(seconds - 1 - round(k * seconds / count), route) for k in range(count)]
    rows.sort(key=lambda row: row[0])
    depart_s = np.array([row[0] for row in rows], np.int32)
    links = np.array([row[1] for row in rows], np.int32).ravel()
    return Vehicles(depart_s, np.arange(0, links.size + 1, 2, dtype=np.int32), links)


def planned(network, vehicles, timing=None, dynamics=None, **settings):
    controller = WebsterController(WebsterSettings(**settings))
    rng = stream(0, "none")
    controller.reset(
        RunContext(network, timing or SignalTiming(), rng, vehicles, dynamics or QueueDynamics())
    )
    return controller


def shown(controller, network, decisions, interval_s=10):
    size = len(network.intersections)
    empty, phase = np.zeros((size, 12), np.int32), np.zeros(size, np.int32)
    return [
        controller.decide(
            Observation(empty, empty, phase, phase, k * interval_s, empty.astype(float)), None
        ).tolist()
        for k in range(decisions)
    ]


# --- The textbook ----------------------------------------------------------------------------


def test_cycle_and_splits_of_a_textbook_example():
    # Khanna and Justo, Highway Engineering: flows of 400 and 250 per h on roads with saturation
    # flows of 1250 and 1000, two phases, 16 s lost: a cycle of 67.4 s, greens of 29 and 22.5 s.
    critical = [400 / 1250, 250 / 1000]
    cycle_s = webster_cycle_s(16, sum(critical))
    assert cycle_s == pytest.approx(67.4, abs=0.05)
    timing = SignalTiming(decision_interval_s=1, startup_lost_s=8)
    shares, worst = whole_intervals(critical, cycle_s, 120, timing)
    assert sum(shares) == 67
    assert [share - 8 for share in shares] == [29, 22]
    assert worst == pytest.approx(sum(critical) * 67 / 51, rel=0.02)


@pytest.mark.parametrize(("ratio", "cycle_s"), [(0.0, 20.0), (0.5, 40.0), (0.9, 200.0)])
def test_the_cycle_grows_with_the_flow_ratio(ratio, cycle_s):
    assert webster_cycle_s(10, ratio) == pytest.approx(cycle_s)


def test_beyond_capacity_the_cycle_is_infinite():
    assert webster_cycle_s(10, 1.0) == webster_cycle_s(10, 1.7) == math.inf


# --- Flows -----------------------------------------------------------------------------------


def test_flows_are_journeys_per_second():
    network = grid(1, 1)
    flow = mean_flows(network, journeys(network, ("W0", "E0", 250), ("N0", "E0", 100)))
    expected = np.zeros((1, 12))
    expected[0, 7], expected[0, 5] = 0.25, 0.1
    np.testing.assert_allclose(flow, expected)
    assert not mean_flows(network, journeys(network, seconds=1)).any()


def test_every_intersection_of_a_journey_counts():
    made = scenario("grid:2x3", horizon_s=600)
    vehicles = vehicles_of_seed(made, 0)
    flow = mean_flows(made.network, vehicles) * (vehicles.depart_s[-1] + 1)
    crossings = len(vehicles.route_links) - len(vehicles)
    assert flow.sum() == pytest.approx(crossings)


def test_lanes_share_a_movements_flow_and_add_up_what_they_serve():
    node = grid(1, 1).intersections[0]
    movements = list(node.movements)
    movements[0] = replace(movements[0], lanes=(0,))
    movements[1] = replace(movements[1], lanes=(0, 1))
    movements[2] = replace(movements[2], lanes=(2,))
    node = replace(node, movements=tuple(movements))
    flow = np.zeros(12)
    flow[:3] = 0.1, 0.3, 0.05
    # Lane 0 has .1 + .15, lane 1 has .15, lane 2 has .05; saturation flow is .5.
    assert flow_ratios(node, flow, 0.5)[:3] == pytest.approx([0.5, 0.5, 0.1])


# --- Phases ----------------------------------------------------------------------------------


def test_sets_of_phases_serve_everybody_and_have_nothing_to_spare():
    node = grid(1, 1).intersections[0]
    found = covers(node)
    assert (EW_F, EW_L, NS_F, NS_L) in found
    assert (E_FL, N_FL, W_FL, S_FL) in found
    assert (EW_F, EW_L, N_FL, S_FL) in found
    needed = set(range(12)) - node.unsignalled
    for phases in found:
        assert set().union(*(node.phases[p] for p in phases)) == needed
        for left_out in phases:
            rest = [node.phases[p] for p in phases if p != left_out]
            assert set().union(*rest) != needed
    assert len(set(found)) == len(found)


def test_one_busy_side_gets_a_phase_of_its_own():
    network = grid(1, 1)
    one_side = journeys(network, ("W0", "E0", 300), ("W0", "N0", 300), seconds=1000)
    (plan,) = planned(network, one_side).plans
    # Straight on and left together need .3; one after the other they would need .6.
    assert W_FL in plan
    both = journeys(network, ("W0", "E0", 300), ("E0", "W0", 300), seconds=1000)
    (plan,) = planned(network, both).plans
    assert EW_F in plan


def test_a_movement_of_several_phases_needs_no_more_than_is_left(tee):
    node = tee.intersections[0]
    # Movement 0 is served in phases 0 and 1, movement 2 in phases 0 and 2.
    ratio = [0.5, 0.2, 0.1, 0.2, 0.9, 0.1]
    assert critical_ratios(node, (0, 1, 2), ratio) == pytest.approx([0.25, 0.25, 0.1])
    ratio[0] = 0.4
    assert critical_ratios(node, (0, 1, 2), ratio) == pytest.approx([0.2, 0.2, 0.1])


# --- Whole intervals -------------------------------------------------------------------------


def test_intervals_left_go_to_the_fullest_phase():
    assert split([0.4, 0.2, 0.1, 0.0], 10, 1, math.inf, 10, 0) == [5, 3, 1, 1]
    assert split([0.0, 0.0], 6, 1, math.inf, 10, 0) == [5, 1]
    assert split([0.4, 0.1], 6, 2, 3, 10, 0) == [3, 3]
    # With 8 of 10 s lost the first interval of a phase is nearly worthless.
    assert split([0.3, 0.2], 4, 1, math.inf, 10, 8) == [2, 2]


def test_a_cycle_is_longer_where_whole_intervals_would_be_too_coarse():
    # 20 s are two intervals: a green of half the time for a flow ratio of .65. Of 30 s it would
    # get two thirds, which is still too little.
    shares, worst = whole_intervals([0.65, 0.15], 20, 120, SignalTiming())
    assert shares == [3, 1]
    assert worst == pytest.approx(0.65 / 0.75)
    shares, _ = whole_intervals([0.4, 0.15], 20, 120, SignalTiming())
    assert shares == [1, 1]


def test_beyond_capacity_the_best_of_all_cycles_is_taken():
    shares, worst = whole_intervals([0.9, 0.3], 120, 120, SignalTiming())
    assert shares == [9, 3]
    assert worst == pytest.approx(1.2)


def test_greens_keep_the_signal_timing():
    assert intervals_allowed(SignalTiming()) == (1, math.inf)
    assert intervals_allowed(SignalTiming(clearance_s=3, min_green_s=7)) == (1, math.inf)
    assert intervals_allowed(SignalTiming(clearance_s=3, min_green_s=8)) == (2, math.inf)
    assert intervals_allowed(SignalTiming(min_green_s=15, max_green_s=30)) == (2, 3)
    assert intervals_allowed(SignalTiming(clearance_s=3, max_green_s=30)) == (1, 4)


@pytest.mark.parametrize(
    "timing",
    [
        SignalTiming(),
        SignalTiming(decision_interval_s=5, clearance_s=3, min_green_s=10, max_green_s=40),
        SignalTiming(decision_interval_s=10, clearance_s=4, min_green_s=12, startup_lost_s=2),
    ],
)
def test_the_signals_never_overrule_the_plan(timing):
    made = scenario("grid:2x2", horizon_s=900, load=2.0, timing=timing)
    vehicles = vehicles_of_seed(made, 3)
    controller = make_controller("webster")
    result = evaluate(QueueSimulator(made), controller, vehicles, diffusion, 3)
    assert result.measures.overruled == 0


# --- The controller --------------------------------------------------------------------------


def test_the_plan_repeats():
    network = grid(1, 1)
    vehicles = journeys(network, ("W0", "E0", 600), ("N0", "S0", 100), seconds=1000)
    controller = planned(network, vehicles)
    (plan,) = controller.plans
    cycle = [[phase] for phase, count in plan.items() for _ in range(count)]
    assert plan[EW_F if EW_F in plan else W_FL] > 1
    assert shown(controller, network, 2 * len(cycle)) == 2 * cycle


def test_saturation_flow_is_the_scenarios_unless_given():
    network = grid(1, 1)
    vehicles = journeys(network, ("W0", "E0", 300), ("N0", "S0", 100), seconds=1000)
    light = planned(network, vehicles).plans
    dense = planned(network, vehicles, dynamics=QueueDynamics(saturation_flow_veh_per_s=0.5)).plans
    given = planned(network, vehicles, saturation_flow_veh_per_s=0.5).plans
    assert dense == given != light


def test_the_cycle_keeps_its_bounds():
    network = grid(1, 1)
    few = journeys(network, ("W0", "E0", 10))
    many = journeys(network, ("W0", "E0", 900), ("N0", "S0", 900))
    assert sum(planned(network, few).plans[0].values()) == 4
    assert sum(planned(network, few, min_cycle_s=70).plans[0].values()) == 7
    assert 4 <= sum(planned(network, many, max_cycle_s=80).plans[0].values()) <= 8
    # Four phases of at least one interval need 40 s whatever is asked for.
    assert sum(planned(network, many, max_cycle_s=20).plans[0].values()) == 4


def test_without_journeys_there_are_no_flows():
    with pytest.raises(InputError, match=r"'webster': it does not get the journeys .* fixed-cycle"):
        planned(grid(1, 1), None)


def test_a_run_without_vehicles_has_a_plan():
    network = grid(1, 1)
    (plan,) = planned(network, journeys(network, seconds=1)).plans
    assert sum(plan.values()) == 4
