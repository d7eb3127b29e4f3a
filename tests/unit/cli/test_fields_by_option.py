"""Demand, links and constants from the command line: options, --set, files, policies."""

import json
import tomllib

import pytest

from dmil.cli.choices import with_scenario_of
from dmil.demand import CompoundPoissonDemand, PoissonDemand, ProfileDemand
from dmil.experiments.tuning import load_tuned
from dmil.rewards import RewardConstants
from dmil.scenarios.recipe import ScenarioRecipe
from dmil.training import load_policy

RUN = ("simulate", "--scenario", "grid:1x1")
PAPER = {"E": 5.0, "N": 5.0, "W": 10.0, "S": 7.0}


@pytest.fixture
def printed(dmil):
    """A function that returns what --print-config prints, as values."""

    def values(*arguments):
        return tomllib.loads(dmil(*arguments, "--print-config"))

    return values


def built(values):
    """The scenario of printed values."""
    fields = ScenarioRecipe.model_fields
    return ScenarioRecipe(**{k: v for k, v in values.items() if k in fields}).build()


@pytest.mark.parametrize(
    "options, demand",
    [
        ((), PoissonDemand()),
        (("--arrivals", "compound"), CompoundPoissonDemand(PAPER, 2.0)),
        (("--arrivals", "compound", "--batch", 3), CompoundPoissonDemand(PAPER, 3.0)),
        (("--rates", "E=3, W0=4"), PoissonDemand({"E": 3.0, "W0": 4.0})),
        (("--ties", "coin"), PoissonDemand(ties="coin")),
        (("--load", 2), PoissonDemand({side: 2 * rate for side, rate in PAPER.items()})),
        (
            ("--profile", "0=0.5,60=2", "--profile-between", "linear"),
            ProfileDemand(PoissonDemand(), [0.0, 60.0], [0.5, 2.0], "linear"),
        ),
        (
            ("--arrivals", "compound", "--set", "demand.batch_probability={1=0.5,4=0.5}"),
            CompoundPoissonDemand(PAPER, {1: 0.5, 4: 0.5}),
        ),
        (("--set", "demand.rate_veh_per_min={E=3}"), PoissonDemand({"E": 3.0})),
        (
            ("--set", "demand.profile=[[0,1],[60,2]]"),
            ProfileDemand(PoissonDemand(), [0.0, 60.0], [1.0, 2.0], "step"),
        ),
    ],
    ids=str,
)
@pytest.mark.parametrize("command", ["simulate", "train", "evaluate", "tune"])
def test_options_make_the_demand_and_the_printed_file_makes_it_again(
    command, options, demand, printed, tmp_path, dmil
):
    text = dmil(command, "--scenario", "grid:1x1", *options, "--print-config")
    assert built(tomllib.loads(text)).demand == demand
    file = tmp_path / "file.toml"
    file.write_text(text)
    assert dmil(command, "--config", file, "--print-config") == text


def test_rates_of_an_option_replace_those_of_a_file(printed, tmp_path):
    file = tmp_path / "file.toml"
    file.write_text("[demand.rate_veh_per_min]\nE = 1\nW = 2\n")
    found = printed(*RUN, "--config", file, "--rates", "N=3")
    assert found["demand"]["rate_veh_per_min"] == {"N": 3.0}
    found = printed(*RUN, "--config", file, "--set", "demand.rate_veh_per_min={S=3}")
    assert found["demand"]["rate_veh_per_min"] == {"S": 3.0}


def test_names_of_nodes_may_hold_anything_in_a_file(dmil, tmp_path):
    rates = "demand.rate_veh_per_min={'a.b:1 c'=3, E=2}"
    text = dmil("study", "paper", "--set", rates, "--print-config")
    found = tomllib.loads(text)["demand"]["rate_veh_per_min"]
    assert found == {"a.b:1 c": 3.0, "E": 2.0}


def test_set_names_any_field(printed):
    options = ("--set", "grid.link_time_s=3", "--set", "timing.clearance_s=2", "--set")
    found = printed(*RUN, *options, "approaching=true", "--set", "controller.hysteresis=0.5")
    assert found["grid"] == {"link_time_s": 3.0, "entry_link_time_s": 0.0}
    assert found["timing"]["clearance_s"] == 2
    assert found["controller"]["approaching"] is True
    assert found["controller"]["hysteresis"] == 0.5
    found = printed(
        "evaluate",
        "--scenario",
        "grid:1x1",
        "--set",
        "epsilon=0.2",
        "--set",
        "dynamics.storage=true",
    )
    assert found["changes"] == {"epsilon": 0.2}
    assert found["dynamics"]["storage"] is True


def test_set_names_any_field_of_a_study(printed):
    options = ("sarsa.learning_rate=0.2", "dual_memory.short_capacity=32", "horizon_s=200")
    options += ("grids=1x1,2x2", "demand.arrivals=compound", "reward_constants.tolerated_veh=5")
    given = [part for option in options for part in ("--set", option)]
    found = printed("study", "paper", *given, "--ties", "coin", "--rates", "E=2")
    assert found["sarsa"]["learning_rate"] == 0.2
    assert found["dual_memory"]["short_capacity"] == 32
    assert found["horizon_s"] == 200
    assert found["grids"] == ["1x1", "2x2"]
    assert found["demand"]["arrivals"] == "compound"
    assert found["demand"]["rate_veh_per_min"] == {"E": 2.0}
    assert found["reward_constants"] == {"relaxation_veh": 1.1, "tolerated_veh": 5.0}
    assert found["ties"] == "coin"
    assert found["grid"] == {"link_time_s": 5.0, "entry_link_time_s": 0.0}
    assert printed("study", "resco", "--set", "sarsa.learning_rate=0.2")["sarsa"][
        "learning_rate"
    ] == pytest.approx(0.2)


@pytest.mark.parametrize(
    "options, said",
    [
        (("--rates", "E=x"), "--rates: found 'x'; expected a number"),
        (("--rates", "E=-1"), "--rates: found '-1'; expected at least 0"),
        (("--rates", "E"), "--rates: found 'E'; expected KEY=NUMBER, as E=5,N=5,W=10,S=7"),
        (("--rates", ""), "--rates: found ''; expected KEY=NUMBER"),
        (("--rates", "E=1,E=2"), "--rates: 'E' is given twice"),
        (("--rates", "X=5"), "there is no fringe node or side named 'X'"),
        (("--batch", 3), "demand: batches are given, but vehicles arrive one by one"),
        (("--arrivals", "poisson", "--batch", 3), "--arrivals and --batch: found"),
        (("--arrivals", "compount"), "Did you mean 'compound'?"),
        (("--ties", "cion"), "--ties: there is no tie named 'cion'"),
        (("--profile", "5=1"), "expected increasing seconds, the first 0"),
        (("--set", "grid.link_tme_s=3"), "--set, table [grid]: there is no key named 'link_tme_s'"),
        (("--set", "grdi.link_time_s=3"), "Did you mean 'grid'?"),
        (("--set", "grid.link_time_s=-3"), "--set grid.link_time_s: found -3; expected at least 0"),
        (("--set", "grid.link_time_s.x=3"), "--set: 'grid.link_time_s' is no table"),
        (("--set", "demand.rate_veh_per_min.E=3"), "'demand.rate_veh_per_min' is no table"),
        (
            ("--set", "timing.clearance_s=3", "--clearance", 4),
            "--set: 'timing.clearance_s' is given by --clearance, too; expected one of the two",
        ),
        (("--set", "reward_constants.tolerated_veh=5"), "but the reward is diffusion"),
        (
            ("--reward", "default", "--set", "reward_constants.tolerated_veh=-5"),
            "--set reward_constants.tolerated_veh: found -5; expected at least 0",
        ),
    ],
    ids=str,
)
def test_what_is_wrong_is_one_error_that_names_the_option(options, said, dmil):
    dmil(*RUN, *options, code=2)
    assert said in " ".join(dmil.err.split())
    assert "Traceback" not in dmil.err


@pytest.mark.parametrize(
    "options, said",
    [
        (("--set", "sarsa.lerning_rate=1"), "--set, table [sarsa]: there is no key named"),
        (("--set", "sarsa=1"), "--set: 'sarsa' is a table; expected one of its values, such as"),
        (("--set", "horizon=1"), "Did you mean 'horizon_s'?"),
        (("--seeds", 3, "--set", "seeds=4"), "--set: 'seeds' is given by --seeds, too"),
        (("--rates", "Q=1"), "demand.rate_veh_per_min on grid:1x1: there is no fringe node"),
        (
            ("--rewards", "entropy", "--set", "reward_constants.tolerated_veh=5"),
            "reward_constants: tolerated_veh is given, but the reward is entropy",
        ),
    ],
    ids=str,
)
def test_a_study_refuses_what_is_wrong_before_it_begins(options, said, dmil, tmp_path):
    dmil("study", "paper", *options, "--out", tmp_path / "study", code=2)
    assert said in " ".join(dmil.err.split())
    assert not (tmp_path / "study").exists()


def test_links_take_as_long_as_is_said(dmil):
    times = [
        dmil.json(*RUN[:2], "grid:1x2", "--set", f"grid.link_time_s={time_s}")["runs"][0]
        for time_s in (0, 60)
    ]
    assert times[0]["spawned_veh"] == times[1]["spawned_veh"]
    assert times[0]["travel_time_s"] + 10 < times[1]["travel_time_s"]


def test_a_policy_brings_its_demand_and_its_constants(dmil, tmp_path):
    path = tmp_path / "policy.npz"
    train = ("train", "--scenario", "grid:1x1", "--episodes", 1, "--reward", "default", "--set")
    train += ("reward_constants.tolerated_veh=5", "--arrivals", "compound", "--batch", 3)
    dmil(*train, "--ties", "coin", "--set", "grid.link_time_s=3", "--out", path)
    policy = load_policy(path)
    assert policy.reward_constants == RewardConstants(tolerated_veh=5)
    recipe = with_scenario_of(ScenarioRecipe(), policy)
    assert recipe.build().demand == CompoundPoissonDemand(PAPER, 3.0, "coin")
    assert recipe.grid.link_time_s == 3.0
    changed = with_scenario_of(ScenarioRecipe(demand={"arrivals": "poisson"}), policy)
    assert changed.build().demand == PoissonDemand(PAPER, "coin")
    # Evaluated where it was trained, unless something else is said.
    evaluate = ("evaluate", "--policy", path, "--seeds", 1, "--jobs", 1, "--no-baselines")
    batches = ("--arrivals", "compound", "--batch", 3, "--ties", "coin")
    same = dmil.json(*evaluate)["controllers"][0]["per_seed"]
    named = dmil.json(*evaluate, "--scenario", "grid:1x1", *batches)["controllers"][0]["per_seed"]
    other = dmil.json(*evaluate, "--arrivals", "poisson")["controllers"][0]["per_seed"]
    assert same["spawned_veh"] == named["spawned_veh"] != other["spawned_veh"]
    # It goes on with its own constants, and with no others.
    dmil("train", "--resume", path, "--episodes", 2)
    assert load_policy(path).reward_constants == RewardConstants(tolerated_veh=5)
    dmil("train", "--resume", path, "--set", "reward_constants.tolerated_veh=6", code=2)
    assert "reward_constants differs from that of the policy" in dmil.err
    dmil("simulate", "--policy", path, "--set", "reward_constants.tolerated_veh=6", code=2)
    assert "the policy brings its own" in dmil.err


def test_other_constants_teach_something_else(dmil, tmp_path):
    def learned(*options):
        path = tmp_path / f"{len(options)}.npz"
        train = (
            "train",
            "--scenario",
            "grid:1x1",
            "--load",
            3,
            "--controller",
            "dual-memory",
            "--episodes",
            2,
        )
        dmil(*train, "--reward", "default", *options, "--out", path)
        return {name: array.tobytes() for name, array in load_policy(path).arrays.items()}

    usual = learned()
    assert usual == learned("--set", "reward_constants.tolerated_veh=10")
    assert usual != learned("--set", "reward_constants.tolerated_veh=0.5", "--prior")


def test_a_tuning_keeps_the_constants(dmil, tmp_path):
    budget = ("--budget", 170, "--seeds", 18, "--check-seeds", 2, "--episodes", 1, "--steps", 40)
    tune = ("tune", "--scenario", "grid:1x1", "--controller", "sarsa", *budget, "--jobs", 1)
    constants = ("--reward", "default", "--set", "reward_constants.tolerated_veh=5")
    dmil(*tune, *constants, "--arrivals", "compound", "--out", tmp_path)
    tuned = load_tuned(tmp_path / "sarsa.json")
    assert tuned.reward_constants == RewardConstants(tolerated_veh=5)
    assert tuned.recipe["demand"] == {"arrivals": "compound"}
    policy = tmp_path / "policy.npz"
    train = ("train", "--tuned", tmp_path / "sarsa.json", "--scenario", "grid:1x1")
    dmil(*train, "--episodes", 1, "--out", policy)
    assert load_policy(policy).reward_constants == RewardConstants(tolerated_veh=5)


def test_a_study_keeps_what_it_was_and_its_runs_differ(dmil, tmp_path):
    study = ("study", "paper", "--grids", "1x1", "--seeds", 1, "--preset", "literal", "--steps", 60)
    study += ("--rewards", "default", "--jobs", 1, "--no-report", "--json")
    options = ("--arrivals", "compound", "--ties", "coin", "--set", "timing.decision_interval_s=5")
    options += ("--set", "reward_constants.tolerated_veh=0.5", "--set", "grid.link_time_s=3")
    plain = json.loads(dmil(*study, "--out", tmp_path / "plain"))
    other = json.loads(dmil(*study, *options, "--out", tmp_path / "other"))
    assert other["failed"] == 0
    assert plain["cells"] != other["cells"]
    told = json.loads((tmp_path / "other" / "manifest.json").read_text())["configuration"]
    assert told["demand"]["arrivals"] == "compound"
    assert told["ties"] == "coin"
    assert told["reward_constants"]["tolerated_veh"] == 0.5
    assert told["grid"]["link_time_s"] == 3.0
    assert told["timing"]["decision_interval_s"] == 5
    dmil(*study, "--ties", "coin", "--out", tmp_path / "plain", code=2)
    assert "it holds another study, with other ties" in dmil.err


def test_options_go_over_a_controller_that_a_file_names_in_one_word(dmil, tmp_path):
    file = tmp_path / "c.toml"
    file.write_text('controller = "dual-memory"\nscenario = "grid:1x1"\nhorizon_s = 60\n')
    found = dmil.json("simulate", "--config", file, "--set", "epsilon=0.3")
    assert found["controller"] == "dual-memory,epsilon=0.3"


def test_a_policy_keeps_the_classes_that_it_was_trained_with(dmil, tmp_path):
    policy = tmp_path / "p.npz"
    scenario = ("--scenario", "grid:1x1", "--steps", 60)
    train = ("--episodes", 1, "--set", "embedding=complex-scaled")
    dmil("train", *scenario, "--controller", "dual-memory", *train, "--out", policy)
    for change in ("embedding=exact", "tolerance=2", "scale_levels=3", "announced=true"):
        dmil("simulate", "--policy", policy, "--set", change, code=2)
        assert "for a policy that was trained with" in dmil.err
        assert change.split("=")[0] in dmil.err
    for change in ("embedding=complex-scaled", "epsilon=0.1"):
        dmil("simulate", "--policy", policy, "--set", change)


@pytest.mark.parametrize(
    ("change", "where"),
    [
        ("sarsa.embedding=complex", "--set sarsa.embedding: sarsa.embedding is set by the study"),
        ("no_memory_embedding=complex-scaled", "--set no_memory_embedding: no_memory_embedding is"),
    ],
)
def test_a_check_of_several_values_names_the_option(dmil, tmp_path, change, where):
    dmil("study", "paper", "--set", change, "--out", tmp_path / "s", code=2)
    assert where in dmil.err
    assert "PosixPath" not in dmil.err


def test_not_a_number_is_no_number_given_twice(dmil):
    dmil("simulate", "--scenario", "grid:1x1", "--set", "grid.link_time_s=nan", code=2)
    assert "expected a finite number" in dmil.err
