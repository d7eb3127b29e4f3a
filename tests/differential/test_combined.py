"""The decisions of both memories of lanes against plain Python, over whole runs."""

import numpy as np
import pytest

from dmil.controllers import RunContext, make_controller
from dmil.controllers.lanes.lane_arrivals import DEAD
from dmil.network import grid
from dmil.scenarios import QueueDynamics, Scenario, SignalTiming
from dmil.seeding import stream
from dmil.simulation import DisturbedSimulator, QueueSimulator, Sensors
from dmil.testing.proving_grounds import uneven_network
from tests.differential.plain_combined import PlainCombined
from tests.differential.plain_factored import PlainFactored
from tests.differential.plain_lookahead import PlainLookahead

SLOW = SignalTiming(clearance_s=3, startup_lost_s=1)
STOP = SignalTiming(clearance_s=3, clearance_kind="all-stop")
HASTY = SignalTiming(decision_interval_s=5, clearance_s=2, min_green_s=10, max_green_s=20)
OPTIONS = {
    "as it is": {},
    "weight": {"weight": 0.4},
    "values alone": {"weight": 0.0},
    "groups": {"yields": False, "age": 0.0, "waves": "everywhere"},
    "learning": {"learning": False},
    "seen": {"outside": False, "censored": False},
    "others": {"approaching": False, "guard": False, "rate_step": 0.2},
}


@pytest.fixture(scope="module")
def places(mixed_network, varied, one_lane):
    """Networks and signal timings, and how many vehicles come per second."""
    return {
        "grid:2x2": (grid(2, 2), SignalTiming(), 1.2),
        "all-stop": (grid(2, 2), STOP, 0.9),
        "uneven": (uneven_network(), HASTY, 1.5),
        "stuck": (one_lane(grid(1, 2)), SignalTiming(), 0.8),
        "full": (grid(1, 2), SLOW, 2.0),
        "lanes": (varied(mixed_network, stream(3, "lanes")), SLOW, 1.0),
    }


@pytest.mark.parametrize(
    ("place", "options"),
    [(place, "as it is") for place in ("grid:2x2", "all-stop", "uneven", "stuck", "full", "lanes")]
    + [("lanes", other) for other in list(OPTIONS)[1:]]
    + [("full", other) for other in ("seen", "others")],
)
def test_decisions_and_tables_are_those_of_the_plain_twin(place, options, places, wander):
    network, timing, veh_per_s = places[place]
    # Where lanes fill, vehicles wait unseen behind them.
    dynamics = QueueDynamics(
        saturation_flow_veh_per_s=0.4871, storage=place == "full", vehicle_space_m=27.3
    )
    made = Scenario(place, network, None, timing, dynamics, 15 * timing.decision_interval_s)
    # No round number: half a vehicle would be on the edge of a row.
    chosen = {"expected": 0.2871, **OPTIONS[options]}
    inner, twin = make_controller("combined", chosen), PlainCombined(chosen)
    for episode in range(2):
        simulator = QueueSimulator(made)
        context = RunContext(network, timing, stream(0), dynamics=dynamics)
        inner.reset(context)
        twin.reset(context)
        rng = stream(episode, "vehicles", place)
        seen = simulator.reset(wander(network, made.horizon_s, veh_per_s, rng))
        while seen.time_s < made.horizon_s:
            phases = inner.decide(seen, None)
            assert phases.tolist() == twin.decide(seen).tolist(), f"at {seen.time_s} s"
            seen = simulator.advance(phases)
    assert not chosen.get("outside", True) or (inner._short.outside_veh.any() == (place == "full"))
    assert (len(twin.table) > 10) == (options != "learning")
    arrays = inner.arrays()
    for prefix, table in (("", twin.table), ("model_", twin.model.table)):
        residual = np.zeros_like(arrays[f"{prefix}residual"])
        times = np.zeros_like(arrays[f"{prefix}times"])
        for entry, (*learned, number) in table.items():
            residual[entry] = learned[0] if residual.ndim == 2 else learned
            times[entry] = number
        np.testing.assert_array_equal(arrays[f"{prefix}times"], times)
        found = arrays[f"{prefix}residual"]
        np.testing.assert_allclose(found, residual, rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize("twin", [PlainCombined, PlainFactored, PlainLookahead])
def test_lanes_whose_detectors_die_are_those_of_the_plain_twin(twin, wander):
    name = twin.__name__.removeprefix("Plain").lower()
    network, options = grid(2, 2), {"expected": 0.2871, "recall": True}
    dynamics = QueueDynamics(saturation_flow_veh_per_s=0.4871)
    made = Scenario("dying", network, None, SLOW, dynamics, 1500)
    simulator = DisturbedSimulator(
        QueueSimulator(made), sensors=Sensors(dead_share=0.5, dead_from_s=600)
    )
    inner, plain = make_controller(name, options), twin(options)
    context = RunContext(network, SLOW, stream(0), dynamics=dynamics)
    inner.reset(context)
    plain.reset(context)
    seen = simulator.reset(wander(network, made.horizon_s, 1.5, stream(0, "vehicles")))
    silent = []
    while seen.time_s < made.horizon_s:
        phases = inner.decide(seen, None)
        assert phases.tolist() == plain.decide(seen).tolist(), f"at {seen.time_s} s"
        silent.append(sum(group.silence.dead for group in plain.all_groups()))
        assert silent[-1] == np.count_nonzero(inner._short.silent == DEAD)
        seen = simulator.advance(phases)
    # A lane may be empty for long by chance, too.
    assert max(silent[:55]) <= 1
    assert max(silent[60:]) > 5
