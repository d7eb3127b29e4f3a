import sys

import pytest

from dmil.controllers.entry import Choice, Range
from dmil.errors import MissingExtraError
from dmil.experiments.tuning.halving import halve
from dmil.seeding import stream

pytest.importorskip("optuna", reason="needs the extra tune")
RUNGS = (2, 6, 18)
SPACE = {"x": Range(0.0, 1.0), "n": Range(1, 9, whole=True), "kind": Choice(("a", "b"))}
USUAL = {"x": 0.9, "n": 9, "kind": "a"}


class Bench:
    """Scores with a known best, and what was asked for."""

    def __init__(self, noise=0.01):
        self.noise = noise
        self.asked = []

    def one(self, values, place):
        bad = values.get("kind") == "b"
        luck = stream(1, "luck", place).normal() * self.noise
        return (values["x"] - 0.3) ** 2 + 0.01 * abs(values.get("n", 4) - 4) + bad + luck

    def __call__(self, candidates, places):
        self.asked += [(tuple(each.items()), place) for each in candidates for place in places]
        return [[self.one(each, place) for place in places] for each in candidates]


def search(bench, budget=400, space=SPACE, usual=USUAL, seed=1):
    return halve(space, (usual, [0.41] * RUNGS[-1]), bench, RUNGS, budget=budget, seed=seed)


def best_of(candidates):
    return min((each for each in candidates if each.state == "finished"), key=lambda c: c.mean)


def test_the_best_is_found_though_most_candidates_get_few_seeds():
    bench = Bench()
    candidates = search(bench)
    best = best_of(candidates)
    assert best.values["kind"] == "a"
    assert best.mean < 0.05
    stopped = sum(each.state == "stopped" for each in candidates)
    assert stopped > len(candidates) / 2


@pytest.mark.parametrize("budget", [0, 17, 18, 19, 100, 333])
def test_the_budget_is_kept_and_no_score_asked_for_twice(budget):
    bench = Bench()
    candidates = search(bench, budget)
    assert len(bench.asked) == len(set(bench.asked)) <= budget
    assert bool(candidates) == (budget >= 18)
    assert budget - len(bench.asked) < 18 + 2 * 12  # what is left does not pay another one


def test_every_candidate_has_the_first_seeds_and_some_all():
    bench = Bench()
    candidates = search(bench)
    counts = [
        sum(tuple(each.values.items()) == who for who, _ in bench.asked) for each in candidates
    ]
    assert set(counts) <= set(RUNGS)
    assert sum(count == 18 for count in counts) >= 2


def test_one_seed_gives_one_search_and_another_one_another():
    first, again = (search(Bench(), 150) for _ in range(2))
    assert first == again
    assert search(Bench(), 150, seed=2) != first


def test_a_small_space_is_searched_to_its_end_and_left():
    bench = Bench()
    space = {"kind": Choice(("a", "b")), "x": Choice((0.1, 0.3))}
    candidates = search(bench, 10_000, space, {"kind": "a", "x": 0.1})
    found = [each.values for each in candidates]
    assert len(found) == 3  # all but the defaults
    assert best_of(candidates).values == {"kind": "a", "x": 0.3}


def test_defaults_outside_of_the_space_are_no_obstacle():
    candidates = search(Bench(), 60, {"x": Range(0.0, 0.5)}, {"x": None})
    assert candidates


def test_candidates_that_make_no_difference_are_run_no_further():
    class Deaf(Bench):
        def one(self, values, place):
            return super().one({"x": 0.3, "n": values["n"]}, place)

    bench = Deaf()
    space = {"x": Range(0.0, 1.0), "n": Range(1, 3, whole=True)}
    candidates = search(bench, 400, space, {"x": 0.5, "n": 3})
    states = [each.state for each in candidates]
    assert states.count("finished") <= 3  # one for each n
    assert states.count("repeated") > len(states) / 2


def test_a_candidate_that_fails_goes_no_further():
    class Failing(Bench):
        def __call__(self, candidates, places):
            rows = super().__call__(candidates, places)
            return [
                ["diverged", *row[1:]] if each["kind"] == "b" else row
                for each, row in zip(candidates, rows, strict=True)
            ]

    bench = Failing()
    candidates = search(bench, 150)
    failed = [each for each in candidates if each.values["kind"] == "b"]
    assert failed and all(each.state == "failed" for each in failed)
    for each in failed:
        asked = sum(who == tuple(each.values.items()) for who, _ in bench.asked)
        assert asked == RUNGS[0]


def test_without_the_library_one_command_is_told(monkeypatch):
    monkeypatch.setitem(sys.modules, "optuna", None)
    with pytest.raises(MissingExtraError, match=r"pip install 'dmil\[tune\]'"):
        search(Bench())
