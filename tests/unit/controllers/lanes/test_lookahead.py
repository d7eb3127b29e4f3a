"""Look-ahead: what its model learns, what it looks ahead for, what it keeps."""

import numpy as np
import pytest

from dmil.controllers import RunContext, make_controller
from dmil.errors import DivergedError, InputError, PolicyError
from dmil.network import grid
from dmil.rewards import make_reward
from dmil.scenarios import SignalTiming, scenario
from dmil.seeding import stream
from dmil.simulation import Observation, QueueSimulator
from dmil.testing import check_controller
from dmil.training import train, vehicles_of_seed
from tests.unit.controllers.lanes import late_arrivals

CLEARANCE = SignalTiming(clearance_s=3)
ALONE = {"expected": 0.0, "rounds": 0, "later": 0.0}
TRUSTING = {"queue_trust": 1.0, "trust": 0.0}
NODE = grid(1, 1).intersections[0]
SIGNALLED = [j for j in range(12) if j not in NODE.unsignalled]
RED, GREEN = 0, 1


def lookahead(**options):
    return make_controller("lookahead", options)


def begun(network=None, timing=None, **options):
    controller = lookahead(**options)
    controller.reset(RunContext(network or grid(1, 1), timing or SignalTiming(), stream(0)))
    return controller


def observation(queue, *, approaching=0, waiting=0.0, phase=0, time_s=0):
    """One intersection; numbers are those of all its movements."""
    queue_veh, approaching_veh = (np.zeros((1, 12), np.int32) for _ in range(2))
    waiting_veh = np.zeros((1, 12))
    queue_veh[:], approaching_veh[:], waiting_veh[:] = queue, approaching, waiting
    shown = np.array([phase], np.int32)
    return Observation(queue_veh, approaching_veh, shown, shown, time_s, waiting_veh)


def run(controller, made, seed=0):
    """Run a controller; return its phases at every decision."""
    simulator, chosen = QueueSimulator(made), []
    vehicles = vehicles_of_seed(made, seed)
    controller.reset(RunContext(made.network, made.timing, stream(seed), dynamics=made.dynamics))
    seen = simulator.reset(vehicles)
    while seen.time_s < made.horizon_s:
        chosen.append(controller.decide(seen, None).tolist())
        seen = simulator.advance(np.array(chosen[-1]))
    return chosen


def learned_times(controller):
    return int(controller.arrays()["times"].sum())


def test_what_is_learned_by_hand():
    """All lanes alike: 3 wait, then 2, 2.5 in the mean. Ten could leave in an interval of green."""
    controller = begun(**ALONE)
    asked = controller.decide(observation(3, phase=-1), None)[0]
    served = len(NODE.phases[asked])
    controller.decide(observation(2, phase=asked, waiting=2.5), None)
    arrays, row = controller.arrays(), 3 * 4
    assert arrays["times"][row].tolist() == [8 - served, served]
    # At red 3 would have waited all the time; at green the last of them left after 3 s.
    assert arrays["residual"][row, RED] == pytest.approx([2.5 - 3.0, 2.0 - 3.0])
    assert arrays["residual"][row, GREEN] == pytest.approx([2.5 - 0.45, 2.0 - 0.0])
    assert np.count_nonzero(arrays["times"]) == 2


def test_a_lane_model_with_known_parameters_is_learned():
    """Lanes that discharge 4 an interval, not 10, and get 0.7 vehicles that nobody saw."""
    controller, rng = begun(**ALONE), stream(0, "lanes")
    asked = -1
    for _ in range(6000):
        queue, coming = np.zeros((2, 12), np.int64)
        queue[SIGNALLED], coming[SIGNALLED] = rng.integers(9, size=8), rng.integers(3, size=8)
        seen = observation(queue, approaching=coming, phase=asked)
        asked = int(controller.decide(seen, None)[0])
        green = np.isin(np.arange(12), list(NODE.phases[asked]))
        leaves = np.minimum(queue + coming, 4) * green
        waiting = queue + 0.5 * coming - 0.25 * leaves
        left = queue + coming - leaves + (rng.random(12) < 0.7)
        seen = observation(left, phase=asked, waiting=waiting)
        # Then another phase than was asked for: what comes next is not learned from.
        asked = (int(controller.decide(seen, None)[0]) + 1) % 8
    residual = controller.arrays()["residual"].reshape(12, 4, 2, 2)
    times = controller.arrays()["times"].reshape(12, 4, 2)
    known = 0
    for queue in range(9):
        for coming in range(3):
            for treatment in (RED, GREEN):
                if times[queue, coming, treatment] < 300:
                    continue
                known += 1
                cost, end = residual[queue, coming, treatment]
                leaves = min(queue + coming, 4) if treatment == GREEN else 0
                model = queue + 0.5 * coming
                if treatment == GREEN:
                    model = queue**2 / (2 * (10 - coming))
                    if queue + coming - 10 >= 0:
                        model = 0.5 * (queue + queue + coming - 10)
                real = queue + 0.5 * coming - 0.25 * leaves
                model_end = queue + coming if treatment == RED else max(0, queue + coming - 10)
                assert cost == pytest.approx(real - model, abs=0.01)
                assert end == pytest.approx(queue + coming - leaves + 0.7 - model_end, abs=0.12)
    assert known >= 40


def test_what_was_learned_changes_choices():
    """Vehicles that approach come too late for this green: the lane model cannot know."""
    options = {**ALONE, **TRUSTING}
    learner = lookahead(**options)
    late_arrivals.drive(learner, 10_000)
    frozen, unlearned = (begun(learning=False, **options) for _ in range(2))
    frozen.restore(learner.arrays())
    best, found, believed = (
        late_arrivals.drive(each, 4000) for each in (late_arrivals.Best(), frozen, unlearned)
    )
    assert best <= found < 1.1 * best
    assert believed > 1.5 * best


def test_the_second_decision_counts():
    """A switch takes all but a second: with two decisions left it pays, with one it does not."""
    timing = SignalTiming(clearance_s=9)
    shown, other = 0, 2
    queue = np.zeros(12, np.int64)
    queue[list(NODE.phases[shown])] = 1
    queue[list(NODE.phases[other])] = 5
    options = {**ALONE, "terminal": 0.0, "curvature": 0.0, "plan": 1.0}
    found = [
        begun(timing=timing, depth=depth, **options).decide(observation(queue, phase=shown), None)
        for depth in (1, 2)
    ]
    assert [int(phase[0]) for phase in found] == [shown, other]


def test_long_queues_count_more_than_their_vehicles():
    """Both phases discharge twenty: what is left decides, and that the phase shown stays."""
    queue = np.zeros(12, np.int64)
    queue[list(NODE.phases[0])] = 11, 10
    queue[list(NODE.phases[2])] = 40, 10
    options = {**ALONE, "depth": 1, "discount": 1.0}
    seen = observation(queue, phase=0)
    assert begun(curvature=0.0, **options).decide(seen, None)[0] == 0
    assert begun(curvature=0.2, **options).decide(seen, None)[0] == 2


def test_announcements_change_choices():
    made = scenario("grid:3x3", horizon_s=600)
    without = run(lookahead(learning=False, rounds=0), made)
    assert without != run(lookahead(learning=False, rounds=1, wave=0.0), made)
    assert without != run(lookahead(learning=False, rounds=1, expected=0.0), made)


def test_who_was_overruled_does_not_learn():
    controller, asked = begun(), -1
    for overrules, times in ((False, 0), (True, 0), (False, 8), (True, 8), (False, 16)):
        shown = (asked + 1) % 8 if overrules else asked
        asked = int(controller.decide(observation(1, phase=shown, waiting=1.0), None)[0])
        assert learned_times(controller) == times


@pytest.mark.parametrize(("queue", "times"), [(20, 8), (21, 0)])
def test_long_queues_are_not_learned_from(queue, times):
    controller = begun()
    asked = controller.decide(observation(queue, phase=-1), None)[0]
    controller.decide(observation(3, phase=asked, waiting=queue), None)
    assert learned_times(controller) == times


@pytest.mark.parametrize("timing", [SignalTiming(), CLEARANCE], ids=["paper", "clearance"])
def test_memory_is_small_and_its_bytes_are_counted(timing):
    made = scenario("grid:3x3", horizon_s=300, timing=timing)
    controller = lookahead()
    run(controller, made)
    use, table = controller.memory_use(), controller.arrays()
    columns = 2 if timing.clearance_s == 0 else 3
    assert table["residual"].shape == (48, columns, 2)
    assert use.bytes_total == 48 * columns * (4 + 4 + 2) + 72 * (4 + 2 + 4 + 4 + 2 + 1)
    assert use.long_term_entries == use.msize == np.count_nonzero(table["times"])
    assert use.entries_total == use.long_term_entries + 72
    assert sum(controller.lookups().values()) == 30 * 72


def test_the_table_survives_a_run_and_loading_replaces_it():
    made = scenario("grid:2x2", horizon_s=900)
    old, new = lookahead(**TRUSTING), lookahead(**TRUSTING)
    run(old, made)
    run(new, made, seed=2)
    for _ in range(2):
        new.restore(old.arrays())
    before = learned_times(old)
    assert learned_times(new) == before
    assert run(old, made, seed=1) == run(new, made, seed=1)
    assert learned_times(old) > before
    for name, array in old.arrays().items():
        assert array.tobytes() == new.arrays()[name].tobytes()


def test_a_frozen_table_does_not_change():
    controller = lookahead(learning=False)
    run(controller, scenario("grid:2x2", horizon_s=300))
    assert not any(array.any() for array in controller.arrays().values())
    assert controller.lookups()["learned"] == 0


@pytest.mark.parametrize("spoilt", ["residual", "times"])
def test_arrays_of_something_else_are_refused(spoilt):
    controller = begun()
    kept = controller.arrays()
    for wrong in (None, kept[spoilt][:-1], kept[spoilt].astype(np.float64)):
        arrays = {**kept, spoilt: wrong}
        with pytest.raises(PolicyError, match=f"array '{spoilt}'"):
            controller.restore({name: a for name, a in arrays.items() if a is not None})
    arrays = controller.arrays()
    arrays["residual"][3, 1, 0] = np.nan
    with pytest.raises(PolicyError, match="'residual' holds numbers that cannot be"):
        controller.restore(arrays)


def test_lanes_treated_in_ways_it_does_not_know():
    controller = begun(grid(1, 1))
    controller.reset(RunContext(grid(2, 2), SignalTiming(), stream(0)))
    with pytest.raises(PolicyError, match="knows 2 of 3 ways to treat a lane"):
        controller.reset(RunContext(grid(2, 2), CLEARANCE, stream(0)))


def test_a_table_that_knows_more_ways_is_loaded():
    made = scenario("grid:2x2", horizon_s=600, timing=CLEARANCE)
    old, new = lookahead(), begun(grid(1, 1))
    run(old, made)
    new.restore(old.arrays())
    new.decide(observation(1, phase=-1), None)
    assert new.memory_use().long_term_entries == old.memory_use().long_term_entries
    assert run(new, made, seed=1) == run(old, made, seed=1)


def test_residuals_that_are_no_number_stop_the_run():
    controller = begun()
    asked = controller.decide(observation(1, phase=-1), None)[0]
    with pytest.raises(DivergedError, match="'lookahead' diverged at 10 s"):
        controller.decide(observation(1, phase=asked, waiting=np.nan, time_s=10), None)


@pytest.mark.parametrize(
    ("option", "value"),
    [
        ("depth", 3),
        ("plan", 1.1),
        ("terminal", -1),
        ("curvature", float("inf")),
        ("discount", 1.1),
        ("expected", -0.1),
        ("later", 1.5),
        ("rounds", -1),
        ("wave", float("nan")),
        ("trust", -1),
        ("queue_trust", 2),
        ("rate_step", 0),
    ],
)
def test_options_out_of_range(option, value):
    with pytest.raises(InputError, match=f"controller 'lookahead': {option} = "):
        lookahead(**{option: value})


def test_a_resumed_training_is_an_uninterrupted_one():
    made, reward = scenario("grid:1x2", horizon_s=600), make_reward("queue")
    whole, begin, resumed = lookahead(), lookahead(), lookahead()
    train(made, whole, reward, 3, episodes=range(3))
    train(made, begin, reward, 3, episodes=range(1))
    resumed.reset(RunContext(made.network, made.timing, stream(0)))
    resumed.restore(begin.arrays())
    train(made, resumed, reward, 3, episodes=range(1, 3))
    for name, array in whole.arrays().items():
        assert array.tobytes() == resumed.arrays()[name].tobytes()


def test_conformance():
    check_controller(lookahead)
    check_controller(lambda: lookahead(**TRUSTING))
