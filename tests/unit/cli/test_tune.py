"""``dmil tune`` and what it leaves to ``train`` and ``evaluate``."""

import json

import pytest

from dmil.cli import tune as tune_command
from dmil.cli.study import MemoriesParameters
from dmil.controllers.variants import Variant
from dmil.studies.memories.plan import options_of

pytest.importorskip("optuna", reason="needs the extra tune")
RUN = ("--scenario", "grid:1x1", "--steps", 100)
SMALL = ("--budget", 100, "--check-seeds", 5, "--episodes", 0, "--jobs", 1)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("tuned")


@pytest.fixture
def tuned(folder, dmil):
    controllers = ("fixed-cycle", "sarsa,epsilon=0.05", "random")
    named = [part for name in controllers for part in ("--controller", name)]
    return dmil.json("tune", *RUN, *SMALL, *named, "--out", folder)["tuned"]


def test_every_controller_gets_the_same_budget_and_a_file(tuned, folder):
    assert [each["budget_runs"] for each in tuned] == [100, 100, 0]
    assert [each["file"] for each in tuned] == [
        str(folder / f"{name}.json") for name in ("fixed-cycle", "sarsa,epsilon=0.05", "random")
    ]
    assert tuned[1]["chosen"]["epsilon"] == 0.05
    assert "epsilon" not in tuned[1]["tuned_options"]


def test_the_terminal_tells_budget_rungs_and_what_was_chosen(tuned, folder, dmil):
    named = ("--controller", "fixed-cycle", "--controller", "random")
    text = dmil("tune", *RUN, *SMALL, *named, "--out", folder)
    assert "fixed-cycle on grid:1x1" in text
    assert "of 100 runs of 100 s used" in text
    assert "on 2 seeds → " in text
    assert "chosen: " in text
    assert "random on grid:1x1: nothing to tune, budget 0" in text


def test_evaluate_sets_the_tuned_beside_the_defaults(tuned, folder, dmil):
    file = folder / "fixed-cycle.json"
    found = dmil.json(
        "evaluate", *RUN, "--seeds", 2, "--jobs", 1, "--controller", "fixed-cycle", "--tuned", file
    )
    labels = [each["controller"] for each in found["controllers"]]
    assert {"fixed-cycle", "fixed-cycle tuned"} < set(labels)


def test_train_takes_controller_and_options(tuned, folder, dmil, tmp_path):
    from dmil.training import load_policy

    file, out = folder / "sarsa,epsilon=0.05.json", tmp_path / "policy.npz"
    dmil("train", *RUN, "--episodes", 1, "--tuned", file, "--out", out)
    policy = load_policy(out)
    assert policy.controller == "sarsa"
    for name, value in json.loads(file.read_text())["chosen"].items():
        assert policy.options[name] == value
    dmil("train", *RUN, "--tuned", file, "--controller", "dual-memory", "--out", out, code=2)
    assert "options of 'sarsa', not of 'dual-memory'" in dmil.err


def test_the_study_of_memories_takes_a_folder_of_them(tuned, folder, dmil):
    study = MemoriesParameters(tuned_in=folder, controllers=("fixed-cycle", "max-pressure")).study
    found = json.loads((folder / "fixed-cycle.json").read_text())
    assert (
        study.tuned["fixed-cycle"] == options_of(study, Variant("fixed-cycle")) == found["chosen"]
    )
    assert options_of(study, Variant("max-pressure")) == {}
    assert {each["budget_runs"] for each in study.tuning} == {0, 100}
    dmil("study", "memories", "--tuned", folder / "nowhere", code=2)
    assert "no tuned controller is there" in dmil.err


def test_what_cannot_be_used_is_one_error(tuned, folder, dmil, tmp_path):
    damaged = tmp_path / "damaged.json"
    damaged.write_text((folder / "fixed-cycle.json").read_text()[:-20])
    for command in (("evaluate", *RUN), ("train", *RUN, "--out", tmp_path / "a.npz")):
        dmil(*command, "--tuned", damaged, code=2)
        assert "damaged" in dmil.err
        dmil(*command, "--tuned", tmp_path / "none.json", code=2)
        assert "there is no such file" in dmil.err
    dmil("tune", *RUN, *SMALL, code=2)
    assert "nothing to tune" in dmil.err
    dmil("tune", *RUN, *SMALL, "--controller", "fixed-cicle", "--out", tmp_path, code=2)
    assert "Did you mean 'fixed-cycle'?" in dmil.err
    dmil("tune", *RUN, "--controller", "fixed-cycle", "--budget", 20, "--out", tmp_path, code=2)
    assert "expected at least 76" in dmil.err


def test_another_tuning_is_not_written_over(tuned, folder, dmil):
    dmil("tune", *RUN, "--controller", "fixed-cycle", "--out", folder, code=2)
    assert "it holds another tuning, with other settings" in dmil.err


def test_ctrl_c_says_how_to_go_on(monkeypatch, dmil, tmp_path):
    def stopped(*arguments, **options):
        raise KeyboardInterrupt

    monkeypatch.setattr(tune_command, "tune_one", stopped)
    dmil("tune", *RUN, *SMALL, "--controller", "fixed-cycle", "--out", tmp_path, code=1)
    assert "repeat the command to continue" in dmil.err


def test_recorded_vehicles_are_told(dmil, tmp_path):
    pytest.importorskip("sumolib", reason="needs the extra sumo")
    run = ("tune", "--scenario", "resco/cologne1", "--steps", 60, *SMALL)
    dmil(*run, "--controller", "random", "--out", tmp_path)
    assert "the same in every seed" in dmil.err


@pytest.mark.parametrize(
    ("last", "message"),
    [
        ("max-presure", "Did you mean 'max-pressure'"),
        ("max-pressure,aproaching=true", "Did you mean 'approaching'"),
        ("sarsa", "a budget of 50 runs; expected at least"),
    ],
)
def test_what_is_wrong_with_the_last_one_shows_before_the_first_is_run(
    last, message, dmil, tmp_path
):
    named = ("--controller", "fixed-cycle", "--controller", last)
    small = ("--budget", 50, "--check-seeds", 5, "--episodes", 1, "--jobs", 1)
    dmil("tune", *RUN, *small, *named, "--out", tmp_path / "tuned", code=2)
    assert message in dmil.err
    assert not (tmp_path / "tuned").exists()


def test_a_list_that_is_empty_is_no_default(dmil, tmp_path):
    dmil("study", "memories", "--cells", "", "--out", tmp_path / "x", code=2)
    assert "--cells: found ''; expected one name or more" in dmil.err
