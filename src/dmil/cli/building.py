"""Making a command's scenario: what its files hold that is not simulated is said at once."""

from __future__ import annotations

from collections.abc import Iterable

from dmil.cli.terminal import say
from dmil.demand.sumo.acting import ACTING
from dmil.demand.sumo.remarks import LEFT_OUT, remarks_of
from dmil.scenarios import Scenario
from dmil.scenarios.recipe import ScenarioRecipe
from dmil.simulation.stand_ins import stand_ins


def built(recipe: ScenarioRecipe) -> Scenario:
    """Make the scenario; say which vehicles are left out, and what does not act on them."""
    made = recipe.build()
    for remark in remarks_of(made.demand):
        if remark.kind in ACTING or remark.kind in LEFT_OUT:
            what = remark.text.partition(";")[0]
            say(f"Warning: {remark.count} {what} (first '{remark.example}').")
    return made


def say_stand_ins(scenario: Scenario, simulator: str, controllers: Iterable[str]) -> None:
    """Say which intersections' own control the queue simulator cannot run.

    Parameters
    ----------
    scenario
        The scenario.
    simulator
        Name of the simulator that is used.
    controllers
        Names of those who run: others than the network's own plan do not need it.
    """
    if simulator == "queue" and "program" in controllers:
        for sentence in stand_ins(scenario.network):
            say(f"Warning: {sentence}.")
