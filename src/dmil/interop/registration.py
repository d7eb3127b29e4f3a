"""Names under which Gymnasium finds the environments."""

from __future__ import annotations

import gymnasium

ENVIRONMENTS: dict[str, dict[str, str]] = {
    "dmil/Queue1x1-v0": {"scenario": "grid:1x1", "simulator": "queue"},
    "dmil/Sumo1x1-v0": {"scenario": "grid:1x1", "simulator": "sumo"},
}
"""The registered names and what they stand for; other parameters go to ``gymnasium.make``."""


def register_environments() -> None:
    """Make the names known to Gymnasium; nothing happens if they are (ours)."""
    for name, options in ENVIRONMENTS.items():
        if name not in gymnasium.registry:
            gymnasium.register(
                name, entry_point="dmil.interop.intersection:IntersectionEnv", kwargs=dict(options)
            )
