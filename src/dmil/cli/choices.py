"""Which scenario and which controller: what simulate, train and evaluate share."""

from __future__ import annotations

import inspect
from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

from dmil.cli.parameters import Option
from dmil.controllers import CONTROLLERS, make_settings
from dmil.controllers.variants import Variant, parse_variant, read_options
from dmil.importing import import_object
from dmil.scenarios.recipe import DynamicsChanges, ScenarioRecipe, TimingChanges
from dmil.training import Policy, load_policy

_SIGNALS = "Signals and queues (by default the scenario's own)"
SCENARIO_OPTIONS = (
    Option("scenario", "--scenario", "Scenario"),
    Option("roadnet", "--roadnet", "Scenario", "FILE"),
    Option("flow", "--flow", "Scenario", "FILE"),
    Option("net", "--net", "Scenario", "FILE"),
    Option("routes", "--routes", "Scenario", "FILE,FILE"),
    Option("begin_s", "--begin", "Scenario"),
    Option("phases", "--phases", "Scenario", "program|derived"),
    Option("routing", "--routing", "Scenario", "sumo|free-flow"),
    Option("horizon_s", "--steps", "Scenario"),
    Option("load", "--load", "Scenario"),
    Option("calibration", "--calibration", "Scenario", "FILE"),
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
        False, description="Let SUMO compute emissions and fuel, too, which takes longer."
    )


REWARD = "What a learner gets: default, diffusion, entropy, queue, pressure, or module:function."


def controller_options(many: bool) -> tuple[Option, ...]:
    """Return the options that name a controller and change its settings (ours).

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
        Option(
            "changes" if many else "controller",
            "--set",
            panel,
            "KEY=VALUE",
            read=assignments,
            many=True,
            help="Setting of the controller, such as embedding=complex or epsilon=0.2; may be "
            "repeated. 'dmil controllers NAME' lists them.",
        ),
    )


class ControllerChoice(BaseModel):
    """A controller and its options, which stand beside its name."""

    model_config = ConfigDict(frozen=True, extra="allow")

    name: str = Field(
        description="Name (see dmil controllers), or package.module:Class; with options as in "
        "NAME,option=value."
    )

    @model_validator(mode="before")
    @classmethod
    def _named(cls, value: Any) -> Any:
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
        """Return the same with all options of a named controller, defaults included (ours)."""
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


def assignments(texts: list[str]) -> dict[str, Any]:
    """Read options such as ``epsilon=0.2`` (ours).

    Raises
    ------
    InputError
        If there is no ``=``.
    """
    return read_options(texts, where="--set")


def with_scenario_of(recipe: ScenarioRecipe, policy: Policy | None) -> ScenarioRecipe:
    """Return the parts of a scenario, taken from a policy's training if none is named (ours)."""
    named = recipe.scenario or recipe.roadnet or recipe.flow or recipe.net or recipe.routes
    if named or policy is None or "recipe" not in policy.training:
        return recipe_of(recipe)
    trained = ScenarioRecipe(**policy.training["recipe"]).model_dump()
    given = recipe_of(recipe).model_dump(exclude_unset=True)
    return ScenarioRecipe(
        **{**trained, **given}
        | {
            table: trained[table] | {k: v for k, v in given.get(table, {}).items() if v is not None}
            for table in ("timing", "dynamics")
        }
    )


def recipe_of(settings: ScenarioRecipe) -> ScenarioRecipe:
    """Return the scenario's part of a command's settings (ours)."""
    names = settings.model_fields_set & set(ScenarioRecipe.model_fields)
    return ScenarioRecipe(**{name: getattr(settings, name) for name in names})


def complete_scenario(settings: ScenarioRecipe) -> dict[str, Any]:
    """Return what a scenario would fill in: horizon, signal timing, queue dynamics (ours)."""
    if not (settings.scenario or settings.roadnet or settings.net):
        return {}
    made = recipe_of(settings).build()
    return {
        "horizon_s": made.horizon_s,
        "routing": made.sumo.routing if made.sumo else None,
        "timing": TimingChanges(**made.timing.model_dump()),
        "dynamics": DynamicsChanges(**made.dynamics.model_dump()),
    }


def accepted(controller: str, options: dict[str, Any]) -> dict[str, Any]:
    """Return those of some options that a controller has (ours).

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
    """Read a policy where one is given (ours)."""
    return None if path is None else load_policy(path)
