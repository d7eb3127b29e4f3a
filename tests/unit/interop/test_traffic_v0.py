"""The PettingZoo environments: PettingZoo's own tests, spaces, seeds, actions."""

import contextlib

import numpy as np
import pytest
from pettingzoo.test import api_test, parallel_api_test, parallel_seed_test, seed_test
from pettingzoo.test.state_test import state_test

from dmil import REWARDS, QueueSimulator, evaluate, make_controller, scenario
from dmil.errors import InputError, UnknownNameError
from dmil.interop import ControllerPolicy, env, parallel_env, traffic_v0
from dmil.results.metrics import JUDGED
from dmil.seeding import stream
from dmil.training import vehicles_of_seed

# Agents are called as the intersections are; PettingZoo recommends names such as "player_0".
pytestmark = pytest.mark.filterwarnings("ignore:We recommend agents to be named:UserWarning")


def test_pettingzoos_tests_pass():
    parallel_api_test(parallel_env("grid:2x2"), num_cycles=70)
    parallel_seed_test(lambda: parallel_env("grid:2x2"))
    api_test(env("grid:2x2"), num_cycles=70)
    seed_test(lambda: env("grid:2x2"), num_cycles=20)
    state_test(env("grid:2x2"), parallel_env("grid:2x2"))


def check_closing(made):
    """Closing ends SUMO, and a reset begins anew."""
    actions = {"0,0": 0, "0,1": 0}
    made.reset(seed=0)
    made.step(actions)
    made.close()
    with pytest.raises(InputError, match=r"no run is under way.*Call reset"):
        made.step(actions)
    made.close()
    made.reset(seed=0)
    assert made.step(actions)[4]["0,0"]["time_s"] == 10


def test_parallel_environments_in_sumo_pass_pettingzoos_tests_and_begin_anew():
    pytest.importorskip("libsumo", reason="needs the extra sumo")

    def short():
        return parallel_env("grid:1x2", "sumo", horizon_s=100)

    with short() as made:
        parallel_api_test(made, num_cycles=25)
        check_closing(made)
    parallel_seed_test(short, num_cycles=10)


def test_environments_of_turns_in_the_mesoscopic_model_pass_pettingzoos_tests():
    pytest.importorskip("libsumo", reason="needs the extra sumo")

    def short():
        return env("grid:1x2", "sumo-meso", horizon_s=100)

    with contextlib.closing(short()) as made:
        api_test(made, num_cycles=25)
    seed_test(short, num_cycles=10)


def test_pettingzoos_tests_pass_where_intersections_differ(mixed_scenario):
    parallel_api_test(parallel_env(mixed_scenario), num_cycles=50)
    parallel_seed_test(lambda: parallel_env(mixed_scenario))
    state_test(env(mixed_scenario), parallel_env(mixed_scenario))


@pytest.mark.filterwarnings("ignore:Agents have different observation space sizes:UserWarning")
@pytest.mark.filterwarnings("ignore:Observations are different shapes:UserWarning")
def test_the_aec_test_passes_where_intersections_differ(mixed_scenario):
    api_test(env(mixed_scenario), num_cycles=50)


def test_the_module_follows_pettingzoos_convention():
    assert traffic_v0.parallel_env().possible_agents == parallel_env("grid:3x3").possible_agents
    assert str(traffic_v0.env("grid:1x1")) == "traffic_v0"


def test_agents_are_the_intersections_and_are_truncated_at_the_horizon():
    made = parallel_env("grid:2x2", horizon_s=25)
    ids = ["0,0", "0,1", "1,0", "1,1"]
    assert made.possible_agents == ids
    assert made.agents == []
    made.reset(seed=0)
    assert made.agents == ids
    for expected in (10, 20, 25):
        *_, rewards, terminated, truncated, infos = made.step(dict.fromkeys(ids, 0))
        assert infos["0,1"]["time_s"] == expected
        assert not any(terminated.values())
        assert set(truncated.values()) == {expected == 25}
        assert list(rewards) == ids
    assert made.agents == []
    assert made.possible_agents == ids
    with pytest.raises(InputError, match=r"the episode is over.*Call reset"):
        made.step({})
    made.reset()
    assert made.agents == ids


@pytest.mark.parametrize("simulator", ["queue", "sumo"])
def test_a_seed_brings_the_same_run_as_an_evaluation(simulator):
    if simulator == "sumo":
        pytest.importorskip("libsumo", reason="needs the extra sumo")
    ground = scenario("grid:2x2")
    with parallel_env(ground, simulator, reward="queue") as made:
        made.reset(seed=3)
        policy = ControllerPolicy(made, make_controller("random"))
        totals = dict.fromkeys(made.agents, 0.0)
        while made.agents:
            _, rewards, _, _, infos = made.step(policy.actions())
            totals = {agent: totals[agent] + reward for agent, reward in rewards.items()}
        again = made.episodes.simulator
        vehicles = vehicles_of_seed(ground, 3)
        run = evaluate(again, make_controller("random"), vehicles, REWARDS["queue"], 3)
    known = {name: getattr(run.measures, name) for name in JUDGED}
    known = {name: value for name, value in known.items() if value == value}
    assert "travel_time_s" in known
    for info in infos.values():
        assert info["seed"] == 3
        assert info["measures"] == known
    assert -10 * sum(totals.values()) == sum(info["waited_veh_s"] for info in infos.values())


def test_without_a_seed_episodes_differ_and_follow_from_the_last_seed():
    def seeds(made, first):
        _, infos = made.reset(seed=first)
        found = [infos["0,0"]["seed"]]
        for _ in range(3):
            _, infos = made.reset()
            found.append(infos["0,0"]["seed"])
        return found

    made = parallel_env("grid:1x2")
    first = seeds(made, 7)
    assert first[0] == 7
    assert len(set(first)) == 4
    assert seeds(made, 7) == first
    assert seeds(parallel_env("grid:1x2"), 7) == first
    assert seeds(made, 8)[1:] != first[1:]
    assert seeds(parallel_env("grid:1x2"), None) != seeds(parallel_env("grid:1x2"), None)


def test_spaces_are_of_equal_size_only_when_padded(mixed_scenario):
    own, padded = parallel_env(mixed_scenario), parallel_env(mixed_scenario, padded=True)
    phases = {item.id: len(item.phases) for item in mixed_scenario.network.intersections}
    most = max(phases.values())
    assert min(phases.values()) < most
    assert {agent: int(own.action_space(agent).n) for agent in phases} == phases
    assert {int(padded.action_space(agent).n) for agent in phases} == {most}
    assert len({own.observation_space(agent).shape for agent in phases}) > 1
    assert len({padded.observation_space(agent).shape for agent in phases}) == 1
    _, infos = padded.reset(seed=0)
    for agent, info in infos.items():
        assert info["action_mask"].dtype == np.int8
        assert info["action_mask"].tolist() == [1] * phases[agent] + [0] * (most - phases[agent])


def test_a_padded_phase_that_does_not_exist_is_refused(mixed_scenario):
    made = parallel_env(mixed_scenario, padded=True)
    _, infos = made.reset(seed=0)
    agent = next(name for name, info in infos.items() if not info["action_mask"].all())
    actions = dict.fromkeys(made.agents, 0)
    count = int(infos[agent]["action_mask"].sum())
    with pytest.raises(
        InputError, match=f"'{agent}': the action is {count}.*from 0 to {count - 1}"
    ):
        made.step(actions | {agent: count})
    # Nothing has happened: the next step is the first.
    _, _, _, _, infos = made.step(actions)
    assert infos[agent]["time_s"] == 10


def test_the_mask_tells_what_the_signals_would_overrule(mixed_scenario):
    made = parallel_env(mixed_scenario, load=2)
    rng = stream(4)
    made.reset(seed=1)
    _, infos = made.reset(seed=1)
    seen = dict.fromkeys(made.agents, 0)
    masked = 0
    while made.agents:
        # Long stays, so that the longest green is reached, too.
        actions = {
            agent: int(rng.integers(made.action_space(agent).n))
            if rng.random() < 0.2
            else max(info["phase"], 0)
            for agent, info in infos.items()
        }
        allowed = {agent: infos[agent]["action_mask"][action] for agent, action in actions.items()}
        _, _, _, _, infos = made.step(actions)
        for agent, info in infos.items():
            seen[agent] += not allowed[agent]
            masked += not allowed[agent]
            assert info["overruled"] == seen[agent]
            assert (info["phase"] == actions[agent]) == bool(allowed[agent])
    assert masked > 5
    assert sum(seen.values()) == made.episodes.simulator.measures().overruled


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        ({"0,1": None}, "agent '0,1' has no action"),
        ({"0,9": 0}, "no agent named '0,9'"),
        ({"0,0": 8}, "the action is 8"),
        ({"0,0": -1}, "the action is -1"),
        ({"0,1": 0.5}, "'0,1': the action is 0.5; expected one of its phases, a whole number"),
        ({"0,1": [1, 2]}, r"'0,1': the action is \[1, 2\]"),
        ({"0,1": "left"}, "'0,1': the action is 'left'"),
    ],
)
def test_wrong_actions_are_named(change, problem):
    made = parallel_env("grid:1x2")
    made.reset(seed=0)
    actions = {"0,0": 0, "0,1": 0} | change
    actions = {agent: action for agent, action in actions.items() if action is not None}
    with pytest.raises(InputError, match=problem):
        made.step(actions)


def test_a_step_needs_a_reset():
    with pytest.raises(InputError, match=r"no episode has begun.*Call reset"):
        parallel_env("grid:1x1").state()
    with pytest.raises(InputError, match="Call reset"):
        parallel_env("grid:1x1").step({"0,0": 0})


@pytest.mark.parametrize(
    ("options", "kind"),
    [
        ({"scenario": "grid:x"}, InputError),
        ({"simulator": "quue"}, UnknownNameError),
        ({"reward": "quue"}, UnknownNameError),
        ({"render_mode": "human"}, UnknownNameError),
        ({"horizon_s": 1}, InputError),
    ],
)
def test_wrong_parameters_are_clear_errors(options, kind):
    with pytest.raises(kind, match="expected"):
        parallel_env(**options)


def test_a_reward_that_is_wrong_is_named():
    made = parallel_env("grid:1x2", reward=lambda before, after, network: np.zeros(3))
    made.reset(seed=0)
    with pytest.raises(InputError, match=r"reward at 10 s.*2 intersections"):
        made.step({"0,0": 0, "0,1": 0})


def test_a_simulator_of_ones_own_is_used_and_closed():
    closed = []

    class Own(QueueSimulator):
        def close(self):
            closed.append(True)

    with parallel_env("grid:1x1", Own) as made:
        made.reset(seed=0)
        assert isinstance(made.episodes.simulator, Own)
        assert closed == []
    assert closed == [True]


def test_load_and_horizon_hold_for_names_and_scenarios():
    for ground in ("grid:2x2", scenario("grid:2x2")):
        made = parallel_env(ground, horizon_s=600, load=3)
        made.reset(seed=0)
        assert made.episodes.scenario.horizon_s == 600
        while made.agents:
            made.step(dict.fromkeys(made.agents, 0))
        expected = len(vehicles_of_seed(scenario("grid:2x2", horizon_s=600, load=3), 0))
        assert made.episodes.simulator.measures().spawned_veh == expected


def test_a_picture_needs_its_render_mode():
    made = parallel_env("grid:1x1")
    made.reset(seed=0)
    with pytest.warns(UserWarning, match="render_mode='rgb_array'"):
        assert made.render() is None
