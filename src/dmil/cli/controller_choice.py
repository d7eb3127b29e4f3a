"""Which controller: what the commands that run some share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, model_validator

from dmil.cli.parameters import Option, set_option
from dmil.controllers import CONTROLLERS, make_settings
from dmil.controllers.variants import Variant, parse_variant
from dmil.errors import InputError
from dmil.experiments.contender import Contender
from dmil.training import Policy, load_policy

DEFAULT_CONTROLLER = "max-pressure"


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
            help="Setting of the controller, such as embedding=complex or epsilon=0.2 (see "
            "'dmil controllers NAME').",
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


Controllers = Annotated[
    tuple[ControllerChoice, ...],
    BeforeValidator(lambda value: value if isinstance(value, list | tuple) else [value]),
]
"""Several of them; a file may name one alone."""


class ControllerOrPolicy(BaseModel):
    """Who runs alone: a controller, or the policy of one."""

    controller: ControllerChoice = Field(
        ControllerChoice(name=DEFAULT_CONTROLLER),
        description="Controller: a name (see dmil controllers) or package.module:Class.",
    )
    policy: Path | None = Field(
        None, description="Policy of a trained controller instead; it runs frozen and greedy."
    )

    def load_policy(self, mend: str = "leave out --policy or --controller") -> Policy | None:
        """Read the policy where one is given.

        Raises
        ------
        InputError
            It cannot be read, or another controller is named, too.
        """
        policy = load_policy(self.policy) if self.policy else None
        if policy and self.controller.name not in (DEFAULT_CONTROLLER, policy.controller):
            raise InputError(
                f"controller '{self.controller.name}' beside a policy of '{policy.controller}'",
                where=str(self.policy),
                expected="one of the two",
                mend=mend,
            )
        return policy

    def contender(self, policy: Policy | None) -> Contender:
        """Return who runs: the policy, frozen, or the controller as it is."""
        choice = self.controller
        if policy and self.policy:
            return Contender.trained(self.policy, policy, choice.options)
        return Contender(choice.label, Variant(choice.name, choice.options))
