"""What a comparison answers: which to use, or why that is not known."""

from dataclasses import replace

import numpy as np
import pytest

from dmil.experiments.answer import answer, locked_notes
from dmil.experiments.comparison import Comparison, Locked

PLAN, RULE, MEMORY = "program", "longest-queue-first,approaching=true", "factored"
CALLED = "longest-queue-first with approaching"


def comparison(delays, **changes):
    """Made from label to delay in every seed."""
    labels = list(delays)
    values = np.array([delays[label] for label in labels], np.float64).T
    found = Comparison(labels, range(len(values)), {"delay_s": values}, same_demand=False)
    return replace(found, reference=PLAN, **changes)


def around(mean, step=0.1):
    return [mean + step * k for k in (-2, -1, 0, 1, 2)]


def test_the_one_with_less_delay_than_all_others_is_to_be_used():
    found = comparison({PLAN: around(40), RULE: around(17), MEMORY: around(16)})
    assert answer(found) == (
        "Use factored: it has the least delay, 16.0 s per vehicle, 24.0 s [24.0, 24.0] less than "
        "your plan."
    )


def test_those_without_a_shown_difference_are_level_and_the_rule_is_the_simplest():
    other = [16.3, 15.8, 16.2, 15.9, 16.1]
    found = comparison({PLAN: around(40), MEMORY: around(16), RULE: other})
    assert answer(found).startswith(f"{MEMORY} and {CALLED} are level: the least delay, 16.0 s")
    assert answer(found).endswith(f"Of these {CALLED} is the simplest: it learns nothing.")


def test_a_plan_that_nothing_beats_is_kept():
    found = comparison({PLAN: around(10), RULE: around(17)})
    assert answer(found) == "Keep your plan: it has less delay than all others."


def test_what_is_level_with_the_plan_is_not_preferred():
    found = comparison({PLAN: [16.3, 15.9, 16.2, 15.9, 16.1], RULE: around(16)})
    assert answer(found) == f"Nothing is shown to beat your plan: {CALLED} is level."


@pytest.mark.parametrize("seeds", [1, 5])
def test_one_recorded_day_has_no_verdict(seeds):
    found = comparison({PLAN: [40.0] * seeds, RULE: [17.0] * seeds}, same_demand=True)
    assert answer(found) == (
        f"On this one day {CALLED} has the least delay, 17.0 s per vehicle; your plan has 40.0 s. "
        "For a verdict add --resample for other days like it."
    )
    difference = found.difference("delay_s")
    np.testing.assert_allclose(difference.value, [0, -23])
    assert np.isnan(difference.low).all()
    assert np.isnan(found.mean("delay_s").high).all()


def test_one_day_in_sumo_is_said_to_be_one():
    found = comparison({PLAN: around(40), RULE: around(17)}, same_demand=True, exact=False)
    assert answer(found).startswith(f"Use {CALLED}")
    assert answer(found).endswith("On this one recorded day, that is: --resample tries others.")


def test_one_seed_shows_nothing():
    found = comparison({PLAN: [40.0], RULE: [17.0]})
    assert answer(found).startswith(f"In this one seed {CALLED} has the least delay")
    assert answer(found).endswith("add --seeds 10.")


def test_nothing_is_preferred_where_differences_are_withheld():
    found = comparison({PLAN: around(40), RULE: around(17)}, withheld="less clearance")
    assert answer(found).startswith("No recommendation")
    assert found.difference("delay_s") is None


def test_a_limit_that_nobody_can_use_is_no_answer():
    found = comparison({PLAN: around(40), "foresight": around(5), RULE: around(17)})
    assert answer(found).startswith(f"Use {CALLED}")


def test_no_vehicle_no_answer():
    assert "no vehicle departed" in answer(comparison({PLAN: [np.nan] * 3, RULE: [np.nan] * 3}))


def test_who_is_not_shown_to_beat_the_plan_is_not_level_with_one_that_is():
    plan, memory = [32.0, 45.0, 40.0, 38.0, 50.0], [21.0, 21.6, 17.5, 18.3, 37.3]
    found = comparison({PLAN: plan, "actuated": [35.6, 40.0, 34.1, 37.8, 32.6], MEMORY: memory})
    assert answer(found).startswith("Use factored: it has the least delay, 23.1 s per vehicle")


def test_who_locks_is_not_level_with_the_best_one():
    other = [16.3, 15.8, 900.0, 15.9, 16.1]
    locked = {(MEMORY, 2): (Locked("X", 1240),)}
    found = comparison({PLAN: around(40), RULE: around(16), MEMORY: other}, locked=locked)
    assert answer(found).startswith(f"Use {CALLED}: it has the least delay, 16.0 s per vehicle")


def test_a_locked_run_of_the_best_one_is_told():
    locked = {(MEMORY, 1): (Locked("X", 1240),)}
    found = comparison({PLAN: around(40), MEMORY: around(16)}, locked=locked)
    assert answer(found).endswith("But factored locked in 1 of 5 seeds.")
    assert locked_notes(found) == ["factored: 1 of 5 seeds locked at junction X from 1,240 s on."]


def test_locks_of_several_seeds_and_junctions_are_put_together():
    locked = {
        (RULE, 0): (Locked("X", 1240), Locked("Y", 1500), Locked("Z", 1600)),
        (RULE, 2): (Locked("X", 900),),
        (RULE, 4): (Locked("Y", 300),),
    }
    found = comparison({PLAN: around(40), RULE: around(16)}, locked=locked)
    assert locked_notes(found) == [
        f"{RULE}: 3 of 5 seeds locked at junction X from 900 s on (the earliest of 2); at junction "
        "Y from 300 s on, with up to 2 more behind it."
    ]


def test_ranked_puts_the_least_mean_first_with_all_its_values():
    found = comparison({PLAN: around(40), RULE: around(17), MEMORY: around(16)}).ranked("delay_s")
    assert found.labels == [MEMORY, RULE, PLAN]
    np.testing.assert_allclose(found.measures["delay_s"][:, 0], around(16))


def test_median_interquartile_mean_and_worst_seed():
    values = {"delay_s": [1.0, 2.0, 3.0, 6.0, 100.0], "throughput_veh_per_h": [5, 4, 3, 2, 1]}
    measures = {name: np.array(each, np.float64)[:, None] for name, each in values.items()}
    found = Comparison(["x"], range(5), measures, same_demand=False)
    spread = found.spread("delay_s")
    assert (spread["median"], spread["worst"]) == ([3.0], [100.0])
    np.testing.assert_allclose(spread["interquartile_mean"], [(2 + 3 + 6) / 3])
    assert found.spread("throughput_veh_per_h")["worst"] == [1.0]
