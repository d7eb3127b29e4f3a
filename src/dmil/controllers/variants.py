"""A controller with its options in one word, as ``longest-queue-first,approaching=true``."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from dmil.errors import InputError

_NEXT_OPTION = re.compile(r",(?=[^,=\[\]]*=)")
"""A comma before an option; others belong to a value, such as a list."""


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

    def __hash__(self) -> int:
        return hash((self.name, frozenset(self.options)))

    @property
    def label(self) -> str:
        """The variant in one word, as `parse_variant` reads it."""
        return ",".join([self.name, *(f"{k}={_text(v)}" for k, v in self.options.items())])


def parse_variant(text: str) -> Variant:
    """Read ``NAME,option=value,option=value``; capitals in the name do not matter (ours).

    Whether there is such a controller with such options, `make_controller` says.

    Raises
    ------
    InputError
        The name is missing, or an option has no value or two.
    """
    name, *parts = (part.strip() for part in _NEXT_OPTION.split(text))
    if not name or "=" in name or "," in name:
        raise InputError(
            f"found '{text}'",
            where="controller",
            expected="NAME or NAME,option=value, such as max-pressure,approaching=true",
        )
    # A class of one's own is named as Python writes it.
    return Variant(
        name if ":" in name else name.lower(), read_options(parts, where=f"controller '{name}'")
    )


def read_options(texts: Iterable[str], *, where: str) -> dict[str, Any]:
    """Read options such as ``epsilon=0.2`` (ours).

    Values are read as TOML (numbers, true, false, "text"); anything else is text.

    Parameters
    ----------
    texts
        One option each.
    where
        What they were given to, for errors.

    Raises
    ------
    InputError
        An option has no value, or two different ones.
    """
    found: dict[str, Any] = {}
    for text in texts:
        option, equals, value = (part.strip() for part in text.partition("="))
        if not (option and equals and value):
            raise InputError(
                f"found '{text}'", where=where, expected="option=value, such as epsilon=0.2"
            )
        read = _value(value)
        # Compared as written: nan is not equal to itself.
        if repr(found.setdefault(option, read)) != repr(read):
            raise InputError(f"'{option}' is given twice", where=where, expected="one value")
    return found


def _value(text: str) -> Any:
    if text.lower() in ("true", "false"):
        return text.lower() == "true"
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text


def _text(value: Any) -> str:
    """Return a value as it is read again: text as it stands, unless it would be read otherwise."""
    return value if isinstance(value, str) and _value(value) == value else json.dumps(value)
