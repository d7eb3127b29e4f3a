"""Table of simulators by name."""

from __future__ import annotations

from collections.abc import Callable

from dmil.errors import unknown_name
from dmil.scenarios import Scenario
from dmil.simulation.protocol import Simulator
from dmil.simulation.queue import QueueSimulator
from dmil.simulation.sumo import SumoSimulator

SIMULATORS: dict[str, Callable[[Scenario], Simulator]] = {
    "queue": QueueSimulator,
    "sumo": SumoSimulator,
    "sumo-meso": lambda scenario: SumoSimulator(scenario, model="meso"),
}
"""Name to what makes the simulator of a scenario."""


def make_simulator(scenario: Scenario, name: str = "queue") -> Simulator:
    """Make the simulator of a scenario (ours).

    Parameters
    ----------
    scenario
        What to simulate.
    name
        One of `SIMULATORS`.

    Raises
    ------
    UnknownNameError
        If there is no such simulator.
    MissingExtraError
        If it needs SUMO, which is not installed.
    """
    if name not in SIMULATORS:
        raise unknown_name("simulator", name, SIMULATORS)
    return SIMULATORS[name](scenario)
