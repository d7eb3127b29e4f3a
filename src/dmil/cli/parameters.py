"""Commands made from settings: one class gives the options, their help, and the file's keys."""

from __future__ import annotations

import inspect
import re
import typing
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, TypeVar

import typer
from pydantic import BaseModel, Field
from pydantic.fields import FieldInfo

from dmil.cli.configuration import (
    Values,
    as_toml,
    base_type,
    checked_field,
    field_at,
    merge,
    nested_value,
    read_file,
    validated,
    with_tables,
    without,
)
from dmil.cli.options import Config, Debug, Json, PrintConfig, Trust
from dmil.cli.terminal import print_json
from dmil.controllers.variants import read_options
from dmil.errors import InputError

SET = "--set"
FILES = Annotated[
    list[str] | None,
    typer.Argument(
        metavar="[FILES]",
        help="A .sumocfg; a .net.xml with its route files; a CityFlow folder or files; or the "
        "name of a scenario. Replaces --scenario, --net etc.",
        show_default=False,
    ),
]
JOBS: Any = Field(
    None, ge=1, description="Parallel processes; by default one per core. Results do not change."
)
"""Field of how many processes work."""
_UNIT = re.compile("_(s|m|veh)$")
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
    assigns
        Whether it reads KEY=VALUE: a key with a dot names any field of the settings, one without a
        field of the table ``path``, or of the settings themselves where that is empty.
    """

    path: str
    flag: str
    panel: str
    metavar: str = ""
    read: Callable[[Any], object] | None = None
    many: bool = False
    default: str = ""
    help: str = ""
    assigns: bool = False

    @property
    def name(self) -> str:
        """Name of the parameter."""
        return self.flag.removeprefix("--").replace("-", "_")

    def annotation(self, kind: type[BaseModel]) -> Any:
        """Return the type and help that Typer makes an option from."""
        field = field_at(kind, self.path) if self.path else FieldInfo()
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

        An `InputError` if it is an empty list, as where a variable of the shell is not set.
        """
        value = given
        if self.read is not None:
            value = self.read(given)
        elif typing.get_origin(base_type(field_at(kind, self.path).annotation)) is tuple:
            value = given if self.many else split(given)
        if value == []:
            raise InputError(f"found '{given}'", where=self.flag, expected="one name or more")
        return value


def options(panel: str, fields: str) -> tuple[Option, ...]:
    """Return options of one group.

    Fields stand with their options where these are not called like the field without its unit, and
    with their metavars where they have one, as in ``load; horizon_s --steps; flow FILE``.
    """
    found = []
    for text in fields.split("; "):
        path, *rest = text.split(" ")
        flag = f"--{_UNIT.sub('', path.rpartition('.')[2]).replace('_', '-')}"
        if rest and rest[0].startswith("--"):
            flag = rest.pop(0)
        found.append(Option(path, flag, panel, rest[0] if rest else ""))
    return tuple(found)


def set_option(panel: str, *, help: str, example: str, path: str = "") -> Option:
    """Return the option ``--set``: keys without a dot belong to the table ``path``.

    By default these are the settings themselves. ``help`` is what is said of such keys; of keys
    with a dot, such as the example with its value, it is said here.
    """
    whole = f"{help} With a dot: any value of --print-config, such as {example}. May be repeated."
    return Option(path, SET, panel, "KEY=VALUE", many=True, help=whole, assigns=True)


def part_of(settings: BaseModel, kind: type[Model]) -> Model:
    """Return the part of a command's settings that is of another class."""
    return kind(**{name: getattr(settings, name) for name in kind.model_fields})


def split(text: str) -> list[str]:
    """Split at commas."""
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
    files: Callable[[Sequence[str]], Mapping[str, Any]] | None = None,
) -> Callable[[Callable[[Model, bool], None]], Callable[..., None]]:
    """Turn a function of settings into a command with options, ``--config`` and ``--json``.

    The fields of the settings are the keys of the file; options say which have one, and how.
    ``complete`` fills in for ``--print-config`` what the program would fill in later; ``files``
    says which fields the files are that stand behind the command, where it takes some.
    """

    def decorate(function: Callable[[Model, bool], None]) -> Callable[..., None]:
        def command(**given: Any) -> None:
            file, print_config = given.pop("config"), given.pop("print_config")
            json = given.pop("json")
            del given["debug"], given["trust"]  # the command line as a whole has been asked
            behind = given.pop("files", None)
            named = dict(files(behind)) if files is not None and behind else {}
            settings = _settings(kind, options, given, file, named)
            if print_config:
                text = as_toml(complete(settings), f"Parameters of: dmil {name}")
                print_json({"toml": text}) if json else typer.echo(text, nl=False)
                return
            function(settings, json)

        annotations: dict[str, Any] = {} if files is None else {"files": FILES}
        annotations |= {option.name: option.annotation(kind) for option in options}
        annotations |= {"trust": Trust, "config": Config}
        flags = {"print_config": PrintConfig, "json": Json, "debug": Debug}
        parameters = [
            inspect.Parameter(
                parameter,
                inspect.Parameter.KEYWORD_ONLY,
                default=False if parameter in flags else None,
                annotation=annotation,
            )
            for parameter, annotation in (annotations | flags).items()
        ]
        command.__name__ = function.__name__
        command.__doc__ = function.__doc__
        command.__annotations__ = annotations | flags
        command.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
        return command

    return decorate


def _settings(
    kind: type[Model],
    options: tuple[Option, ...],
    given: Mapping[str, Any],
    file: Path | None,
    named: Mapping[str, Any],
) -> Model:
    """Lay the files and options that were given over the file's values and check them all."""
    values: Values = with_tables(read_file(file, kind), kind) if file else {}
    values |= named
    places: dict[str, str] = dict.fromkeys(named, "FILES")
    for option in options:
        typed = given[option.name]
        if typed is None or typed == []:
            continue
        if option.assigns:
            assigned = _assigned(option, typed, kind)
        else:
            assigned = {option.path: option.value(typed, kind)}
        for path, value in assigned.items():
            if path in places:
                raise InputError(
                    f"'{path}' is given by {places[path]}, too",
                    where=option.flag,
                    expected="one of the two",
                )
            if isinstance(value, dict) and _is_mapping(kind, path):
                values = without(values, path)  # a file's entries do not stay beside these
            values = merge(values, nested_value(path, value))
            places[path] = f"{option.flag} {path}" if option.assigns else option.flag
    for name, table in values.items():
        default = kind.model_fields[name].default
        if isinstance(table, dict) and isinstance(default, BaseModel):
            values[name] = merge(default.model_dump(exclude_unset=True), table)
    return validated(kind, values, places, str(file) if file else "")


def _is_mapping(kind: type[BaseModel], path: str) -> bool:
    return typing.get_origin(base_type(field_at(kind, path).annotation)) is dict


def _assigned(option: Option, texts: list[str], kind: type[BaseModel]) -> dict[str, Any]:
    """Read what ``--set`` was given as paths of fields, which must exist, and their values."""
    found: dict[str, Any] = {}
    for key, value in read_options(texts, where=option.flag).items():
        if option.path and "." not in key:
            found[f"{option.path}.{key}"] = value
            continue
        field = checked_field(kind, key, where=option.flag)
        listed = typing.get_origin(base_type(field.annotation)) is tuple
        found[key] = split(value) if listed and isinstance(value, str) else value
    return found
