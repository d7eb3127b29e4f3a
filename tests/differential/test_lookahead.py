"""Look-ahead's decisions against plain Python that tries all pairs of phases, over whole runs."""

import numpy as np
import pytest

from dmil.controllers import RunContext, make_controller
from dmil.controllers.lanes.lookahead_choice import lane_model
from dmil.network import grid
from dmil.scenarios import QueueDynamics, Scenario, SignalTiming
from dmil.seeding import stream
from dmil.simulation import QueueSimulator
from dmil.testing.proving_grounds import uneven_network
from tests.differential.plain_lookahead import PlainLookahead, fluid

SLOW = SignalTiming(clearance_s=3, startup_lost_s=1)
STOP = SignalTiming(clearance_s=3, clearance_kind="all-stop")
HASTY = SignalTiming(decision_interval_s=5, clearance_s=2, min_green_s=10, max_green_s=20)
OPTIONS = {
    "as it is": {},
    "depth": {"depth": 1},
    "plan": {"plan": 1.0, "curvature": 0.0},
    "approaching": {"approaching": False},
    "no announcement": {"rounds": 0},
    "wave": {"wave": 0.0, "rounds": 1},
    "learning": {"learning": False},
    "guard": {"guard": False},
    "yields": {"yields": True},
    "age": {"age": 0.05},
    "movements": {"yields": True, "age": 0.025, "waves": "choice", "censored": True},
    "all others": {
        "plan": 0.3,
        "terminal": 0.7,
        "curvature": 0.5,
        "discount": 0.6,
        "later": 0.9,
        "rounds": 2,
        "wave": 2.0,
        "trust": 0.0,
        "queue_trust": 1.0,
        "rate_step": 0.2,
    },
}


@pytest.fixture(scope="module")
def places(mixed_network, varied, one_lane):
    """Networks and signal timings, and how many vehicles come per second."""
    return {
        "grid:2x2": (grid(2, 2), SignalTiming(), 1.2),
        "overloaded": (grid(1, 2), SignalTiming(), 9.0),
        "clearance": (grid(2, 2), SLOW, 0.9),
        "all-stop": (grid(2, 2), STOP, 0.9),
        "uneven": (uneven_network(), HASTY, 1.5),
        "stuck": (one_lane(grid(1, 2)), SignalTiming(), 0.8),
        "lanes": (varied(mixed_network, stream(3, "lanes")), SLOW, 1.0),
    }


PLACES = ["grid:2x2", "overloaded", "clearance", "all-stop", "uneven", "lanes", "stuck"]


# All places as it is; other options where lanes and timing are of all kinds.
@pytest.mark.parametrize(
    ("place", "options"),
    [(place, "as it is") for place in PLACES]
    + [(place, other) for place in ("uneven", "lanes") for other in list(OPTIONS)[1:]]
    + [("grid:2x2", "age"), ("all-stop", "movements")],
)
def test_decisions_and_tables_are_those_of_the_plain_twin(place, options, places, wander):
    network, timing, veh_per_s = places[place]
    # No round number: what finds a gap, and who is left, would be on the edge of a row.
    dynamics = QueueDynamics(saturation_flow_veh_per_s=0.4871)
    made = Scenario(place, network, None, timing, dynamics, 15 * timing.decision_interval_s)
    # No round number: half a vehicle would be on the edge of a row.
    chosen = {"expected": 0.2871, **OPTIONS[options]}
    inner, twin, overruled = make_controller("lookahead", chosen), PlainLookahead(chosen), 0
    for episode in range(2):
        simulator, phases = QueueSimulator(made), None
        context = RunContext(network, timing, stream(0), dynamics=dynamics)
        inner.reset(context)
        twin.reset(context)
        rng = stream(episode, "vehicles", place)
        seen = simulator.reset(wander(network, made.horizon_s, veh_per_s, rng))
        while seen.time_s < made.horizon_s:
            overruled += phases is not None and not np.array_equal(phases, seen.phase)
            phases = inner.decide(seen, None)
            assert phases.tolist() == twin.decide(seen).tolist(), f"at {seen.time_s} s"
            seen = simulator.advance(phases)
    assert (overruled > 0) == (timing is HASTY)
    assert (len(twin.table) >= 10) == (options != "learning")
    arrays = inner.arrays()
    residual, times = np.zeros_like(arrays["residual"]), np.zeros_like(arrays["times"])
    for entry, (cost, end, learned) in twin.table.items():
        residual[entry], times[entry] = (cost, end), learned
    np.testing.assert_array_equal(arrays["times"], times)
    np.testing.assert_allclose(arrays["residual"], residual, rtol=1e-5, atol=1e-5)


def test_the_lane_model_is_the_fluid():
    rng = stream(0, "lanes")
    for queue, arrivals, flow, after_switch in rng.uniform([0, 0, 1, 0], [30, 9, 12, 1], (500, 4)):
        for treatment in range(4):
            found = lane_model(queue, arrivals, flow, treatment, after_switch)
            assert found == pytest.approx(fluid(queue, arrivals, flow, treatment, after_switch))


@pytest.mark.parametrize("treatment", range(4))
def test_the_lane_model_is_the_limit_of_small_steps(treatment):
    queue, arrivals, flow, after_switch, steps = 4.0, 3.0, 8.0, 0.6, 20_000
    green = {0: 0.0, 1: 1.0, 2: after_switch, 3: after_switch}[treatment]
    flow_now = flow / 2 if treatment == 3 else flow
    at, total = queue, 0.0
    for step in range(steps):
        leaves = flow_now if step >= (1 - green) * steps else 0.0
        at = max(0.0, at + (arrivals - leaves) / steps)
        total += at / steps
    found = lane_model(queue, arrivals, flow, treatment, after_switch)
    assert found == pytest.approx((total, at), abs=1e-3)
