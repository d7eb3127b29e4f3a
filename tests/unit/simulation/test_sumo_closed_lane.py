"""A lane that an incident closes, in SUMO."""

import importlib.util

import numpy as np
import pytest

from dmil.demand import PoissonDemand
from dmil.errors import InputError
from dmil.scenarios import scenario
from dmil.seeding import stream
from dmil.simulation import ClosedLane, DisturbedSimulator, SumoSimulator

pytestmark = pytest.mark.skipif(
    importlib.util.find_spec("libsumo") is None, reason="needs the extra sumo"
)

MADE = scenario("grid:1x1", horizon_s=600)
VEHICLES = PoissonDemand({"W": 14.0}).vehicles(MADE.network, 600, stream(1, "demand"))
LINK, LANE = "W0>0,0", 1


@pytest.fixture(scope="module")
def simulator():
    made = SumoSimulator(MADE)
    yield made
    made.close()


def courses(simulator):
    """Queue and arrivals of the straight movement from the west, and of its others, over time."""
    item = MADE.network.intersections[0]
    (here,) = [j for j, m in enumerate(item.movements) if (m.from_link, m.lanes) == (LINK, (LANE,))]
    seen = [simulator.reset(VEHICLES, 1)]
    while seen[-1].time_s < simulator.horizon_s:
        seen.append(simulator.advance(np.array([len(seen) // 3 % 4], np.int32)))
    queue = np.array([each.queue_veh[0] for each in seen])
    return queue[:, here], np.delete(queue, here, axis=1).sum(axis=1), simulator.measures()


def test_nobody_leaves_a_closed_lane_until_it_opens(simulator):
    plain, others, free = courses(simulator)
    closed = DisturbedSimulator(simulator, closed=[ClosedLane(LINK, LANE, 100, 400)])
    shut, beside, held = courses(closed)
    assert (np.diff(shut[11:41]) >= 0).all() and shut[40] > 10  # from 110 to 400 s
    assert plain[11:41].min() == 0
    assert np.array_equal(shut[:11], plain[:11])
    assert np.abs(beside - others).max() <= 5
    assert shut[41:].min() < shut[40] - 5
    assert held.delay_s > 1.5 * free.delay_s
    # A later run knows nothing of it.
    again, _, _ = courses(simulator)
    assert np.array_equal(again, plain)


def test_a_lane_that_is_not_there_is_refused(simulator):
    simulator.reset(VEHICLES, 1)
    with pytest.raises(InputError, match="no lane 9 before an intersection"):
        simulator.close_lane(LINK, 9, 100)
