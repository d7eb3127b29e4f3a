"""Controllers by name, and those of users by import path."""

from __future__ import annotations

from collections.abc import Mapping

from pydantic import BaseModel, ValidationError

from dmil.controllers.catalogue import CONTROLLERS
from dmil.controllers.protocol import Controller
from dmil.controllers.tabular.agents import Prior
from dmil.errors import InputError, unknown_name
from dmil.importing import import_object


def check_controller(name: str, *, where: str | None = None) -> None:
    """Check a controller's name; whether an import path leads to one shows when it is made (ours).

    Parameters
    ----------
    name, where
        The name, and the file or option it came from.

    Raises
    ------
    UnknownNameError
        There is no such controller.
    """
    if ":" not in name and name not in CONTROLLERS:
        raise unknown_name("controller", name, CONTROLLERS, where=where)


def make_controller(
    name: str, options: Mapping[str, object] | None = None, *, prior: Prior | None = None
) -> Controller:
    """Make a controller from its name or import path and its options (ours).

    Parameters
    ----------
    name
        A name of `CONTROLLERS`, or ``package.module:Class`` for one of your own: it is called with
        the options as keywords.
    options
        Values for the fields of the controller's settings.
    prior
        What a learner starts from; controllers that have no use for it ignore it.

    Raises
    ------
    InputError
        If there is no such controller or an option is wrong.
    """
    options = dict(options or {})
    if ":" in name:
        return _own_controller(name, options)
    check_controller(name)
    entry = CONTROLLERS[name]
    if entry.settings is None:
        if options:
            raise InputError(
                f"it has no option '{sorted(options)[0]}'",
                where=f"controller '{name}'",
                expected="no options",
            )
        made: Controller = entry.make()
        return made
    settings = make_settings(entry.settings, options, where=f"controller '{name}'")
    made = entry.make(settings, prior=prior) if entry.from_prior else entry.make(settings)
    return made


def make_settings(kind: type[BaseModel], options: Mapping[str, object], *, where: str) -> BaseModel:
    """Validate options into settings, with one clear error (ours).

    Raises
    ------
    InputError
        If an option does not exist or its value cannot be used.
    """
    known = set(kind.model_fields)
    for option in options:
        if option not in known:
            raise unknown_name("option", option, known, where=where)
    try:
        return kind(**options)
    except ValidationError as error:
        first = error.errors()[0]
        raise InputError(
            f"{first['loc'][0]} = {first['input']!r}", where=where, expected=_expected(first["msg"])
        ) from None


def _expected(message: str) -> str:
    for start in ("Input should be ", "Value error, "):
        message = message.removeprefix(start)
    return message


def _own_controller(path: str, options: Mapping[str, object]) -> Controller:
    kind = import_object(path, "controller")
    try:
        made = kind(**options)
    except TypeError as error:
        raise InputError(
            f"it cannot be made ({error})",
            where=f"controller '{path}'",
            expected="a class that takes its options as keywords",
        ) from error
    if not isinstance(made, Controller):
        raise InputError(
            f"{type(made).__name__} lacks the verbs of a controller",
            where=f"controller '{path}'",
            expected="methods reset(context) and decide(observation, reward)",
        )
    return made
