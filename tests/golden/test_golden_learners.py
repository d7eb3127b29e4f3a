"""Small seeded runs with exact numbers: what a change of the learners would change unnoticed.

After a change that is meant to change them: python tests/golden/test_golden_learners.py
"""

import json
from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest

from dmil.controllers import make_controller
from dmil.rewards import REWARDS
from dmil.scenarios import scenario
from dmil.simulation import QueueSimulator
from dmil.training import evaluate, train_prior, vehicles_of_seed

FILE = Path(__file__).with_name("learners.json")
RUNS = {
    f"{name}, {embedding}{', communicating' * communication}": (name, embedding, communication)
    for name in ("sarsa", "dual-memory")
    for embedding in ("exact", "simple", "complex", "complex-scaled", "cells")
    for communication in (False, True)
    if not communication or embedding in ("simple", "complex", "complex-scaled")
}
SEED = 1


def numbers(name, embedding, communication):
    """Run 3×3 for 200 s after 100 s of training; all numbers exact.

    The reward and the update are sums, products and a quotient of doubles, which every machine
    computes alike; so sums of Q are compared to the last bit too.
    """
    reward = REWARDS["diffusion"]
    prior = train_prior(scenario("grid:3x3", horizon_s=100), reward, SEED)
    options = {"embedding": embedding, "communication": communication}
    controller = make_controller(name, options, prior=prior)
    tested = scenario("grid:3x3", horizon_s=200)
    vehicles = vehicles_of_seed(tested, SEED)
    run = evaluate(QueueSimulator(tested), controller, vehicles, reward, SEED)
    arrays = controller.arrays()
    digest = sha256()
    for key in sorted(arrays):
        digest.update(np.ascontiguousarray(arrays[key]).tobytes())
    return {
        "spawned_veh": run.measures.spawned_veh,
        "arrived_veh": run.measures.arrived_veh,
        "wait_veh_s": run.measures.wait_veh_s,
        "entries": [use.entries_total for use in run.memory],
        "msize": run.memory[-1].msize,
        "memory": digest.hexdigest()[:16],
    }


@pytest.mark.parametrize("name", RUNS)
def test_the_run_gives_the_numbers_on_file(name):
    assert numbers(*RUNS[name]) == json.loads(FILE.read_text())[name]


def test_there_is_a_number_for_every_run():
    on_file = json.loads(FILE.read_text())
    assert set(on_file) == set(RUNS)
    # They differ, or they would not tell the learners apart.
    assert len({run["memory"] for run in on_file.values()}) == len(RUNS)


if __name__ == "__main__":
    found = {name: numbers(*run) for name, run in RUNS.items()}
    lines = [f"  {json.dumps(name)}: {json.dumps(run)}" for name, run in found.items()]
    FILE.write_text("{\n" + ",\n".join(lines) + "\n}\n")
