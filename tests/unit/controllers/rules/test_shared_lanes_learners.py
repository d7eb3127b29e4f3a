"""The guard for shared lanes overrules learners: none of them leaves anybody behind for ever."""

from pathlib import Path

import numpy as np
import pytest

from dmil.controllers import CONTROLLERS, make_controller
from dmil.controllers.rules.shared_lanes import SharedLaneGuard, replace_phases
from dmil.controllers.variants import parse_variant
from dmil.network import grid
from dmil.rewards import make_reward
from dmil.scenarios.recipe import ScenarioRecipe
from dmil.seeding import stream
from dmil.simulation import make_simulator
from dmil.training import evaluate, vehicles_of_seed
from tests.unit.controllers.rules.test_shared_lanes import EW_F, context, movements, see

CASE = Path(__file__).parents[3] / "cases" / "factored-stuck"
TABULAR = ["sarsa,epsilon=0.05", "dual-memory,embedding=complex,epsilon=0.05"]
EPISODIC = ["mfec,epsilon_first=0.05", "plmp,epsilon_first=0.05"]
DEEP = ["dqn,epsilon_first=0.05", "nec,epsilon_first=0.05", "vdn,epsilon_first=0.05"]


@pytest.fixture(scope="module")
def stuck():
    """One lane a side and a phase for left turns; arrivals of a controller, by its label."""
    pytest.importorskip("sumolib", reason="needs the extra sumo")
    recipe = ScenarioRecipe(net=CASE / "net.net.xml", routes=(CASE / "r.rou.xml",), horizon_s=900)
    return arrivals(recipe.build())


def arrivals(scenario):
    vehicles, simulator = vehicles_of_seed(scenario, 0), make_simulator(scenario, "queue")

    def arrived(label):
        variant = parse_variant(label)
        controller = make_controller(variant.name, variant.options)
        done = evaluate(simulator, controller, vehicles, make_reward("diffusion"), 0)
        return done.measures.arrived_veh

    return arrived


def test_every_learner_has_a_guard_by_default():
    """Of the catalogue: what is added to it later has one, too."""
    for name, entry in CONTROLLERS.items():
        if entry.learns:
            assert entry.settings.model_fields["guard"].default is True, name


@pytest.mark.parametrize("label", [*TABULAR, *EPISODIC, *DEEP])
def test_learners_bring_as_many_as_the_plan_and_more_than_as_published(label, stuck):
    if label in DEEP:
        pytest.importorskip("torch", reason="needs the extra deep")
    plan, guarded, published = map(stuck, ("program", label, f"{label},guard=false"))
    assert guarded >= plan
    assert guarded > published


@pytest.mark.parametrize("label", ["gap-out", "sotl"])
def test_rules_that_serve_everybody_in_turn_need_no_guard(label, stuck):
    assert stuck(label) >= stuck("program")


@pytest.mark.parametrize("label", [*TABULAR, *EPISODIC])
def test_where_no_lanes_are_shared_learners_do_as_published(label):
    arrived = arrivals(ScenarioRecipe(scenario="grid:2x2", horizon_s=600, load=2.0).build())
    assert arrived(label) == arrived(f"{label},guard=false")


def test_a_choice_stands_until_a_lane_was_stuck(one_lane):
    crossing = one_lane(grid(1, 1))
    guard, (node,) = SharedLaneGuard(context(crossing)), crossing.intersections
    stuck = see(crossing, EW_F, straight=9, left=2)
    chosen = np.array([EW_F], np.int32)
    for _ in range(2):
        guard.overrule(stuck, chosen)
        assert chosen.tolist() == [EW_F]  # owed nothing yet, then less than it could serve
    for _ in range(20):
        guard.overrule(stuck, chosen)
    assert chosen.tolist() != [EW_F]
    assert set(movements(crossing, "left")) & node.phases[chosen[0]]


def test_a_phase_is_replaced_as_by_plain_python():
    rng = stream(0, "overruled")
    for _ in range(50):
        served = rng.random((6, 4, 5)) < 0.5
        queue, owed = rng.integers(0, 6, (6, 5)).astype(np.int32), 6 * rng.random((6, 5))
        evidence = np.where(rng.random(6) < 0.3, 0.0, rng.random(6))
        phases = rng.integers(0, 4, 6).astype(np.int32)
        expected = []
        for i, chosen in enumerate(phases):
            due = [owed[i, served[i, q]].sum() for q in range(4)]
            most = int(np.argmax(due))
            could = due[chosen] + queue[i, served[i, chosen]].sum()
            replaced = evidence[i] > 0 and due[most] > could
            expected.append(most if replaced else chosen)
        replace_phases(served, queue, owed, evidence, phases)
        assert phases.tolist() == expected
