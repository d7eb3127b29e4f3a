"""The factored memory's decisions against plain Python, over whole runs."""

from dataclasses import replace

import numpy as np
import pytest

from dmil.controllers import RunContext, make_controller
from dmil.network import Junction, Link, Movement, RoadNetwork, grid
from dmil.scenarios import QueueDynamics, Scenario, SignalTiming, scenario
from dmil.seeding import stream
from dmil.simulation import QueueSimulator
from dmil.testing.proving_grounds import uneven_network
from tests.differential.plain_factored import PlainFactored

SLOW = SignalTiming(clearance_s=3, startup_lost_s=1)
STOP = SignalTiming(clearance_s=3, clearance_kind="all-stop")
HASTY = SignalTiming(decision_interval_s=5, clearance_s=2, min_green_s=10, max_green_s=20)
OPTIONS = {
    "as it is": {},
    "approaching": {"approaching": False},
    "rates": {"rates": False},
    "expected": {"expected": 0.0},
    "wave": {"wave": 0.0},
    "no announcement": {"expected": 0.0, "wave": 0.0},
    "learning": {"learning": False},
    "guard": {"guard": False},
    "yields": {"yields": True},
    "age": {"age": 0.05},
    "movements": {"yields": True, "age": 0.025, "waves": "choice"},
    "all others": {
        "expected": 0.937,
        "wave": 1.5,
        "discount": 0.6,
        "vehicle": 3.0,
        "trust": 0.5,
        "trust_veh": 3.0,
        "rate_step": 0.2,
    },
}


def with_junctions(network):
    """Put a junction without signals into the middle of every third link."""
    links, junctions, first = [], [], {}
    for k, link in enumerate(network.links):
        if k % 3:
            links.append(link)
            continue
        halves = [f"{link.id} {part}" for part in "ab"]
        middle, length_m = f"m{k}", link.length_m / 2
        links.append(Link(halves[0], link.start, middle, length_m, 10.0, link.lanes))
        links.append(Link(halves[1], middle, link.end, length_m, 10.0, link.lanes))
        junctions.append(Junction(middle, (Movement(*halves, "straight", 0, (0, 1, 2)),)))
        first[link.id] = halves
    nodes = tuple(
        replace(
            node,
            movements=tuple(
                replace(
                    move,
                    from_link=first.get(move.from_link, [move.from_link])[-1],
                    to_link=first.get(move.to_link, [move.to_link])[0],
                )
                for move in node.movements
            ),
        )
        for node in network.intersections
    )
    return RoadNetwork(
        "junctions", tuple(links), nodes, network.fringe, network.position_m, tuple(junctions)
    )


@pytest.fixture(scope="module")
def places(mixed_network, varied, one_lane):
    """Networks and signal timings, and how many vehicles come per second."""
    return {
        "grid:2x2": (grid(2, 2), SignalTiming(), 1.2),
        "grid:3x3": (grid(3, 3), SignalTiming(), 1.8),
        "overloaded": (grid(1, 2), SignalTiming(), 9.0),
        "clearance": (grid(2, 2), SLOW, 0.9),
        "all-stop": (grid(2, 2), STOP, 0.9),
        "uneven": (uneven_network(), HASTY, 1.5),
        "lanes": (varied(mixed_network, stream(3, "lanes")), SLOW, 1.0),
        "stuck": (one_lane(grid(1, 2)), SignalTiming(), 0.8),
        "junctions": (with_junctions(grid(1, 3)), SignalTiming(startup_lost_s=2), 1.0),
    }


class Both:
    """The controller and its twin, side by side.

    Expected vehicles are weighted by no round number: half of one would be on the edge of a row,
    and rounding would put it on this side or that.
    """

    def __init__(self, options):
        options = {"expected": 0.2871, **options}
        self.inner, self.twin = make_controller("factored", options), PlainFactored(options)
        self.owed_veh = 0.0

    def run(self, made, vehicles):
        simulator = QueueSimulator(made)
        context = RunContext(made.network, made.timing, stream(0), dynamics=made.dynamics)
        self.inner.reset(context)
        self.twin.reset(context)
        seen, overruled, phases = simulator.reset(vehicles), 0, None
        while seen.time_s < made.horizon_s:
            overruled += phases is not None and not np.array_equal(phases, seen.phase)
            phases = self.inner.decide(seen, None)
            assert phases.tolist() == self.twin.decide(seen).tolist(), f"at {seen.time_s} s"
            self.owed_veh = max(self.owed_veh, *self.twin.guard.owed.values())
            seen = simulator.advance(phases)
        return overruled

    def compare_tables(self):
        arrays = self.inner.arrays()
        times = np.zeros_like(arrays["times"])
        residual = np.zeros_like(arrays["residual"])
        for place, entry in self.twin.table.items():
            residual[place], times[place] = entry
        np.testing.assert_array_equal(arrays["times"], times)
        np.testing.assert_allclose(arrays["residual"], residual, rtol=1e-5, atol=1e-5)


PLACES = [
    "grid:2x2",
    "grid:3x3",
    "overloaded",
    "clearance",
    "all-stop",
    "uneven",
    "lanes",
    "stuck",
    "junctions",
]


# All places as the memory is; other options where lanes, junctions and timing are of all kinds.
@pytest.mark.parametrize(
    ("place", "options"),
    [(place, "as it is") for place in PLACES]
    + [(place, other) for place in ("uneven", "lanes", "junctions") for other in list(OPTIONS)[1:]]
    + [("grid:2x2", "age"), ("all-stop", "movements")],
)
def test_decisions_and_tables_are_those_of_the_plain_twin(place, options, places, wander):
    network, timing, veh_per_s = places[place]
    # No round number: what finds a gap, and who is left, would be on the edge of a row.
    dynamics = QueueDynamics(saturation_flow_veh_per_s=0.4871)
    made = Scenario(place, network, None, timing, dynamics, 20 * timing.decision_interval_s)
    both, overruled = Both(OPTIONS[options]), 0
    for episode in range(2):
        rng = stream(episode, "vehicles", place)
        overruled += both.run(made, wander(network, made.horizon_s, veh_per_s, rng))
    both.compare_tables()
    assert (overruled > 0) == (timing is HASTY)
    # Age alone keeps lanes from getting stuck.
    stuck = place == "stuck" or (place == "lanes" and options != "age")
    assert (both.owed_veh > 0) == stuck
    assert (len(both.twin.table) > 10) == (options != "learning")


@pytest.mark.parametrize("timing", [SignalTiming(), SLOW], ids=["paper", "clearance"])
def test_the_twin_agrees_until_the_table_matters(timing):
    """Long enough that what was learned changes phases: it does not always agree with the prior."""
    made = scenario("grid:2x2", horizon_s=3000, timing=timing)
    both = Both({})
    both.run(made, made.demand.vehicles(made.network, made.horizon_s, stream(1, "demand")))
    both.compare_tables()
    frozen = make_controller("factored", {"learning": False})
    assert phases_on(frozen, made) != phases_on(both.inner, made)


def phases_on(controller, made):
    """Return all phases of a short run."""
    simulator, chosen = QueueSimulator(made), []
    controller.reset(RunContext(made.network, made.timing, stream(0), dynamics=made.dynamics))
    vehicles = made.demand.vehicles(made.network, made.horizon_s, stream(2, "demand"))
    seen = simulator.reset(vehicles)
    while seen.time_s < 600:
        chosen.append(controller.decide(seen, None).tolist())
        seen = simulator.advance(np.array(chosen[-1]))
    return chosen
