"""Names under which Gymnasium finds the environments."""

from __future__ import annotations

import gymnasium

SINGLE = {"1x1": "grid:1x1", "Cologne1": "resco/cologne1", "Ingolstadt1": "resco/ingolstadt1"}
"""Scenarios with one intersection, by what they are called in a registered name."""

ENVIRONMENTS: dict[str, dict[str, str]] = {
    f"dmil/{simulator.capitalize()}{called}-v0": {"scenario": scenario, "simulator": simulator}
    for simulator in ("queue", "sumo")
    for called, scenario in SINGLE.items()
}
"""The registered names and what they stand for; other parameters go to ``gymnasium.make``."""


def register_environments() -> None:
    """Make the names known to Gymnasium; nothing happens if they are."""
    for name, options in ENVIRONMENTS.items():
        if name not in gymnasium.registry:
            gymnasium.register(
                name, entry_point="dmil.interop.intersection:IntersectionEnv", kwargs=dict(options)
            )
