"""``dmil scenarios``: list scenarios, or describe one."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Annotated, Any

import typer

from dmil.cli.options import Debug, Json, option
from dmil.cli.terminal import entries, print_json, show
from dmil.controllers.tabular.agents import agents_of
from dmil.scenarios import Scenario, scenario_names
from dmil.scenarios.recipe import ScenarioRecipe
from dmil.training import vehicles_of_seed


def scenarios(
    name: Annotated[
        str | None,
        typer.Argument(metavar="[NAME]", help="Scenario to describe.", show_default=False),
    ] = None,
    roadnet: Annotated[
        Path | None,
        option("", "Road network in CityFlow format, with a flow, instead of a name.", "FILE"),
    ] = None,
    flow: Annotated[
        Path | None, option("", "Vehicles in CityFlow format, on that network.", "FILE")
    ] = None,
    json: Json = False,
    debug: Debug = False,
) -> None:
    """List the scenarios, or describe one.

    For example:
        dmil scenarios
        dmil scenarios grid:5x5
        dmil scenarios cityflow:FOLDER

    A scenario is a road network, its demand, its signal timing and the length of a run. The
    description counts intersections by shape: those of one shape can share a memory, and a policy
    fits only the shapes that it was trained on.
    """
    if name is None and roadnet is None and flow is None:
        names = scenario_names()
        if json:
            print_json({"scenarios": names})
        else:
            show(entries(names), "", "Describe one: dmil scenarios grid:5x5")
        return
    recipe = ScenarioRecipe(scenario=name, roadnet=roadnet, flow=flow)
    found = _described(recipe.build())
    if json:
        print_json(found)
    else:
        show(entries({key.replace("_", " "): _text(value) for key, value in found.items()}))


def _described(made: Scenario) -> dict[str, Any]:
    network = made.network
    agents = agents_of(network)
    shapes = [
        {
            "intersections": int(members.size),
            "movements": len(network.intersections[members[0]].movements),
            "phases": len(network.intersections[members[0]].phases),
            "symmetries": group.size,
        }
        for members, group in zip(agents.members, agents.groups, strict=True)
    ]
    vehicles = vehicles_of_seed(made, 0)
    lengths = Counter(link.length_m for link in network.links)
    return {
        "name": made.name,
        "intersections": len(network.intersections),
        "shapes": shapes,
        "links": len(network.links),
        "link_lengths_m": f"{min(lengths):g} to {max(lengths):g}",
        "fringe_nodes": len(network.fringe),
        "horizon_s": made.horizon_s,
        "vehicles_of_seed_0": len(vehicles),
        **made.timing.model_dump(),
        **made.dynamics.model_dump(),
    }


def _text(value: Any) -> str:
    if isinstance(value, list):
        return "\n".join(
            ", ".join(f"{count} {name}" for name, count in each.items()) for each in value
        )
    return {True: "yes", False: "no"}[value] if isinstance(value, bool) else str(value)
