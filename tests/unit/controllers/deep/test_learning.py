"""The deep learners find the best choice of a problem that has a known one."""

import numpy as np
import pytest

from dmil.controllers import RunContext, make_controller
from dmil.scenarios import SignalTiming
from dmil.seeding import stream
from tests.unit.controllers.deep.platoons import Platoons

RUNS, TESTS = range(12), range(100, 103)
OPTIONS = {"training_decisions": 600, "target_period": 40}
GOAL_VEH = 6


def trained(name, problem, **options):
    """Train a controller and return it frozen."""
    options = OPTIONS | options
    to_team, runs = options.pop("to_team", False), options.pop("runs", RUNS)
    learner = make_controller(name, options)
    problem.drive(learner, runs=runs, to_team=to_team)
    return frozen(learner, name, problem, **options)


def frozen(learner, name, problem, **options):
    greedy = make_controller(name, {**options, "learning": False})
    greedy.reset(RunContext(problem.network, SignalTiming(), stream(0)))
    greedy.restore(learner.arrays())
    return greedy


@pytest.mark.parametrize("name", ["dqn", "dqn-prioritised", "vdn"])
def test_the_best_phase_in_every_state_that_occurs(name):
    problem = Platoons(2)
    best, stayed, _ = problem.drive(trained(name, problem), runs=TESTS)
    assert best == 1.0
    assert stayed == 0.0
    chance, stays, _ = problem.drive(make_controller("random"), runs=TESTS)
    assert chance < 0.3
    assert stays > 20


def test_vdn_learns_from_the_teams_reward_what_each_agent_is_to_do():
    """The first agent gets everybody's reward, and each movement needs another phase there.

    Who learns from its own reward alone cannot know what the second agent's choices are worth.
    """
    problem = Platoons(2, alike=False)
    longer = {"runs": range(20), "training_decisions": 1000, "target_period": 50}
    assert problem.drive(trained("vdn", problem, to_team=True, **longer), runs=TESTS)[0] == 1.0
    assert problem.drive(trained("dqn", problem, to_team=True), runs=TESTS)[0] < 0.7


def test_hindsight_keeps_the_worst_queue_within_the_goal():
    problem = Platoons(2)
    options = {"goal_veh": GOAL_VEH}
    greedy = trained("dqn-hindsight", problem, **options)
    assert (problem.drive(greedy, runs=TESTS)[2] <= GOAL_VEH).all()
    *_, worst = problem.drive(make_controller("random"), runs=TESTS)
    assert (worst <= GOAL_VEH).mean() < 0.3


def test_hindsight_learns_about_goals_that_it_never_had():
    problem = Platoons(1)
    learner = make_controller("dqn-hindsight", OPTIONS | {"goal_veh": 0})
    problem.drive(learner, runs=RUNS)
    reached = frozen(learner, "dqn-hindsight", problem, **OPTIONS, goal_veh=12)
    assert (problem.drive(reached, runs=TESTS)[2] <= 12).mean() > 0.9
    without = make_controller("dqn-hindsight", OPTIONS | {"goal_veh": 0, "relabelled": 0})
    problem.drive(without, runs=RUNS)
    unable = frozen(without, "dqn-hindsight", problem, **OPTIONS, goal_veh=12)
    assert (problem.drive(unable, runs=TESTS)[2] <= 12).mean() < 0.6


@pytest.mark.parametrize("name", ["dqn", "dqn-prioritised", "vdn"])
def test_the_horizon_is_no_end(name):
    """Runs of one transition and a reward of −1: Q = −1 − γ − γ² … = −2 for γ = ½, never −1."""
    problem = Platoons(1)
    options = {
        "discount": 0.5,
        "reward_scale": 1.0,
        "target_period": 20,
        "hidden": 8,
        "epsilon_last": 1.0,
    }
    learner = make_controller(name, {**options, "training_decisions": 1000})
    for run in range(600):
        problem.reset(learner, 0, run)
        seen = problem.seen(0)
        learner.decide(seen, None)
        learner.decide(seen, np.array([-1.0]))
    assert np.allclose(learner._values(learner.states(seen)), -2.0, atol=0.25)
