"""What the paper's study runs."""

from collections import Counter

import pytest

from dmil.controllers.tabular.settings import DualMemorySettings
from dmil.errors import InputError
from dmil.experiments.checks import check_horizon
from dmil.studies import PRESETS, PaperStudySettings
from dmil.studies.paper.plan import BASELINES, VARIANTS, architectures, blocks, training_s, variants


def test_the_24_architectures_of_the_paper_are_all_there():
    found = [
        each
        for each in architectures(PaperStudySettings(equal_epsilon=False))
        if each.embedding in ("simple", "complex")
    ]
    assert all(each.variant is None for each in found)
    assert len(found) == len(set(found)) == 24
    assert Counter(each.controller for each in found) == {"sarsa": 12, "dual-memory": 12}
    assert Counter(each.reward for each in found) == dict.fromkeys(
        ("default", "diffusion", "entropy"), 8
    )
    assert {each.epsilon for each in found if each.controller == "sarsa"} == {0.6}
    assert {each.epsilon for each in found if each.controller == "dual-memory"} == {0.4}


def test_every_agent_also_runs_at_equal_epsilon():
    found = architectures(PaperStudySettings())
    sarsa = {each for each in found if each.controller == "sarsa"}
    assert {each.epsilon for each in sarsa} == {0.6, 0.4}
    assert Counter(each.epsilon for each in sarsa) == {0.6: 15, 0.4: 15}


@pytest.mark.parametrize("first", ["complex", "complex-scaled"])
def test_the_architectures_of_the_table_run_with_every_reading_of_the_complex_classes(first):
    (other,) = {"complex", "complex-scaled"} - {first}
    settings = PaperStudySettings(complex_readings=(first, other), equal_epsilon=False)
    found = Counter(each.embedding for each in architectures(settings))
    assert (found["simple"], found[first], found[other]) == (12, 12, 6)
    only = architectures(PaperStudySettings(complex_readings=(first,)))
    assert {each.embedding for each in only} == {"exact", "simple", first, None}


def test_variants_run_once_in_the_last_preset_on_the_largest_grid():
    settings = PaperStudySettings(
        grids=("1x1", "3x3", "2x2"), seeds=3, first_seed=7, variant_seeds=1
    )
    found = {block: variants(settings, block) for block in blocks(settings)}
    (block,) = (block for block, plan in found.items() if plan)
    assert (block.preset, block.scenario, block.seed) == ("matched", "grid:3x3", 7)
    assert {each.reward for each in found[block]} == {"entropy"}
    assert tuple(each.variant for each in found[block]) == VARIANTS
    assert [each.communication for each in found[block]].count(False) == 1
    assert not set(found[block]) & set(architectures(settings))
    # What a study does anyway is no variant of it.
    own = settings.model_copy(
        update={"dual_memory": DualMemorySettings(trigger="staging", sent="both")}
    )
    left = {each.variant for each in variants(own, block)}
    assert set(VARIANTS) - left == {"trigger=staging", "sent=both"}
    for other in (
        PaperStudySettings(grids=("3x3",), variant_seeds=0),
        PaperStudySettings(grids=("1x1",)),
    ):
        assert not any(variants(other, block) for block in blocks(other))


def test_exact_sarsa_and_the_baselines_are_in_every_block():
    found = architectures(PaperStudySettings())
    assert sum(each.embedding == "exact" for each in found) == 6
    assert tuple(each.controller for each in found if each.reward is None) == BASELINES


def test_equal_epsilons_are_not_run_twice():
    settings = PaperStudySettings(sarsa={"epsilon": 0.4})
    found = architectures(settings)
    assert len(found) == len(set(found))


def test_blocks_are_every_preset_grid_and_seed():
    settings = PaperStudySettings(seeds=2, first_seed=5, grids=("1x1", "2x3"))
    plan = blocks(settings)
    assert len(plan) == len(set(plan)) == 3 * 2 * 2
    assert {block.seed for block in plan} == {5, 6}
    assert {block.scenario for block in plan} == {"grid:1x1", "grid:2x3"}


def test_training_is_ten_times_as_long_in_the_matched_preset_only():
    settings = PaperStudySettings(horizon_s=300)
    assert {name: training_s(settings, name) for name in PRESETS} == {
        "literal": 300,
        "decaying": 300,
        "matched": 3000,
    }


def test_a_run_needs_two_decisions():
    with pytest.raises(InputError, match="two decision intervals"):
        check_horizon(20, 15)
    check_horizon(30, 15)


@pytest.mark.parametrize("field", ["embedding", "communication", "epsilon_decay", "learning"])
def test_what_the_study_sets_itself_cannot_be_set(field):
    value = {"embedding": "cells", "epsilon_decay": 0.5, "learning": False, "communication": True}
    with pytest.raises(ValueError, match=f"sarsa.{field} is set by the study itself"):
        PaperStudySettings(sarsa={field: value[field]})
