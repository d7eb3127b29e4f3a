"""The factored memory: what it acts on, what it learns from, what it keeps."""

from dataclasses import replace

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
TRUSTING = {"trust": 1.0, "trust_veh": 5.0}
LANES_ONLY = {"rates": False, "expected": 0.0, "wave": 0.0}


def factored(**options):
    return make_controller("factored", options)


def begun(network=None, timing=None, **options):
    controller = factored(**options)
    controller.reset(RunContext(network or grid(1, 1), timing or SignalTiming(), stream(0)))
    return controller


def narrow_network():
    """One intersection whose roads have one lane."""
    network = grid(1, 1)
    node = network.intersections[0]
    movements = tuple(replace(movement, lanes=(0,)) for movement in node.movements)
    return replace(network, intersections=(replace(node, movements=movements),))


def observation(queue, *, waiting=0.0, phase=0, time_s=0):
    """All movements of one intersection with the same queue."""
    queue_veh = np.full((1, 12), queue, np.int32)
    shown = np.array([phase], np.int32)
    waiting_veh = np.full((1, 12), float(waiting))
    return Observation(queue_veh, queue_veh * 0, shown, shown, time_s, waiting_veh)


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


@pytest.mark.parametrize("load", [1.0, 4.0])
@pytest.mark.parametrize("name", ["grid:1x1", "grid:3x3", "grid:5x5"])
def test_a_state_never_seen_is_served_as_longest_queue_first_does(name, load):
    made = scenario(name, horizon_s=1200, load=load)
    unlearned = factored(learning=False, expected=0.0, wave=0.0)
    longest = make_controller("longest-queue-first", {"approaching": True})
    assert run(unlearned, made) == run(longest, made)
    assert unlearned.lookups()["long-term"] == unlearned.memory_use().long_term_entries == 0


def test_announcements_change_choices():
    made = scenario("grid:3x3", horizon_s=600)
    without = run(factored(learning=False, expected=0.0, wave=0.0), made)
    assert without != run(factored(learning=False, expected=0.3, wave=0.0), made)
    assert without != run(factored(learning=False, expected=0.0, wave=0.7), made)


def test_who_was_overruled_does_not_learn():
    controller, asked = begun(), -1
    for overrules, times in ((False, 0), (True, 0), (False, 8), (True, 8), (False, 16)):
        shown = (asked + 1) % 8 if overrules else asked
        asked = int(controller.decide(observation(1, phase=shown, waiting=1.0), None)[0])
        assert learned_times(controller) == times


def test_arrivals_are_not_guessed_where_a_request_was_overruled():
    """Two who waited still do; had they had green, ten had left and ten had come."""
    rows = []
    for overrules in (False, True):
        controller = begun(expected=0.0, wave=0.0)
        asked = int(controller.decide(observation(2, phase=-1), None)[0])
        shown = (asked + 4) % 8 if overrules else asked
        asked = int(controller.decide(observation(2, phase=shown), None)[0])
        controller.decide(observation(2, phase=asked), None)
        rows.append({int(row) for row in np.flatnonzero(controller.arrays()["times"].any(axis=1))})
    # Rows of 2 vehicles, none approaching: the last figure is the bin of the rate.
    first = 2 * 4 * 6
    assert rows == [{first + 2, first + 1, first + 5}, {first + 2}]


@pytest.mark.parametrize(("queue", "times"), [(20, 8), (21, 0)])
def test_long_queues_are_not_learned_from(queue, times):
    controller = begun()
    asked = controller.decide(observation(queue, phase=-1), None)[0]
    controller.decide(observation(3, phase=asked, waiting=queue), None)
    assert learned_times(controller) == times


def test_what_is_learned_by_hand():
    """All lanes alike: 3 wait, then 2, 2.5 in the mean; γ = ½, a vehicle is worth 2."""
    controller = begun(discount=0.5, **LANES_ONLY)
    asked = controller.decide(observation(3, phase=-1), None)[0]
    served = len(grid(1, 1).intersections[0].phases[asked])
    controller.decide(observation(2, phase=asked, waiting=2.5), None)
    arrays = controller.arrays()
    # Two lanes have green and six have red, each of them writes after the other. Green is worth 0
    # before and after; red −6 before, −4 after. The same phase again: it is as good and stays.
    green, red, steps = 0.0, 0.0, 0.1 / (1 + np.arange(6) / 5) ** 0.6
    for k in range(served):
        green += steps[k] * (-2.5 - green)
    for k in range(8 - served):
        red += steps[k] * (0.5 * -4 - 2.5 - (red - 6))
    row = 3 * 4 * 6
    assert arrays["times"][row].tolist() == [8 - served, served]
    assert arrays["residual"][row] == pytest.approx([red, green], rel=1e-5)
    assert np.count_nonzero(arrays["times"]) == 2


@pytest.mark.parametrize(
    ("name", "timing"),
    [(f"grid:{n}x{n}", timing) for n in (1, 3, 5) for timing in (SignalTiming(), CLEARANCE)],
)
def test_memory_is_small_and_its_bytes_are_counted(name, timing):
    made = scenario(name, horizon_s=300, timing=timing)
    controller = factored()
    run(controller, made)
    intersections = len(made.network.intersections)
    use, table = controller.memory_use(), controller.arrays()
    short = 8 * intersections * (4 + 2 + 4 + 4 + 2 + 1)
    assert use.bytes_total == sum(array.nbytes for array in table.values()) + short
    assert use.bytes_total < 10_000 * intersections
    assert use.long_term_entries == use.msize == np.count_nonzero(table["times"])
    assert use.short_term_entries == 8
    assert use.entries_total == use.long_term_entries + 8 * intersections
    assert sum(controller.lookups().values()) == 30 * 8 * intersections


def test_the_table_survives_a_run_and_short_term_memory_does_not():
    made = scenario("grid:2x2", horizon_s=1500)
    old, new, empty = factored(**TRUSTING), factored(**TRUSTING), factored(**TRUSTING)
    run(old, made)
    new.reset(RunContext(made.network, made.timing, stream(0)))
    new.restore(old.arrays())
    before = learned_times(old)
    second = run(old, made, seed=1)
    assert learned_times(old) > before
    assert second == run(new, made, seed=1)
    assert second != run(empty, made, seed=1)
    for name, array in old.arrays().items():
        assert array.tobytes() == new.arrays()[name].tobytes()


def test_runs_are_equal():
    made = scenario("grid:2x3", horizon_s=600)
    first, second = factored(), factored()
    assert run(first, made) == run(second, made)
    for name, array in first.arrays().items():
        assert array.tobytes() == second.arrays()[name].tobytes()


def test_a_frozen_table_does_not_change():
    made = scenario("grid:2x2", horizon_s=300)
    controller = factored(learning=False)
    run(controller, made)
    assert not any(array.any() for array in controller.arrays().values())


def test_loading_replaces_and_never_adds():
    made = scenario("grid:2x2", horizon_s=300)
    first, second = factored(), factored()
    run(first, made)
    run(second, made, seed=1)
    second.restore(first.arrays())
    second.restore(first.arrays())
    assert second.memory_use() == first.memory_use()


@pytest.mark.parametrize("spoilt", ["residual", "times"])
def test_arrays_of_something_else_are_refused(spoilt):
    controller = begun()
    kept = controller.arrays()
    for wrong in (None, kept[spoilt][:-1], kept[spoilt].astype(np.float64)):
        arrays = {**kept, spoilt: wrong}
        with pytest.raises(PolicyError, match=f"array '{spoilt}'"):
            controller.restore({name: a for name, a in arrays.items() if a is not None})


def test_numbers_that_cannot_be_are_not_loaded():
    controller = begun()
    arrays = controller.arrays()
    arrays["residual"][3, 1] = np.nan
    with pytest.raises(PolicyError, match="'residual' holds numbers that cannot be"):
        controller.restore(arrays)


def test_lanes_treated_in_ways_it_does_not_know():
    controller = begun(grid(1, 1))
    controller.reset(RunContext(grid(2, 2), SignalTiming(), stream(0)))
    with pytest.raises(PolicyError, match="knows 2 of 3 ways to treat a lane"):
        controller.reset(RunContext(grid(2, 2), CLEARANCE, stream(0)))
    with pytest.raises(PolicyError, match="knows 2 of 4 ways to treat a lane"):
        controller.reset(RunContext(narrow_network(), SignalTiming(), stream(0)))
    # Who knows more ways knows these, too.
    controller = begun(narrow_network())
    controller.reset(RunContext(grid(2, 2), SignalTiming(), stream(0)))


def test_a_table_that_knows_more_ways_is_loaded():
    made = scenario("grid:2x2", horizon_s=600, timing=CLEARANCE)
    old, new = factored(), begun(grid(1, 1))
    run(old, made)
    new.restore(old.arrays())
    new.decide(observation(1, phase=-1), None)
    assert new.memory_use().long_term_entries == old.memory_use().long_term_entries
    assert run(new, made, seed=1) == run(old, made, seed=1)


def test_arrays_of_an_observation_may_be_laid_out_in_any_way():
    plain, other = begun(grid(2, 2)), begun(grid(2, 2))
    shown = np.zeros(4, np.int32)
    for k in range(5):
        queue_veh = stream(k).poisson(2.0, (4, 12)).astype(np.int32)
        seen = Observation(queue_veh, queue_veh, shown, shown, 10 * k, queue_veh / 3)
        wide, turned = queue_veh.astype(np.int64), np.asfortranarray(queue_veh)
        spread = np.repeat(queue_veh / 3, 2, axis=1)[:, ::2]
        as_seen = Observation(wide, turned, shown.astype(np.int64), shown, 10 * k, spread)
        shown = plain.decide(seen, None)
        assert other.decide(as_seen, None).tolist() == shown.tolist()
    for name, array in plain.arrays().items():
        assert other.arrays()[name].tobytes() == array.tobytes()


def test_values_beyond_all_numbers_stop_the_run():
    controller, asked = begun(vehicle=1e38), -1
    with pytest.raises(DivergedError, match=r"'factored' diverged at \d+ s"):
        for k in range(60):
            seen = observation(k % 9, phase=asked, time_s=10 * k)
            asked = int(controller.decide(seen, None)[0])


@pytest.mark.parametrize(
    ("option", "value"),
    [
        ("expected", 1.1),
        ("expected", -0.1),
        ("wave", -1),
        ("wave", float("inf")),
        ("discount", 1.0),
        ("vehicle", 0),
        ("trust", -0.1),
        ("trust_veh", float("nan")),
        ("rate_step", 0),
        ("rate_step", 1.5),
        ("rates", "often"),
    ],
)
def test_options_out_of_range(option, value):
    with pytest.raises(InputError, match=f"controller 'factored': {option} = "):
        factored(**{option: value})
    with pytest.raises(InputError, match="discount"):
        factored(discuont=1)


def test_a_resumed_training_is_an_uninterrupted_one():
    made, reward = scenario("grid:1x2", horizon_s=600), make_reward("queue")
    whole, begin, resumed = factored(), factored(), factored()
    train(made, whole, reward, 3, episodes=range(3))
    train(made, begin, reward, 3, episodes=range(1))
    resumed.reset(RunContext(made.network, made.timing, stream(0)))
    resumed.restore(begin.arrays())
    train(made, resumed, reward, 3, episodes=range(1, 3))
    for name, array in whole.arrays().items():
        assert array.tobytes() == resumed.arrays()[name].tobytes()


def test_values_are_the_true_ones_and_choices_the_best():
    """What is known of a lane after one interval: who waits at red; approaching ones come late."""
    options = {**LANES_ONLY, **TRUSTING, "discount": 0.0}
    learner = factored(**options)
    late_arrivals.show_at_random(learner, 8000)
    frozen, prior = (begun(learning=False, **options) for _ in range(2))
    frozen.restore(learner.arrays())
    shape = 12, 4, 6, 2
    residual, times = (
        learner.arrays()[name].reshape(shape)[:4, :3, 0] for name in ("residual", "times")
    )
    gain = residual[..., 1] - residual[..., 0] + 2.0 * np.add.outer(range(4), range(3))
    tried = (times > 200).all(axis=-1)
    assert np.count_nonzero(tried) >= 9
    true_gain = np.broadcast_to(np.arange(4.0)[:, None], tried.shape)
    assert gain[tried] == pytest.approx(true_gain[tried], abs=0.05)
    assert late_arrivals.wrong_states(frozen, 0.0) == []
    assert len(late_arrivals.wrong_states(prior, 0.0)) > 10


def test_a_wrong_prior_is_learned_away():
    options = {**LANES_ONLY, **TRUSTING}
    learner = factored(**options)
    late_arrivals.drive(learner, 20_000)
    frozen, prior = (begun(learning=False, **options) for _ in range(2))
    frozen.restore(learner.arrays())
    best, found, believed = (
        late_arrivals.drive(each, 4000) for each in (late_arrivals.Best(), frozen, prior)
    )
    assert best < found < 1.15 * best
    assert believed > 3 * best


def test_conformance():
    check_controller(factored)
    check_controller(lambda: factored(**TRUSTING))
