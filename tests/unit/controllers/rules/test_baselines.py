from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from dmil.controllers import make_controller
from dmil.controllers.protocol import Controller, RunContext
from dmil.controllers.rules.baselines import (
    FixedCycleController,
    FixedCycleSettings,
    LongestQueueFirstController,
    MaxPressureController,
    RandomController,
    covering_phases,
)
from dmil.errors import InputError
from dmil.network import Program, Stage, grid
from dmil.scenarios import SignalTiming
from dmil.seeding import stream
from dmil.simulation import Observation
from dmil.simulation.pressure import movement_pressure
from dmil.simulation.timing import ACTUATED, PROGRAM

ALL = [RandomController, FixedCycleController, LongestQueueFirstController, MaxPressureController]
EW_F, EW_L, NS_F, NS_L, E_FL, N_FL, W_FL, S_FL = range(8)


def begin(controller, network, *, interval_s=10, seed=0):
    controller.reset(
        RunContext(
            network, SignalTiming(decision_interval_s=interval_s), stream(seed, "controller")
        )
    )
    return controller


def seen(network, queues=(), shown=-1, time_s=0):
    """Observe some queues, given as {orientation: vehicles} for every intersection."""
    shape = len(network.intersections), max(len(node.movements) for node in network.intersections)
    queue_veh = np.zeros(shape, np.int32)
    for i, queue in enumerate(queues):
        for j, count in queue.items():
            queue_veh[i, j] = count
    phase = np.broadcast_to(np.array(shown, np.int32), shape[0]).copy()
    elapsed = np.zeros(shape[0], np.int32)
    return Observation(
        queue_veh, np.zeros_like(queue_veh), phase, elapsed, time_s, np.zeros(queue_veh.shape)
    )


def choice(controller, network, queue, shown=-1):
    (phase,) = controller.decide(seen(network, [queue], shown), None)
    return phase


@pytest.mark.parametrize("kind", ALL)
def test_every_baseline_is_a_controller(kind):
    assert isinstance(kind(), Controller)


@pytest.mark.parametrize("kind", ALL)
@pytest.mark.parametrize("name", ["grid", "tee", "mixed_network"])
def test_no_baseline_chooses_a_phase_that_is_not_there(kind, name, request):
    network = grid(2, 2) if name == "grid" else request.getfixturevalue(name)
    controller = begin(kind(), network)
    counts = np.array([len(node.phases) for node in network.intersections])
    rng = stream(0, "no such phase", name)
    chosen = set()
    for decision in range(300):
        queues = [
            dict(enumerate(rng.integers(0, rng.integers(1, 9), len(node.movements))))
            for node in network.intersections
        ]
        shown = rng.integers(0, counts) if decision else -1
        phases = controller.decide(seen(network, queues, shown, 10 * decision), None)
        assert phases.shape == counts.shape
        assert phases.dtype == np.int32
        assert ((phases >= 0) & (phases < counts)).all()
        chosen |= set(enumerate(phases.tolist()))
    expected = {(i, phase) for i, count in enumerate(counts) for phase in range(count)}
    if kind is FixedCycleController:
        nodes = enumerate(network.intersections)
        expected = {(i, phase) for i, node in nodes for phase in covering_phases(node)}
    assert chosen == expected


# --- Random ----------------------------------------------------------------------------------


def test_random_phases_are_uniform_and_independent():
    network = grid(1, 2)
    controller = begin(RandomController(), network)
    draws = 16_000
    pairs = Counter(tuple(controller.decide(seen(network), None).tolist()) for _ in range(draws))
    assert len(pairs) == 64
    chi_square = sum((count - draws / 64) ** 2 / (draws / 64) for count in pairs.values())
    assert chi_square < 63 + 4 * np.sqrt(2 * 63)


def test_random_phases_come_from_the_stream_alone():
    network = grid(2, 2)
    runs = []
    for seed in (1, 1, 2):
        controller = begin(RandomController(), network, seed=seed)
        runs.append([controller.decide(seen(network), None).tolist() for _ in range(20)])
    assert runs[0] == runs[1] != runs[2]


# --- Fixed cycle -----------------------------------------------------------------------------


def cycle(controller, network, decisions, interval_s=10):
    return [
        controller.decide(seen(network, time_s=k * interval_s), None).tolist()
        for k in range(decisions)
    ]


def test_the_papers_intersection_cycles_through_its_first_four_phases():
    network = grid(1, 1)
    assert covering_phases(network.intersections[0]) == [EW_F, EW_L, NS_F, NS_L]
    shown = cycle(begin(FixedCycleController(), network), network, 9)
    assert shown == [[0], [1], [2], [3], [0], [1], [2], [3], [0]]


def test_phases_that_serve_nothing_new_are_left_out(tee):
    assert covering_phases(tee.intersections[0]) == [0, 1, 2]
    node = tee.intersections[0]
    more = replace(node, phases=(node.phases[0], frozenset({0, 3}), *node.phases[1:]))
    assert covering_phases(more) == [0, 2, 3]


def test_every_movement_of_a_cycle_gets_green(mixed_network):
    for node in mixed_network.intersections:
        served = frozenset().union(*(node.phases[phase] for phase in covering_phases(node)))
        assert served | node.unsignalled == set(range(len(node.movements)))


@pytest.mark.parametrize(("green_s", "intervals"), [(5, 1), (10, 1), (10.5, 2), (20, 2), (21, 3)])
def test_greens_are_rounded_up_to_decision_intervals(green_s, intervals):
    network = grid(1, 1)
    controller = FixedCycleController(FixedCycleSettings(green_s=green_s))
    shown = cycle(begin(controller, network), network, 4 * intervals + 1)
    assert shown == [[phase] for phase in range(4) for _ in range(intervals)] + [[0]]


def test_greens_are_measured_in_the_scenarios_intervals():
    network = grid(1, 1)
    controller = FixedCycleController(FixedCycleSettings(green_s=0.3))
    begin(controller, network, interval_s=5)
    assert cycle(controller, network, 5, interval_s=5) == [[0], [1], [2], [3], [0]]


def plan(network, *greens_s):
    """A program that shows the first phases of the only intersection for some seconds each."""
    phases = network.intersections[0].phases
    return Program(tuple(map(Stage, greens_s, phases)))


def test_a_files_program_gives_the_greens_and_a_setting_overrules_it(tee):
    node = replace(tee.intersections[0], program=plan(tee, 30.0, 10.0, 15.0))
    network = replace(tee, intersections=(node,))
    shown = cycle(begin(FixedCycleController(), network), network, 7)
    assert shown == [[0], [0], [0], [1], [2], [2], [0]]
    overruled = FixedCycleController(FixedCycleSettings(green_s=20.0))
    shown = cycle(begin(overruled, network), network, 7)
    assert shown == [[0], [0], [1], [1], [2], [2], [0]]


def test_a_phase_that_the_program_leaves_out_gets_one_interval(tee):
    node = replace(tee.intersections[0], program=plan(tee, 30.0))
    network = replace(tee, intersections=(node,))
    shown = cycle(begin(FixedCycleController(), network), network, 6)
    assert shown == [[0], [0], [0], [1], [2], [0]]


def test_intersections_with_cycles_of_their_own_lengths(mixed_network):
    controller = begin(FixedCycleController(), mixed_network)
    cycles = [covering_phases(node) for node in mixed_network.intersections]
    assert len({len(phases) for phases in cycles}) > 1
    for k, shown in enumerate(cycle(controller, mixed_network, 20)):
        assert shown == [phases[k % len(phases)] for phases in cycles]


def test_a_fixed_cycle_does_not_look_at_queues():
    network = grid(1, 1)
    controller = begin(FixedCycleController(), network)
    assert choice(controller, network, {4: 90, 10: 90}, shown=NS_F) == EW_F


# --- Longest queue first ---------------------------------------------------------------------


@pytest.mark.parametrize(
    ("queue", "phase"),
    [
        ({1: 3, 7: 4, 4: 6}, EW_F),
        ({4: 3, 10: 4, 1: 6}, NS_F),
        ({5: 5, 11: 1, 4: 4}, N_FL),
        ({2: 4, 8: 4, 1: 3, 7: 3}, EW_L),
        ({7: 2, 8: 2, 4: 3}, W_FL),
        ({10: 1, 11: 1, 2: 1}, S_FL),
    ],
)
def test_the_longest_queues_are_served(queue, phase):
    network = grid(1, 1)
    controller = begin(LongestQueueFirstController(), network)
    assert choice(controller, network, queue) == phase


def test_movements_that_always_may_go_do_not_count():
    network = grid(1, 1)
    controller = begin(LongestQueueFirstController(), network)
    assert choice(controller, network, {0: 50, 3: 50, 6: 50, 9: 50, 11: 1}, shown=EW_F) == NS_L


@pytest.mark.parametrize("kind", [LongestQueueFirstController, MaxPressureController])
@pytest.mark.parametrize("shown", range(8))
def test_of_equal_phases_the_one_shown_stays(kind, shown):
    network = grid(1, 1)
    controller = begin(kind(), network)
    assert choice(controller, network, dict.fromkeys(range(12), 2), shown=shown) == shown
    assert choice(controller, network, {}, shown=shown) == shown
    ties = {1: 2, 7: 2, 4: 2, 10: 2}
    assert choice(controller, network, ties, shown=shown) == (shown if shown == NS_F else EW_F)


@pytest.mark.parametrize("kind", [LongestQueueFirstController, MaxPressureController])
def test_of_equal_phases_the_first_is_taken_when_another_is_shown_or_none(kind):
    network = grid(1, 1)
    controller = begin(kind(), network)
    assert choice(controller, network, {}) == EW_F
    assert choice(controller, network, {5: 3, 11: 3, 4: 3}, shown=EW_F) == NS_L


@pytest.mark.parametrize("kind", [LongestQueueFirstController, MaxPressureController])
def test_a_lone_intersection_has_its_queues_as_pressure(kind):
    network = grid(1, 1)
    controller = begin(kind(), network)
    rng = stream(3, "lone")
    for _ in range(200):
        queue = dict(enumerate(rng.integers(0, 6, 12).tolist()))
        totals = [sum(queue[j] for j in phase) for phase in network.intersections[0].phases]
        shown = int(rng.integers(-1, 8))
        best = totals.index(max(totals))
        expected = shown if shown >= 0 and totals[shown] == max(totals) else best
        assert choice(controller, network, queue, shown) == expected


# --- Max-pressure ----------------------------------------------------------------------------


def test_max_pressure_does_not_send_vehicles_to_where_many_wait():
    network = grid(1, 2)
    # Left: 5 from the West straight on and 4 from the North straight on. Right: 9 from the West.
    queues = {7: 5, 4: 4}, {6: 3, 7: 3, 8: 3}
    pressure = begin(MaxPressureController(), network)
    longest = begin(LongestQueueFirstController(), network)
    # Straight on from the West is worth 5 − 3 only.
    assert pressure.decide(seen(network, queues), None).tolist() == [NS_F, W_FL]
    assert longest.decide(seen(network, queues), None).tolist() == [EW_F, W_FL]


def test_equal_pressures_are_equal_in_spite_of_rounding():
    network = grid(3, 3)
    controller = begin(MaxPressureController(), network)
    rng = stream(4, "thirds")
    rounded = 0
    for _ in range(120):
        queues = [dict(enumerate(rng.integers(0, 4, 12).tolist())) for _ in range(9)]
        observation = seen(network, queues, rng.integers(0, 8, 9))
        pressure_veh = movement_pressure(observation.queue_veh, network)
        found = controller.decide(observation, None)
        for i, node in enumerate(network.intersections):
            totals = [sum(pressure_veh[i, j] for j in phase) for phase in node.phases]
            # All are whole thirds.
            thirds = [round(3 * total) for total in totals]
            np.testing.assert_allclose(3 * np.array(totals), thirds, atol=1e-9)
            shown = int(observation.phase[i])
            best = thirds.index(max(thirds))
            assert found[i] == (shown if thirds[shown] == max(thirds) else best)
            rounded += totals[best] != max(totals)
    assert rounded > 0  # or this test could not fail


@pytest.mark.parametrize(("name", "asked"), [("program", PROGRAM), ("actuated", ACTUATED)])
def test_programs_are_asked_for_everywhere(tee, name, asked):
    node = replace(tee.intersections[0], program=plan(tee, 30.0))
    network = replace(tee, intersections=(node,))
    controller = begin(make_controller(name), network)
    assert cycle(controller, network, 2) == [[asked], [asked]]


@pytest.mark.parametrize("name", ["program", "actuated"])
def test_who_follows_programs_needs_them_everywhere(tee, name):
    with pytest.raises(InputError, match=r"'T': it has no signal program .* fixed-cycle"):
        begin(make_controller(name), tee)
