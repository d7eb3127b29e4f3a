"""A controller with its options in one word, as ``longest-queue-first,approaching=true``."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from dmil.errors import InputError


@dataclass(frozen=True)
class Variant:
    """A controller with some of its options.

    Parameters
    ----------
    name
        Name of the controller, or ``package.module:Class``.
    options
        Values for the fields of its settings.
    """

    name: str
    options: Mapping[str, Any] = field(default_factory=dict)

    @property
    def label(self) -> str:
        """The variant in one word, as `parse_variant` reads it."""
        return ",".join([self.name, *(f"{k}={_text(v)}" for k, v in self.options.items())])


def parse_variant(text: str) -> Variant:
    """Read ``NAME,option=value,option=value`` (ours).

    Values are read as TOML (numbers, true, false, "text"); anything else is text.

    Raises
    ------
    InputError
        The name is missing, or an option has no value.
    """
    name, *parts = (part.strip() for part in text.split(","))
    if not name or "=" in name:
        raise InputError(
            f"found '{text}'",
            where="controller",
            expected="NAME or NAME,option=value, such as max-pressure,approaching=true",
        )
    options = {}
    for part in parts:
        option, equals, value = (each.strip() for each in part.partition("="))
        if not (option and equals and value):
            raise InputError(
                f"found '{part}'", where=f"controller '{name}'", expected="option=value"
            )
        try:
            options[option] = tomllib.loads(f"value = {value}")["value"]
        except tomllib.TOMLDecodeError:
            options[option] = value
    return Variant(name, options)


def _text(value: Any) -> str:
    return value if isinstance(value, str) else json.dumps(value)
