"""Scenarios: network, demand and signal timing, by name or from files."""

from dmil.scenarios.model import QueueDynamics, Scenario, SignalTiming
from dmil.scenarios.registry import scenario

__all__ = ["QueueDynamics", "Scenario", "SignalTiming", "scenario"]
