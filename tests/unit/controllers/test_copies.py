"""Copies of controllers whose kernels are typed once: machine code is not copied."""

import copy
import pickle

import numpy as np
import pytest

from dmil.controllers import RunContext, make_controller
from dmil.scenarios import scenario
from dmil.seeding import stream
from dmil.simulation import QueueSimulator
from dmil.training import vehicles_of_seed

MADE = scenario("grid:2x2", horizon_s=300)


@pytest.mark.parametrize("name", ["factored", "lookahead", "sotl", "gap-out"])
def test_copies_of_a_controller_at_work_go_on_as_it_does(name):
    controller, simulator = make_controller(name), QueueSimulator(MADE)
    controller.reset(RunContext(MADE.network, MADE.timing, stream(0), dynamics=MADE.dynamics))
    seen = simulator.reset(vehicles_of_seed(MADE, 0))
    for _ in range(10):
        seen = simulator.advance(controller.decide(seen, None))
    copies = [copy.deepcopy(controller), pickle.loads(pickle.dumps(controller))]
    chosen = controller.decide(seen, None)
    for each in copies:
        np.testing.assert_array_equal(each.decide(seen, None), chosen)
