"""Search spaces: which options of a controller are tuned, and over which values.

A space is derived from the controller's settings: options with two limits, switches and choices.
The table below, and the catalogue for one controller, give the range of those that have no limits,
or whose limits are wider than makes sense. Left out is what makes a controller another one (its
classes of states, what it sees, how much it may remember) or another experiment.
"""

from __future__ import annotations

import math
import typing
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any, Literal

from annotated_types import Ge, Le
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from dmil.controllers import CONTROLLERS
from dmil.controllers.entry import Choice, Range

Space = dict[str, Range | Choice]

RANGES: dict[str, Range | Choice] = {
    "discount": Range(0.5, 0.99),
    "epsilon": Range(0.005, 0.6, log=True),
    "epsilon_decay": Range(0.9, 1.0),
    "epsilon_last": Range(0.005, 0.2, log=True),
    "exploration_part": Range(0.05, 0.6),
    "green_s": Range(10, 60),
    "hysteresis": Range(0.0, 2.0),
    "learning_rate": Range(0.01, 0.5, log=True),
    "neighbours": Range(1, 50, log=True, whole=True),
    "reward_scale": Range(0.01, 1.0, log=True),
    "short_capacity": Range(4, 128, log=True, whole=True),
    "significance": Range(0.0, 0.5),
    "softening": Range(1e-4, 1e-1, log=True),
    "staged_ratio": Range(0.1, 1.0),
    "steps": Range(1, 30, log=True, whole=True),
    "target_period": Range(100, 2000, log=True, whole=True),
}
"""Ranges of options by name, for every controller that has them."""

NOT_TUNED = {
    "announced",
    "approaching",
    "bootstrap",
    "communication",
    "embedding",
    "epsilon_first",
    "learning",
    "long_capacity",
    "phase",
    "prediction",
    "rates",
    "sent",
    "shared",
    "staging",
    "trigger",
    "unseen",
    "weight_last",
    "width",
}
"""What makes another controller or experiment: name it as a variant, and tune that."""


def search_space(controller: str, fixed: Mapping[str, object] | None = None) -> Space:
    """Return the options of a controller that are tuned, with their values.

    Parameters
    ----------
    controller
        Its name; one of the user's own, given by import path, has no space.
    fixed
        Options that are set and hence not tuned.
    """
    entry = CONTROLLERS.get(controller)
    if entry is None or entry.settings is None:
        return {}
    own = entry.ranges
    space: Space = {}
    for name, field in entry.settings.model_fields.items():
        if name in NOT_TUNED or name in (fixed or {}):
            continue
        found = own[name] if name in own else RANGES.get(name) or _derived(field)
        if found is not None:
            space[name] = found
    return space


def defaults(controller: str, space: Space) -> dict[str, Any]:
    """Return what the options of a space are when nobody sets them."""
    entry = CONTROLLERS.get(controller)
    usual: BaseModel | None = entry.settings() if entry and entry.settings else None
    return {name: getattr(usual, name) for name in space}


def as_json(space: Space) -> dict[str, Any]:
    """Return a space as plain values."""
    return {name: asdict(each) for name, each in space.items()}


def _derived(field: FieldInfo) -> Range | Choice | None:
    """Return the values that the field itself allows, None if they have no ends."""
    if field.annotation is bool:
        return Choice((False, True))
    if typing.get_origin(field.annotation) is Literal:
        return Choice(typing.get_args(field.annotation))
    if field.annotation not in (int, float):
        return None
    low = _limit(field, Ge, "ge")
    high = _limit(field, Le, "le")
    if not (math.isfinite(low) and math.isfinite(high)):
        return None
    return Range(low, high, whole=field.annotation is int)


def _limit(field: FieldInfo, kind: type, name: str) -> float:
    found = [getattr(each, name) for each in field.metadata if isinstance(each, kind)]
    return float(found[0]) if found else math.nan
