"""Which scenario and which controller: what simulate, train and evaluate share."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

from dmil.cli.parameters import Option, set_option, split
from dmil.controllers import CONTROLLERS, make_settings
from dmil.controllers.variants import Variant, parse_variant
from dmil.demand.arrivals import DEFAULT_BATCH_VEH
from dmil.errors import InputError
from dmil.importing import import_object
from dmil.network.grid import ENTRY_LINK_TIME_S, LINK_TIME_S
from dmil.rewards import PAPER_CONSTANTS, Reward, RewardConstants, make_reward
from dmil.scenarios.demand_changes import DemandChanges, changes_of
from dmil.scenarios.recipe import DynamicsChanges, GridChanges, ScenarioRecipe, TimingChanges
from dmil.training import Policy, load_policy

_DEMAND = "Demand (by default the scenario's own)"
_SIGNALS = "Signals and queues (by default the scenario's own)"


def _numbers(flag: str, example: str) -> Callable[[str], dict[str, str]]:
    """Return what reads an option such as ``E=5,N=5``; whether they are numbers, fields say."""

    def read(text: str) -> dict[str, str]:
        found: dict[str, str] = {}
        for part in split(text):
            key, equals, value = (each.strip() for each in part.rpartition("="))
            if not (key and equals and value):
                raise InputError(
                    f"found '{part}'", where=flag, expected=f"KEY=NUMBER, as {example}"
                )
            if key in found:
                raise InputError(f"'{key}' is given twice", where=flag, expected="one number")
            found[key] = value
        if not found:
            raise InputError(f"found '{text}'", where=flag, expected=f"KEY=NUMBER, as {example}")
        return found

    return read


_RATES, _PROFILE = "E=5,N=5,W=10,S=7", "0=0.5,1800=2,3600=0.5"
DEMAND_OPTIONS = (
    Option("demand.arrivals", "--arrivals", _DEMAND, "poisson|compound"),
    Option(
        "demand.batch_veh",
        "--batch",
        _DEMAND,
        help=f"Mean batch size of compound arrivals in vehicles; by default {DEFAULT_BATCH_VEH:g}.",
    ),
    Option(
        "demand.rate_veh_per_min",
        "--rates",
        _DEMAND,
        "NODE=X,NODE=X",
        read=_numbers("--rates", _RATES),
        help="Vehicles per minute per boundary node or side of a grid, such as "
        f"{_RATES}; nodes not named send none. Also replaces recorded vehicles.",
    ),
    Option(
        "demand.profile",
        "--profile",
        _DEMAND,
        "S=X,S=X",
        read=lambda text: list(_numbers("--profile", _PROFILE)(text).items()),
        help=f"Factor on the rates from each second on, starting at 0, such as {_PROFILE}.",
    ),
    Option("demand.profile_between", "--profile-between", _DEMAND, "step|linear"),
    Option("ties", "--ties", _DEMAND, "straight|coin"),
)
"""How random arrivals differ from a scenario's own."""

SCENARIO_OPTIONS = (
    Option("scenario", "--scenario", "Scenario"),
    Option("roadnet", "--roadnet", "Scenario", "FILE"),
    Option("flow", "--flow", "Scenario", "FILE"),
    Option("net", "--net", "Scenario", "FILE"),
    Option("routes", "--routes", "Scenario", "FILE,FILE"),
    Option("additional", "--additional", "Scenario", "FILE,FILE"),
    Option("begin_s", "--begin", "Scenario"),
    Option("phases", "--phases", "Scenario", "program|derived"),
    Option("routing", "--routing", "Scenario", "sumo|mesoscopic|free-flow"),
    Option("horizon_s", "--steps", "Scenario"),
    Option("load", "--load", "Scenario"),
    Option("resample", "--resample", "Scenario"),
    Option("resample_shift_s", "--resample-shift", "Scenario"),
    Option("calibration", "--calibration", "Scenario", "FILE"),
    *DEMAND_OPTIONS,
    Option("timing.decision_interval_s", "--decision-interval", _SIGNALS),
    Option("timing.clearance_s", "--clearance", _SIGNALS),
    Option("timing.all_red_s", "--all-red", _SIGNALS),
    Option("timing.min_green_s", "--min-green", _SIGNALS),
    Option("timing.max_green_s", "--max-green", _SIGNALS),
    Option("timing.startup_lost_s", "--startup-lost", _SIGNALS),
    Option("dynamics.saturation_flow_veh_per_s", "--saturation-flow", _SIGNALS),
    Option("dynamics.storage", "--storage", _SIGNALS),
    Option("dynamics.vehicle_space_m", "--vehicle-space", _SIGNALS),
    Option("dynamics.gap_wait_s", "--gap-wait", _SIGNALS),
)

SIMULATOR_OPTIONS = (
    Option("simulator", "--simulator", "Simulator"),
    Option("emissions", "--emissions", "Simulator"),
)


class SimulatorChoice(BaseModel):
    """Which simulator runs a scenario."""

    simulator: Literal["queue", "sumo", "sumo-meso"] = Field(
        "queue",
        description="Simulator: queue (the embedded one), sumo (microscopic) or sumo-meso.",
    )
    emissions: bool = Field(
        False, description="Also let SUMO compute emissions and fuel, which takes longer."
    )


class RewardChoice(BaseModel):
    """What a learner gets."""

    reward: str = Field(
        "diffusion",
        description="Reward of learners: default, diffusion, entropy, queue, pressure, or "
        "module:function.",
    )
    reward_constants: RewardConstants = Field(
        PAPER_CONSTANTS, description="Constants of the reward default."
    )

    def make_reward(self) -> Reward:
        """Make it.

        Raises
        ------
        InputError
            If there is none of that name, or it does not have the constants that are given.
        """
        return make_reward(self.reward, self.reward_constants)


def controller_options(many: bool) -> tuple[Option, ...]:
    """Return the options that name a controller and change its settings.

    Parameters
    ----------
    many
        Whether several controllers can be named.
    """
    panel = "Controllers" if many else "Controller"

    def named(given: Any) -> Any:
        return [_named(text) for text in given] if many else _named(given)

    return (
        Option("controller", "--controller", panel, read=named, many=many),
        set_option(
            panel,
            path="changes" if many else "controller",
            help="Setting of the controller, such as embedding=complex or epsilon=0.2 (see 'dmil "
            "controllers NAME').",
            example="grid.link_time_s=3",
        ),
    )


class ControllerChoice(BaseModel):
    """A controller and its options, which stand beside its name."""

    model_config = ConfigDict(frozen=True, extra="allow")

    name: str = Field(
        description="Name (see dmil controllers) or package.module:Class; with options as in "
        "NAME,option=value."
    )

    @model_validator(mode="before")
    @classmethod
    def _named(cls, value: Any) -> Any:
        if isinstance(value, dict) and ":" not in str(value.get("name", ":")):
            return value | {"name": str(value["name"]).lower()}
        return _named(value) if isinstance(value, str) else value

    @property
    def changed(self) -> dict[str, Any]:
        """Its options that are not the defaults."""
        entry = CONTROLLERS.get(self.name)
        usual = entry.settings().model_dump() if entry and entry.settings else {}
        return {k: v for k, v in self.options.items() if k not in usual or usual[k] != v}

    @property
    def label(self) -> str:
        """Its name and the options that are not its defaults, in one word."""
        return Variant(self.name, self.changed).label

    @property
    def options(self) -> dict[str, Any]:
        """Its options."""
        return dict(self.model_extra or {})

    def complete(self) -> ControllerChoice:
        """Return the same with all options of a named controller, defaults included."""
        entry = CONTROLLERS.get(self.name)
        if entry is None or entry.settings is None:
            return self
        where = f"controller '{self.name}'"
        settings = make_settings(entry.settings, self.options, where=where)
        return ControllerChoice(**{"name": self.name, **settings.model_dump()})

    @property
    def meanings(self) -> dict[str, str]:
        """What the options of a named controller mean."""
        entry = CONTROLLERS.get(self.name)
        fields = entry.settings.model_fields if entry and entry.settings else {}
        return {name: field.description or "" for name, field in fields.items()}


def _named(text: str) -> dict[str, Any]:
    variant = parse_variant(text)
    return {"name": variant.name, **variant.options}


def with_scenario_of(recipe: ScenarioRecipe, policy: Policy | None) -> ScenarioRecipe:
    """Return the parts of a scenario, taken from a policy's training if none is named."""
    named = recipe.scenario or recipe.roadnet or recipe.flow or recipe.net or recipe.routes
    if named or policy is None or "recipe" not in policy.training:
        return recipe_of(recipe)
    trained = ScenarioRecipe(**policy.training["recipe"]).model_dump()
    given = recipe_of(recipe).model_dump(exclude_unset=True)
    return ScenarioRecipe(
        **{**trained, **given}
        | {
            table: trained[table] | {k: v for k, v in given.get(table, {}).items() if v is not None}
            for table in ("timing", "dynamics", "grid")
        }
        | {"demand": recipe.demand.over(DemandChanges(**trained["demand"]))}
    )


def recipe_of(settings: ScenarioRecipe) -> ScenarioRecipe:
    """Return the scenario's part of a command's settings."""
    names = settings.model_fields_set & set(ScenarioRecipe.model_fields)
    return ScenarioRecipe(**{name: getattr(settings, name) for name in names})


def files_as_settings(files: Sequence[str]) -> dict[str, Any]:
    """Return which parts of a scenario the files are that stand behind a command.

    Parameters
    ----------
    files
        See `dmil.doctor.read_case`.

    Raises
    ------
    InputError
        If they are not what makes a scenario.
    """
    from dmil.doctor.arguments import SumoFilesGiven, sort_arguments

    given = sort_arguments(files)
    if isinstance(given, SumoFilesGiven):
        if given.configuration is not None:
            named = given.name or f"sumo:{given.configuration}"
            return {"scenario": named}
        found = {"net": given.network, "routes": given.routes, "additional": given.additional}
    elif given.name:
        return {"scenario": f"cityflow:{given.name}" if given.network else given.name}
    else:
        found = {"roadnet": given.network, "flow": given.flow}
    return {name: value for name, value in found.items() if value}


def complete_scenario(settings: ScenarioRecipe) -> dict[str, Any]:
    """Return what a scenario would fill in: horizon, signals, queues, demand, links."""
    if not (settings.scenario or settings.roadnet or settings.net):
        return {}
    grid = settings.grid
    if settings.scenario and settings.scenario.startswith("grid:"):
        usual = {"link_time_s": LINK_TIME_S, "entry_link_time_s": ENTRY_LINK_TIME_S}
        grid = GridChanges(**usual | settings.grid.model_dump(exclude_none=True))
    # Its own demand: what the load makes of it is told by the load.
    made = recipe_of(settings.model_copy(update={"load": 1.0})).build()
    own: Any = made.demand
    return {
        "horizon_s": made.horizon_s,
        "routing": made.sumo.routing if made.sumo else None,
        "timing": TimingChanges(**made.timing.model_dump()),
        "dynamics": DynamicsChanges(**made.dynamics.model_dump()),
        "demand": changes_of(own),
        "ties": getattr(own, "ties", None),
        "grid": grid,
    }


def accepted(controller: str, options: dict[str, Any]) -> dict[str, Any]:
    """Return those of some options that a controller has.

    Parameters
    ----------
    controller
        Its name, or the import path of one of the user's own.
    options
        Such as those that freeze a learner.
    """
    if ":" not in controller and controller not in CONTROLLERS:
        return options  # making it will say that there is no such controller
    if controller in CONTROLLERS:
        settings = CONTROLLERS[controller].settings
        known = set(settings.model_fields) if settings else set()
    else:
        found = import_object(controller, "controller")
        if not callable(found):
            return options  # making it will say so
        parameters = inspect.signature(found).parameters.values()
        if any(parameter.kind is parameter.VAR_KEYWORD for parameter in parameters):
            return options
        known = {parameter.name for parameter in parameters}
    return {name: value for name, value in options.items() if name in known}


def policy_from(path: Path | None) -> Policy | None:
    """Read a policy where one is given."""
    return None if path is None else load_policy(path)
