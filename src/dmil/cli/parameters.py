"""Commands made from settings: one class gives the options, their help, and the file's keys."""

from __future__ import annotations

import inspect
import typing
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, TypeVar

import typer
from pydantic import BaseModel

from dmil.cli.configuration import (
    Values,
    as_toml,
    base_type,
    field_at,
    merge,
    nested_value,
    read_file,
    validated,
)
from dmil.cli.options import Config, Debug, Json, PrintConfig
from dmil.cli.terminal import print_json
from dmil.errors import InputError

Model = TypeVar("Model", bound=BaseModel)


@dataclass(frozen=True, slots=True)
class Option:
    """How one field of the settings is given on the command line.

    Parameters
    ----------
    path
        The field, such as ``timing.clearance_s``.
    flag
        The option, such as ``--clearance``.
    panel
        Group of options that it stands in.
    metavar
        What help calls the value.
    read
        Turns the text into the field's value; lists are split at commas by default.
    many
        Whether the option may be repeated.
    default
        What help shows as the default; the field's own by default.
    help
        What help says; the field's description by default.
    """

    path: str
    flag: str
    panel: str
    metavar: str = ""
    read: Callable[[Any], object] | None = None
    many: bool = False
    default: str = ""
    help: str = ""

    @property
    def name(self) -> str:
        """Name of the parameter."""
        return self.flag.removeprefix("--").replace("-", "_")

    def annotation(self, kind: type[BaseModel]) -> Any:
        """Return the type and help that Typer makes an option from."""
        field = field_at(kind, self.path)
        value_type = base_type(field.annotation)
        flag = self.flag
        if value_type is bool:
            flag = f"{flag}/--no-{flag.removeprefix('--')}"
        elif self.many:
            value_type = list[str]
        elif value_type not in (int, float, Path):
            value_type = str
        metavars = {int: "N", float: "X", Path: "PATH", str: "NAME"}
        return Annotated[
            value_type | None,
            typer.Option(
                flag,
                help=self.help or field.description,
                metavar=self.metavar or metavars.get(value_type, "NAME"),
                show_default=self.default or (not self.help and _shown(field.default)),
                rich_help_panel=self.panel,
            ),
        ]

    def value(self, given: Any, kind: type[BaseModel]) -> Any:
        """Return the value of the field for what was typed.

        Raises
        ------
        InputError
            It is an empty list, as where a variable of the shell is not set.
        """
        value = given
        if self.read is not None:
            value = self.read(given)
        elif typing.get_origin(base_type(field_at(kind, self.path).annotation)) is tuple:
            value = given if self.many else split(given)
        if value == []:
            raise InputError(f"found '{given}'", where=self.flag, expected="one name or more")
        return value


def split(text: str) -> list[str]:
    """Split at commas (ours)."""
    return [part.strip() for part in text.split(",") if part.strip()]


def _shown(value: Any) -> str | bool:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, BaseModel):
        return _shown(getattr(value, "name", None))
    if isinstance(value, tuple):
        return ",".join(map(str, value)) or False
    return False if value is None else f"{value:g}" if isinstance(value, float) else str(value)


def settings_command(
    name: str,
    kind: type[Model],
    options: tuple[Option, ...],
    *,
    complete: Callable[[Model], BaseModel] = lambda settings: settings,
) -> Callable[[Callable[[Model, bool], None]], Callable[..., None]]:
    """Turn a function of settings into a command with options, ``--config`` and ``--json`` (ours).

    Parameters
    ----------
    name
        What the command is called.
    kind
        Class of the settings: its fields are the keys of the file.
    options
        Which fields have an option, and how.
    complete
        Fills in for ``--print-config`` what the program would fill in later.
    """

    def decorate(function: Callable[[Model, bool], None]) -> Callable[..., None]:
        def command(**given: Any) -> None:
            file, print_config = given.pop("config"), given.pop("print_config")
            json = given.pop("json")
            del given["debug"]
            settings = _settings(kind, options, given, file)
            if print_config:
                text = as_toml(complete(settings), f"Parameters of: dmil {name}")
                print_json({"toml": text}) if json else typer.echo(text, nl=False)
                return
            function(settings, json)

        shared = {"config": Config, "print_config": PrintConfig, "json": Json, "debug": Debug}
        annotations = {option.name: option.annotation(kind) for option in options} | shared
        defaults = {"print_config": False, "json": False, "debug": False}
        signature = inspect.Signature(
            [
                inspect.Parameter(
                    parameter,
                    inspect.Parameter.KEYWORD_ONLY,
                    default=defaults.get(parameter),
                    annotation=annotation,
                )
                for parameter, annotation in annotations.items()
            ]
        )
        command.__name__ = function.__name__
        command.__doc__ = function.__doc__
        command.__annotations__ = annotations
        command.__signature__ = signature  # type: ignore[attr-defined]
        return command

    return decorate


def _settings(
    kind: type[Model], options: tuple[Option, ...], given: Mapping[str, Any], file: Path | None
) -> Model:
    """Lay the options that were given over the file's values and check them all."""
    values: Values = read_file(file, kind) if file else {}
    places: dict[str, str] = {}
    for option in options:
        typed = given[option.name]
        if typed is not None and typed != []:
            values = merge(values, nested_value(option.path, option.value(typed, kind)))
            places[option.path] = option.flag
    for name, table in values.items():
        default = kind.model_fields[name].default
        if isinstance(table, dict) and isinstance(default, BaseModel):
            values[name] = merge(default.model_dump(exclude_unset=True), table)
    return validated(kind, values, places, str(file) if file else "")
