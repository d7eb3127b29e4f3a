"""Scenarios: network, demand and signal timing, by name or from files."""

from dmil.scenarios.cityflow import cityflow_scenario
from dmil.scenarios.model import QueueDynamics, Scenario, SignalTiming
from dmil.scenarios.registry import scenario, scenario_names
from dmil.scenarios.sumo import sumo_scenario
from dmil.scenarios.sumo_configuration import SumoConfiguration, read_sumo_configuration
from dmil.scenarios.sumo_files import SumoFiles

__all__ = [
    "QueueDynamics",
    "Scenario",
    "SignalTiming",
    "SumoConfiguration",
    "SumoFiles",
    "cityflow_scenario",
    "read_sumo_configuration",
    "scenario",
    "scenario_names",
    "sumo_scenario",
]
