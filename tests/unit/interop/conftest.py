"""A scenario whose intersections differ, and whose signals refuse to change too soon."""

import pytest

from dmil.demand import PoissonDemand
from dmil.scenarios import QueueDynamics, Scenario, SignalTiming


@pytest.fixture(scope="session")
def mixed_scenario(mixed_network) -> Scenario:
    timing = SignalTiming(decision_interval_s=10, clearance_s=3, min_green_s=15, max_green_s=60)
    return Scenario("mixed", mixed_network, PoissonDemand(), timing, QueueDynamics(), 200)
