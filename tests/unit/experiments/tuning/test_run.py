import json

import numpy as np
import pytest

from dmil.controllers.variants import Variant, parse_variant
from dmil.errors import DivergedError, InputError, OutputError
from dmil.experiments.tuning import TuningSettings, check_tuning, load_tuned, planned_tuning, tune
from dmil.experiments.tuning.scoring import Judge
from dmil.files import held
from dmil.parallel import LocalExecutor
from dmil.scenarios.recipe import ScenarioRecipe
from dmil.seeding import LARGEST_SEED, tuning_seeds
from dmil.training import vehicles_of_seed

pytest.importorskip("optuna", reason="needs the extra tune")
RECIPE = ScenarioRecipe(scenario="grid:1x1", horizon_s=100)
SETTINGS = TuningSettings(budget=120, check_seeds=5, episodes=1)


class Interrupted:
    """Ctrl-C after some scores."""

    def __init__(self, after):
        self.left = after

    def map(self, function, items):
        for item in items:
            if self.left == 0:
                raise KeyboardInterrupt
            self.left -= 1
            yield function(item)


def tuned(path, name="fixed-cycle", settings=SETTINGS, executor=None, **options):
    executor = executor or LocalExecutor(1)
    return tune(planned(name, settings, **options), path, executor=executor)


def planned(name="fixed-cycle", settings=SETTINGS, **options):
    return planned_tuning(RECIPE, parse_variant(name), settings, **options)


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    path = tmp_path_factory.mktemp("tuned") / "fixed-cycle.json"
    return path, tuned(path)


def test_the_best_of_the_search_is_checked_on_further_seeds(finished):
    path, found = finished
    assert load_tuned(path) == found
    assert found.finished and found.runs <= SETTINGS.budget
    assert found.trials[0].values == {} and found.trials[0].state == "finished"
    leader = found.trials[found.leader]
    assert leader.mean == pytest.approx(np.mean(leader.scores[:18]))
    assert leader.mean <= min(each.mean for each in found.trials if each.state == "finished")
    if found.leader:
        assert not np.isnan(found.check(found.leader)).any()
    better = found.leader and found.check(found.leader).mean() < found.check(0).mean()
    assert found.best == (found.leader if better else 0)
    assert found.chosen == found.trials[found.best].values


def test_the_summary_tells_budget_rungs_and_best_against_defaults(finished):
    told = finished[1].summary()
    assert told["budget_runs"] == 120 and told["simulated_s"] == 100 * told["runs"]
    assert [each["seeds"] for each in told["rungs"]] == [2, 6, 18]
    candidates = [each["candidates"] for each in told["rungs"]]
    assert candidates == sorted(candidates, reverse=True) and candidates[0] > 0
    if told["check_seeds"]:
        ends = told["best_minus_default"]
        assert ends["low"] <= ends["mean"] <= ends["high"]
        assert ends["mean"] == pytest.approx(told["best_mean"] - told["default_mean"])
    json.dumps(told, allow_nan=False)


def test_every_run_counts_once(finished):
    found = finished[1]
    scores = sum(score is not None for each in found.trials for score in each.scores)
    assert found.runs == scores


@pytest.mark.parametrize("after", [1, 30, 75])
def test_what_was_interrupted_goes_on_to_the_same_bytes(after, finished, tmp_path):
    path = tmp_path / "fixed-cycle.json"
    with pytest.raises(KeyboardInterrupt):
        tuned(path, executor=Interrupted(after))
    kept = json.loads(path.read_text())
    assert not kept["finished"]
    count = sum(score is not None for each in kept["trials"] for score in each["scores"])
    assert count == after
    with pytest.raises(InputError, match="did not come to its end"):
        load_tuned(path)
    with pytest.raises(KeyboardInterrupt):
        tuned(path, executor=Interrupted(finished[1].runs - after - 1))
    tuned(path, executor=Interrupted(1))
    assert path.read_bytes() == finished[0].read_bytes()


def test_any_number_of_processes_gives_the_same_bytes(finished, tmp_path):
    path = tmp_path / "fixed-cycle.json"
    with LocalExecutor(2) as executor:
        tuned(path, executor=executor)
    assert path.read_bytes() == finished[0].read_bytes()


def test_a_finished_one_is_not_run_again(finished):
    assert tuned(finished[0], executor=Interrupted(0)) == finished[1]


def test_a_file_of_another_tuning_is_left_alone(finished):
    before = finished[0].read_bytes()
    other = SETTINGS.model_copy(update={"budget": 130})
    with pytest.raises(OutputError, match="holds another tuning, with other settings"):
        tuned(finished[0], settings=other)
    with pytest.raises(OutputError, match="with other reward"):
        tuned(finished[0], reward="queue")
    assert finished[0].read_bytes() == before


def test_no_test_has_the_demand_of_a_tuning_seed():
    scenario = RECIPE.build()

    def demand(seed):
        vehicles = vehicles_of_seed(scenario, seed)
        return vehicles.depart_s.tobytes() + vehicles.route_links.tobytes()

    seeds = tuning_seeds(0, 38)
    assert len(set(seeds)) == 38 and min(seeds) > LARGEST_SEED
    tests = {demand(seed) for seed in range(1000)}
    assert len(tests) > 900  # seeds tell demands apart at all
    assert not tests & {demand(seed) for seed in seeds}


def test_the_first_tuning_seeds_do_not_depend_on_how_many_there_are():
    assert tuning_seeds(3, 40)[:20] == tuning_seeds(3, 20)
    assert not set(tuning_seeds(3, 40)) & set(tuning_seeds(4, 40))


@pytest.mark.parametrize("frozen", [False, True])
def test_a_learner_pays_for_its_training_too(frozen, tmp_path):
    settings = SETTINGS.model_copy(update={"budget": 160, "frozen": frozen})
    found = tuned(tmp_path / "sarsa.json", "sarsa,embedding=cells", settings)
    scores = sum(score is not None for each in found.trials for score in each.scores)
    assert found.runs == 2 * scores <= 160
    assert found.chosen["embedding"] == "cells"
    assert "embedding" not in found.space


def test_frozen_learners_get_other_scores(tmp_path):
    def score(frozen):
        judge = Judge(planned("sarsa", SETTINGS.model_copy(update={"frozen": frozen})))
        return judge.score(Variant("sarsa", {"epsilon": 0.6}), 7)

    assert score(True) != score(False)


def test_a_controller_without_options_has_no_budget(tmp_path):
    path = tmp_path / "random.json"
    found = tuned(path, "random")
    assert load_tuned(path) == found
    assert (found.runs, found.summary()["budget_runs"], found.chosen) == (0, 0, {})


@pytest.mark.parametrize(
    ("name", "settings", "message"),
    [
        ("fixd-cycle", {}, "Did you mean 'fixed-cycle'"),
        ("fixed-cycle,gren_s=3", {}, "Did you mean 'green_s'"),
        ("fixed-cycle", {"budget": 45}, "expected at least 46: a score costs 1 runs"),
        ("sarsa", {"budget": 91}, "expected at least 92: a score costs 2 runs"),
    ],
)
def test_what_is_wrong_shows_before_anything_is_run(name, settings, message, tmp_path):
    path = tmp_path / "a.json"
    with pytest.raises(InputError, match=message):
        tuned(path, name, SETTINGS.model_copy(update=settings), executor=Interrupted(0))
    assert not path.exists()


def diverging(when):
    score = Judge.score

    def diverges(self, variant, seed):
        if when(variant.options):
            raise DivergedError("fixed-cycle", "its green", 30)
        return score(self, variant, seed)

    return diverges


def test_candidates_that_diverge_are_told_and_not_chosen(monkeypatch, tmp_path):
    monkeypatch.setattr(Judge, "score", diverging(lambda options: options.get("green_s", 0) > 20))
    found = tuned(tmp_path / "a.json")
    failed = [each for each in found.trials if each.state == "failed"]
    assert len(failed) == found.summary()["failed"] > 0
    assert all(any(isinstance(score, str) for score in each.scores) for each in failed)
    assert found.leader not in [found.trials.index(each) for each in failed]


def test_defaults_that_diverge_are_one_clear_error(monkeypatch, tmp_path):
    monkeypatch.setattr(Judge, "score", diverging(lambda options: not options))
    with pytest.raises(InputError, match="a run with the defaults failed"):
        tuned(tmp_path / "a.json")


def test_two_processes_do_not_tune_into_one_file(tmp_path):
    path = tmp_path / "fixed-cycle.json"
    lock, refused = path.with_name("fixed-cycle.json.in-use"), "at work on this tuning"
    with held(lock, where=path, work="tuning"), pytest.raises(OutputError, match=refused):
        tuned(path)
    assert not path.exists()


def test_what_is_wrong_with_the_folder_shows_before_anything_is_run(tmp_path):
    (tmp_path / "file").touch()
    for path in (tmp_path / "file" / "a.json", tmp_path / "file" / "deeper" / "a.json"):
        with pytest.raises(OutputError, match="it is no folder"):
            check_tuning(planned(), path)
