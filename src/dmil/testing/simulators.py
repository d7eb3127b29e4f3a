"""Check of a simulator."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from dmil.demand import PoissonDemand, Vehicles
from dmil.demand.destinations import route_graph
from dmil.errors import InputError
from dmil.network import RoadNetwork
from dmil.simulation import Simulator
from dmil.testing.conformance import Witness
from dmil.testing.drives import Drive, PhaseArray, SimulatorRule, made
from dmil.testing.trials import chance

RATE_VEH_PER_MIN = 6.0
SLACK_S = 60
"""Time beyond twice the driving time that a vehicle without red and traffic may take."""


def check_simulator(make: Callable[[], object], vehicles: Vehicles | None = None) -> None:
    """Check a simulator.

    It runs about as many times as its intersections have phases, and a few times more.

    Parameters
    ----------
    make
        Makes a new simulator, always of the same scenario.
    vehicles
        Journeys to drive; by default some arrive at every fringe node, Poisson.

    Raises
    ------
    ConformanceError
        At the first rule that is broken, see `SimulatorRule`.
    """
    witness = Witness(getattr(make, "__qualname__", repr(make)))
    simulator, second = made(make, witness), made(make, witness)
    witness.expect(
        simulator is not second,
        SimulatorRule.FRESH,
        "the same object twice",
        "a new simulator, such as from lambda: MySimulator(scenario)",
    )
    network, horizon_s = simulator.network, simulator.horizon_s
    if vehicles is None:
        vehicles = _vehicles(network, horizon_s)
    phases = _random_phases(simulator)

    first = Drive(simulator, witness, vehicles, "the first run").to_the_end(phases)
    label = "an equal run of a second simulator"
    equal = Drive(second, witness, vehicles, label).to_the_end(phases)
    equal.expect_equal(first, SimulatorRule.REPEAT)
    other = Drive(simulator, witness, vehicles, "a run that is broken off")
    other.to_the_end(np.roll(phases, 1, axis=0)[: len(phases) // 2])
    after_reset = Drive(simulator, witness, vehicles, "a run after a reset").to_the_end(phases)
    after_reset.expect_equal(first, SimulatorRule.RESET)
    _check_refusal(second, witness, vehicles, phases, first)
    _check_red_and_green(simulator, witness, vehicles, phases)
    for drive in (first, equal, other, after_reset):
        drive.expect_untouched()


def _vehicles(network: RoadNetwork, horizon_s: int) -> Vehicles:
    """Draw vehicles from every fringe node that leads to another one."""
    goals = np.diff(route_graph(network).pair_offset)
    rates = {
        node: RATE_VEH_PER_MIN for node, count in zip(network.fringe, goals, strict=True) if count
    }
    return PoissonDemand(rates).vehicles(network, horizon_s, chance("vehicles"))


def _random_phases(simulator: Simulator) -> PhaseArray:
    counts = [len(item.phases) for item in simulator.network.intersections]
    decisions = -(-simulator.horizon_s // simulator.decision_interval_s)
    return chance("phases").integers(0, counts, (decisions, len(counts))).astype(np.int32)


def _check_refusal(
    simulator: Simulator, witness: Witness, vehicles: Vehicles, phases: PhaseArray, model: Drive
) -> None:
    """Check that wrong phases are refused with a clear error and leave the run as it was."""
    drive = Drive(simulator, witness, vehicles, "a run with wrong phases in between")
    drive.advance(phases[0])
    right = phases[0]
    counts = [len(item.phases) for item in simulator.network.intersections]
    # Where there is an own program, -1 asks for it and -2 for its actuated form.
    first = simulator.network.intersections[0]
    none = -3 if first.program or first.own_control else -1
    missing, negative = right.copy(), right.copy()
    missing[-1], negative[0] = counts[-1], none
    wrong = {
        f"phase {counts[-1]} at an intersection with {counts[-1]} phases": missing,
        f"phase {none}": negative,
        "one phase too many": np.append(right, np.int32(0)),
        "phases that are no whole numbers": right + 0.5,
    }
    for name, choice in wrong.items():
        expected = f"a dmil.errors.InputError for {name}"
        try:
            simulator.advance(choice)
        except InputError:
            continue
        except Exception as error:
            witness.fail(SimulatorRule.REFUSAL, f"{type(error).__name__}: {error}", expected)
        witness.fail(SimulatorRule.REFUSAL, "no error", expected)
    drive.to_the_end(phases[1:])
    drive.expect_equal(model, SimulatorRule.REFUSAL)


def _check_red_and_green(
    simulator: Simulator, witness: Witness, vehicles: Vehicles, phases: PhaseArray
) -> None:
    """Show one phase for a whole run to vehicles that all meet red, or that all have green."""
    network = simulator.network
    counts = np.array([len(item.phases) for item in network.intersections])
    crossed = [_crossed(network, vehicles.route(v)) for v in range(len(vehicles))]
    signals = np.array([_signals(network, movements) for movements in crossed])
    swift = vehicles.depart_s + 2 * _driving_s(network, vehicles) + SLACK_S < simulator.horizon_s
    for phase in range(counts.max()):
        shown = np.minimum(phase, counts - 1).astype(np.int32)
        held = np.tile(shown, (len(phases), 1))
        green = np.array([_has_green(network, movements, shown) for movements in crossed])
        runs = [(SimulatorRule.RED, np.flatnonzero(~green), "that all meet red", 0)]
        free = np.flatnonzero(green & swift)
        if free.size:
            most = free[[signals[free].argmax()]]
            runs.append((SimulatorRule.GREEN, most, "that has green all the way", 1))
        for rule, chosen, which, arrive in runs:
            if not chosen.size:
                continue
            label = f"a run with phase {phase} only and {chosen.size} vehicle(s) {which}"
            drive = Drive(simulator, witness, vehicles.take(chosen), label).to_the_end(held)
            arrived = drive.seen[-1][1].arrived_veh
            witness.expect(arrived == arrive, rule, f"{arrived} arrived", f"{arrive}")


def _crossed(network: RoadNetwork, route: PhaseArray) -> list[tuple[int, int]]:
    """Return the (intersection, movement) pairs with signals that a route crosses."""
    known = network.movement_index  # junctions without signals are not in it
    return [known[pair] for pair in pairwise(route.tolist()) if pair in known]


def _signals(network: RoadNetwork, crossed: list[tuple[int, int]]) -> int:
    return sum(j not in network.intersections[i].unsignalled for i, j in crossed)


def _has_green(network: RoadNetwork, crossed: list[tuple[int, int]], shown: PhaseArray) -> bool:
    items = network.intersections
    return all(j in items[i].phases[shown[i]] | items[i].unsignalled for i, j in crossed)


def _driving_s(network: RoadNetwork, vehicles: Vehicles) -> npt.NDArray[np.float64]:
    times_s = network.free_flow_time_s
    return np.array([times_s[vehicles.route(v)].sum() for v in range(len(vehicles))])
