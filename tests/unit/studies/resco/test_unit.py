"""Units of the study on the RESCO benchmark: days, protocols, seeds, and the deep rival."""

import pytest

from dmil.controllers.variants import Variant, parse_variant
from dmil.studies.resco.plan import ContenderUnit, units
from dmil.studies.resco.settings import RescoStudySettings
from dmil.studies.resco.study import run_unit

pytest.importorskip("libsumo", reason="needs the extra sumo")


def rows(tmp_path, *, resample):
    settings = RescoStudySettings(
        scenarios=("cologne1",), horizon_s=600, calibrate=False, resample=resample
    )
    found = []
    for seed in (0, 1):
        unit = ContenderUnit("resco", "resco/cologne1", seed, Variant("longest-queue-first"))
        (row,) = (
            each
            for each in run_unit(settings, str(tmp_path), unit).runs
            if each["simulator"] == "queue"
        )
        assert row["status"] == "ok"
        found.append(row)
    return found


def test_every_seed_of_the_benchmark_has_the_same_day(tmp_path):
    first, second = rows(tmp_path, resample=False)
    assert first["wait_veh_s"] == second["wait_veh_s"]


def test_resampled_days_differ_and_have_as_many_vehicles(tmp_path):
    first, second = rows(tmp_path, resample=True)
    assert first["wait_veh_s"] != second["wait_veh_s"]
    recorded = rows(tmp_path, resample=False)[0]["spawned_veh"]
    assert first["spawned_veh"] == second["spawned_veh"] == recorded


def unit(controller, seed=0):
    return ContenderUnit("resco", "resco/cologne1", seed, parse_variant(controller))


def test_both_protocols_of_sumo_have_the_same_vehicles_and_are_told_apart(tmp_path):
    settings = RescoStudySettings(scenarios=("cologne1",), horizon_s=600, calibrate=False)
    found = run_unit(settings, str(tmp_path), unit("max-pressure,approaching=true")).runs
    assert [row["simulator"] for row in found] == ["sumo", "sumo-unblocked", "queue"]
    assert {row["controller"] for row in found} == {"max-pressure,approaching=true"}
    assert len({row["spawned_veh"] for row in found}) == 1
    assert [row["locked"] for row in found] == [0, 0, 0]
    # Its mesoscopic model has no vehicles on junctions.
    assert settings.model_copy(update={"judge": "sumo-meso"}).in_sumo == ("sumo-meso",)


def test_who_learns_online_begins_every_run_with_nothing(tmp_path):
    settings = RescoStudySettings(scenarios=("cologne1",), horizon_s=600, calibrate=False)
    both = run_unit(settings, str(tmp_path), unit("factored")).runs
    alone = settings.model_copy(update={"unblocked": False})
    (_, queue) = run_unit(alone, str(tmp_path), unit("factored")).runs
    assert queue == both[2] and both[0]["reward"] is None and both[0]["training_s"] is None


def test_where_runs_lock_there_are_more_seeds_for_those_that_do_not_train():
    settings = RescoStudySettings(scenarios=("cologne1", "cologne3"), seeds=2, lock_seeds=4)
    count = {}
    for each in units(settings):
        key = each.network, each.controller.label, each.embedding, each.communication
        count[key] = count.get(key, 0) + 1
    assert count["cologne1", "combined", None, False] == 2
    assert count["cologne3", "combined", None, False] == 4
    assert count["cologne3", "sarsa", "exact", False] == 2
    assert not any(each.deep for each in units(settings))


def test_trainings_of_the_deep_rival_take_turns_over_the_seeds():
    settings = RescoStudySettings(
        scenarios=("cologne1", "grid4x4"), seeds=7, first_seed=3, deep=True
    )
    deep = [each for each in units(settings) if each.deep]
    assert {each.network for each in deep} == {"cologne1"}
    assert [list(each.test_seeds(settings)) for each in deep] == [[3, 6, 9], [4, 7], [5, 8]]


def test_the_deep_rival_trains_in_sumo_and_is_judged_frozen(tmp_path):
    pytest.importorskip("torch", reason="needs the extra deep")
    settings = RescoStudySettings(
        scenarios=("cologne1",), horizon_s=400, calibrate=False, deep=True, episodes=2, seeds=3
    )
    settings = settings.model_copy(update={"deep_seeds": 2, "unblocked": False})
    result = run_unit(settings, str(tmp_path), unit("dqn"))
    assert [(row["simulator"], row["seed"], row["status"]) for row in result.runs] == [
        ("sumo", 0, "ok"),
        ("queue", 0, "ok"),
        ("sumo", 2, "ok"),
        ("queue", 2, "ok"),
    ]
    assert {row["trained_in"] for row in result.runs} == {"sumo"}
    assert {(row["reward"], row["epsilon"]) for row in result.runs} == {("queue", 1.0)}
    assert [row["episode"] for row in result.episodes] == [0, 1]
    # Of 2 · 40 decisions all but the last of each episode are kept, and none is added by a run.
    assert {row["entries_per_agent"] for row in result.runs} == {2 * 39}
    again = run_unit(settings, str(tmp_path), unit("dqn"))
    assert again.runs == result.runs and again.episodes == result.episodes
