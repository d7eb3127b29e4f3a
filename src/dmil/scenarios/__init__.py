"""Scenarios: network, demand and signal timing, by name or from files."""

from dmil.scenarios.cityflow import cityflow_scenario
from dmil.scenarios.model import QueueDynamics, Scenario, SignalTiming
from dmil.scenarios.registry import scenario, scenario_names

__all__ = [
    "QueueDynamics",
    "Scenario",
    "SignalTiming",
    "cityflow_scenario",
    "scenario",
    "scenario_names",
]
