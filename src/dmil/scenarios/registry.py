"""Scenarios by name."""

from __future__ import annotations

from dmil.demand import PoissonDemand
from dmil.network import grid
from dmil.scenarios.model import QueueDynamics, Scenario, SignalTiming


def scenario(name: str, *, horizon_s: int = 300) -> Scenario:
    """Return a scenario by its name, such as ``grid:5x5``."""
    rows, columns = name.removeprefix("grid:").split("x")
    return Scenario(
        name,
        grid(int(rows), int(columns)),
        PoissonDemand(),
        SignalTiming(),
        QueueDynamics(),
        horizon_s,
    )
