"""The commands: what they explain, what they print, what they do with files of parameters."""

import json
import tomllib

import pytest

from dmil.cli.application import COMMANDS
from dmil.controllers import CONTROLLERS
from dmil.rewards import REWARDS
from dmil.scenarios import SignalTiming, scenario_names
from dmil.studies import PaperStudySettings
from dmil.symmetry import EMBEDDINGS
from dmil.theory import STATEMENTS, best_case, check_hyperparameters, worst_case

WITH_SETTINGS = [("study", "paper"), ("simulate",), ("train",), ("evaluate",)]


def flowing(text):
    """A text without its line breaks."""
    return " ".join(text.split())


def test_the_overview_lists_all_commands(dmil):
    text = flowing(dmil("--help"))
    for name, line in COMMANDS.items():
        assert f"{name} {line}" in text
    assert flowing(dmil()) == text
    assert flowing(dmil("-h")) == text


@pytest.mark.parametrize("command", [(name,) for name in COMMANDS] + [("study", "paper")], ids=str)
def test_every_command_explains_itself(command, dmil):
    text = dmil(*command, "--help")
    assert text.startswith(f"Usage: root {' '.join(command)} [OPTIONS]")
    assert max(map(len, text.splitlines())) <= 80
    if command != ("study",):
        assert "--json" in text
    if command[0] not in ("version", "bench"):
        assert f"dmil {' '.join(command)}" in text


def test_the_help_of_settings_is_that_of_their_fields(dmil):
    text = flowing(dmil("study", "paper", "--help"))
    for name in ("seeds", "grids", "horizon_s", "load"):
        assert flowing(PaperStudySettings.model_fields[name].description) in text
    text = flowing(dmil("simulate", "--help"))
    for field in SignalTiming.model_fields.values():
        assert flowing(field.description) in text


@pytest.mark.parametrize("command", WITH_SETTINGS, ids=str)
def test_the_printed_file_is_complete_and_gives_the_same(command, dmil, tmp_path):
    scenario = () if command[0] == "study" else ("--scenario", "grid:2x2", "--clearance", "3")
    text = dmil(*command, *scenario, "--seed" if scenario else "--seeds", "4", "--print-config")
    values = tomllib.loads(text)
    if scenario:
        assert values["timing"] == SignalTiming(clearance_s=3).model_dump()
        assert values["seed"] == 4
    else:
        assert values["dual_memory"]["short_capacity"] == 16
    file = tmp_path / "file.toml"
    file.write_text(text)
    assert dmil(*command, "--config", file, "--print-config") == text
    assert json.loads(dmil(*command, "--config", file, "--print-config", "--json"))["toml"] == text


def test_options_win_over_the_file(dmil, tmp_path):
    file = tmp_path / "file.toml"
    file.write_text(
        'scenario = "grid:1x1"\nseed = 3\n[timing]\nmin_green_s = 20\nclearance_s = 2\n'
        '[controller]\nname = "sarsa"\nshared = true\n'
    )

    def merged(*options):
        return tomllib.loads(dmil("simulate", "--config", file, *options, "--print-config"))

    found = merged("--seed", "5", "--min-green", "30", "--set", "epsilon=0.25")
    assert found["seed"] == 5
    assert found["timing"]["min_green_s"] == 30
    assert found["timing"]["clearance_s"] == 2
    assert found["controller"]["name"] == "sarsa"
    assert found["controller"]["shared"] is True
    assert found["controller"]["epsilon"] == 0.25
    found = merged("--controller", "fixed-cycle", "--set", "green_s=20")
    assert found["controller"] == {"name": "fixed-cycle", "green_s": 20}


def test_several_controllers_have_settings_of_their_own(dmil, tmp_path):
    file = tmp_path / "file.toml"
    file.write_text(
        'scenario = "grid:1x1"\nseeds = 2\njobs = 1\nhorizon_s = 60\nbaselines = false\n'
        '[[controller]]\nname = "fixed-cycle"\ngreen_s = 20\n[[controller]]\nname = "fixed-cycle"\n'
    )
    found = dmil.json("evaluate", "--config", file)
    labels = [each["controller"] for each in found["controllers"]]
    assert set(labels) == {"fixed-cycle,green_s=20", "fixed-cycle"}
    slow, quick = (each["per_seed"]["wait_veh_s"] for each in found["controllers"])
    assert slow != quick
    assert found["controllers"][0]["minus_max-pressure"] == {}
    file.write_text(file.read_text().replace("green_s", "grren_s"))
    dmil("evaluate", "--config", file, code=2)
    assert "Did you mean 'green_s'?" in dmil.err


def test_brackets_in_a_name_are_no_markup(dmil, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    dmil("train", "--scenario", "grid:1x1", "--episodes", 1, "--out", "a [red] policy.npz")
    heading = dmil("simulate", "--policy", "a [red] policy.npz").splitlines()[0]
    assert heading == "a [red] policy.npz on grid:1x1, 300 s, seed 0"


def test_the_scenarios_are_listed_and_described(dmil):
    assert dmil.json("scenarios")["scenarios"] == scenario_names()
    assert all(name in dmil("scenarios") for name in scenario_names())
    found = dmil.json("scenarios", "grid:2x3")
    assert found["intersections"] == 6
    assert found["shapes"] == [{"intersections": 6, "movements": 12, "phases": 8, "symmetries": 4}]
    assert "6 intersections, 12 movements, 8 phases, 4" in dmil("scenarios", "grid:2x3")
    dmil("scenarios", "grid:2", code=2)


def test_controllers_rewards_and_embeddings_are_listed(dmil):
    found = dmil.json("controllers")
    assert found["controllers"].keys() == CONTROLLERS.keys()
    assert found["rewards"].keys() == REWARDS.keys()
    assert found["embeddings"].keys() == EMBEDDINGS.keys()
    text = dmil("controllers")
    assert all(name in text for name in (*CONTROLLERS, *REWARDS, *EMBEDDINGS))


@pytest.mark.parametrize("name", CONTROLLERS)
def test_the_settings_of_a_controller_are_described(name, dmil):
    entry = CONTROLLERS[name]
    text, found = flowing(dmil("controllers", name)), dmil.json("controllers", name)
    assert found["learns"] is entry.learns
    fields = entry.settings.model_fields if entry.settings else {}
    assert [each["name"] for each in found["settings"]] == list(fields)
    # In the table a description is broken into lines of its column.
    assert all(f"{field} =" in text for field in fields)
    assert ("It has no settings." in text) is not bool(fields)


def test_an_unknown_controller_is_an_error(dmil):
    assert "there is no controller" in dmil.json("controllers", "sarsaa", code=2)["error"]
    assert "Did you mean 'sarsa'?" in dmil.err


def test_theory_gives_the_rooms_numbers(dmil):
    choice = ("--actions", 4, "--staged-ratio", 0.25, "--stage-period", 8)
    found = dmil.json("theory", *choice, "--stagings", 3, "--distinct-states", 20)
    worst, best = worst_case(4, 0.25, 8, 3), best_case(4, 8, 20)
    assert found["worst_case"]["zeta1"] == float(worst.zeta1)
    assert found["best_case"]["zeta2"] == float(best.zeta2)
    conditions = check_hyperparameters(4, 0.25, 8, 20)
    assert [each["holds"] for each in found["conditions"]] == [each.holds for each in conditions]
    assert found["failing"] == ["best case before staging", "any trajectory"]
    assert "These settings fail: best case before staging" in flowing(
        dmil("theory", *choice, "--distinct-states", 20)
    )
    assert "meet all conditions" in dmil("theory")
    text = dmil("theory", "--statements")
    assert all(statement.name in text for statement in STATEMENTS)


@pytest.mark.parametrize("ending", ["svg", "png", "pdf", "html"])
def test_theory_is_drawn(ending, dmil, tmp_path):
    file = tmp_path / f"growth.{ending}"
    dmil("theory", "--plot", file, "--distinct-states", 10**6)
    start = {"svg": b"<svg", "png": b"\x89PNG", "pdf": b"%PDF", "html": b"<!DOCTYPE html>"}
    assert file.read_bytes().lstrip().startswith(start[ending])


def test_theory_refuses_other_formats(dmil, tmp_path):
    dmil("theory", "--plot", tmp_path / "growth.doc", code=2)
    assert "expected an ending of .svg" in dmil.err
    assert list(tmp_path.iterdir()) == []


def test_versions_name_what_is_installed(dmil):
    found = dmil.json("version")
    assert {"dmil", "python", "numpy", "numba"} <= found.keys()
    assert isinstance(found["extras"]["ray"], bool)
    assert f"dmil               {found['dmil']}" in dmil("version")
    assert dmil("--version") == f"dmil {found['dmil']}\n"


def test_a_learner_without_training_is_noted(dmil):
    run = ("evaluate", "--scenario", "grid:1x1", "--steps", 60, "--seeds", 2, "--jobs", 1)
    dmil(*run, "--controller", "sarsa")
    assert "sarsa has learned nothing yet and is frozen" in dmil.err
    text = dmil(*run, "--controller", "sarsa", "--learn", "--epsilon", "0.2")
    assert "has learned nothing" not in dmil.err
    assert "Learners: learning, ε = 0.2." in text
    assert "memory entries" in text
    assert "memory entries" not in dmil(*run)


def test_somebody_must_be_judged(dmil):
    dmil("evaluate", "--scenario", "grid:1x1", "--no-baselines", code=2)
    assert "add --controller or --policy" in dmil.err.lower()


@pytest.mark.parametrize("text", ["epsilon", "=3", "epsilon="])
def test_a_setting_needs_a_name_and_a_value(text, dmil):
    dmil("simulate", "--scenario", "grid:1x1", "--set", text, code=2)
    assert f"--set: found '{text}'; expected option=value" in dmil.err


def test_training_needs_a_file_and_a_memory(dmil, tmp_path):
    dmil("train", "--scenario", "grid:1x1", code=2)
    assert "--out: no file for the policy" in dmil.err
    out = tmp_path / "p.npz"
    dmil("train", "--scenario", "grid:1x1", "--controller", "random", "--out", out, code=2)
    assert "there is nothing to train" in dmil.err
    assert not out.exists()


def test_a_study_with_a_failure_ends_with_1(dmil, tmp_path, monkeypatch):
    monkeypatch.setattr("dmil.studies.paper.study.make_controller", fails_for_random)
    arguments = ("--grids", "1x1", "--seeds", 1, "--preset", "literal", "--jobs", 1, "--no-report")
    found = dmil.json("study", "paper", *arguments, "--out", tmp_path / "s", code=1)
    assert found["failed"] == 1
    assert len(found["cells"]) == 51
    assert "1 runs failed, the first (random) with: ValueError: broken" in dmil.err


def fails_for_random(name, options=None, prior=None):
    from dmil.controllers import make_controller

    if name == "random":
        raise ValueError("broken")
    return make_controller(name, options, prior=prior)
