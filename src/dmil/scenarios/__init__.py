"""Scenarios: network, demand and signal timing, by name or from files."""

from dmil.scenarios.cityflow import cityflow_scenario
from dmil.scenarios.model import QueueDynamics, Scenario, SumoFiles
from dmil.scenarios.registry import scenario, scenario_names
from dmil.scenarios.sumo import sumo_scenario
from dmil.scenarios.sumo_configuration import SumoConfiguration, read_sumo_configuration
from dmil.scenarios.timing import (
    PLAN,
    SignalTimes,
    SignalTiming,
    UniformTiming,
    lost_s,
    signal_times,
    uniform_timing,
)

__all__ = [
    "PLAN",
    "QueueDynamics",
    "Scenario",
    "SignalTimes",
    "SignalTiming",
    "SumoConfiguration",
    "SumoFiles",
    "UniformTiming",
    "cityflow_scenario",
    "lost_s",
    "read_sumo_configuration",
    "scenario",
    "scenario_names",
    "signal_times",
    "sumo_scenario",
    "uniform_timing",
]
