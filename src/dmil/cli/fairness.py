"""What a comparison says first where controllers lose less time than the plan beside them."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby

from dmil.controllers import CONTROLLERS
from dmil.scenarios import Scenario
from dmil.scenarios.fairness import advantages

PLANS = tuple(name for name, entry in CONTROLLERS.items() if entry.shows_plan)
"""Controllers that keep the times of the network's own plan, whatever others are given."""
NAMED = 3
"""How many intersections are named."""


def unfair(scenario: Scenario, labels: Sequence[str]) -> str:
    """Return why a comparison with the network's own plan is not fair, else nothing.

    Parameters
    ----------
    scenario
        With the signal timing that controllers keep.
    labels
        Who is compared; a label begins with the controller's name.
    """
    names = {label.partition(",")[0] for label in labels}
    if names.isdisjoint(PLANS) or names <= set(PLANS):
        return ""
    found = groupby(
        advantages(scenario.timing, scenario.network), key=lambda each: each.intersection
    )
    items = scenario.network.intersections
    places = [f"{items[i].id}: {'; '.join(map(str, each))}" for i, each in found]
    if not places:
        return ""
    more = f" … and {len(places) - NAMED} more" if len(places) > NAMED else ""
    return (
        f"NOT A FAIR COMPARISON: at {len(places)} of {len(items)} intersections controllers have "
        f"shorter lost times than the plan ({' | '.join(places[:NAMED])}{more}), so no differences "
        "are shown. Omit --clearance, --all-red and --min-green: then all use the plan's times."
    )
