"""Table of simulators by name."""

from __future__ import annotations

from collections.abc import Callable

from dmil.errors import InputError, unknown_name
from dmil.scenarios import Scenario
from dmil.simulation.cityflow import CityflowSimulator
from dmil.simulation.protocol import Simulator
from dmil.simulation.queue import QueueSimulator
from dmil.simulation.sumo import SumoSimulator

SIMULATORS: dict[str, Callable[[Scenario, bool], Simulator]] = {
    "queue": lambda scenario, emissions: QueueSimulator(scenario),
    "sumo": lambda scenario, emissions: SumoSimulator(scenario, emissions=emissions),
    "sumo-meso": lambda scenario, emissions: SumoSimulator(
        scenario, model="meso", emissions=emissions
    ),
    "cityflow": lambda scenario, emissions: CityflowSimulator(scenario),
}
"""Name to what makes the simulator of a scenario, told whether emissions are wanted."""


def make_simulator(
    scenario: Scenario, name: str = "queue", *, emissions: bool = False
) -> Simulator:
    """Make the simulator of a scenario (ours).

    Parameters
    ----------
    scenario
        What to simulate.
    name
        One of `SIMULATORS`.
    emissions
        Whether SUMO shall compute emissions and fuel, too.

    Raises
    ------
    UnknownNameError
        If there is no such simulator.
    InputError
        If emissions, or vehicles that block a junction, are asked of a simulator that knows none,
        or CityFlow is not installed.
    MissingExtraError
        If it needs SUMO, which is not installed.
    """
    if name not in SIMULATORS:
        raise unknown_name("simulator", name, SIMULATORS)
    for where, asked, what in (
        ("emissions", emissions, "emissions"),
        (
            "ignore_junction_blocker_s",
            scenario.ignore_junction_blocker_s is not None,
            "vehicles that block a junction",
        ),
    ):
        if asked and name in ("queue", "cityflow"):
            raise InputError(
                f"the simulator {name} knows no {what}",
                where=where,
                mend="use SUMO (--simulator sumo), or leave it",
            )
    return SIMULATORS[name](scenario, emissions)
