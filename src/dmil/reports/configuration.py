"""The configuration of a study, as its report shows it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any


def configuration_rows(configuration: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return every value of a configuration with its dotted name."""
    return [(name, shown(value)) for name, value in leaves(configuration)]


def find_value(configuration: Mapping[str, Any], name: str, default: Any) -> Any:
    """Return the first value of that name anywhere in a configuration."""
    for key, value in leaves(configuration):
        if key.rsplit(".", 1)[-1] == name:
            return value
    return default


def leaves(value: Any, name: str = "") -> Iterator[tuple[str, Any]]:
    """Yield dotted names and values; lists of plain values are one value."""
    if isinstance(value, Mapping):
        for key, inner in value.items():
            yield from leaves(inner, f"{name}.{key}" if name else str(key))
    elif isinstance(value, list) and any(isinstance(item, Mapping) for item in value):
        for number, inner in enumerate(value):
            yield from leaves(inner, f"{name}.{number}")
    else:
        yield name, value


def shown(value: Any) -> str:
    """Return a value as text: long lists of numbers by their ends."""
    if isinstance(value, list):
        if len(value) > 12 and all(isinstance(item, int) for item in value):
            return f"{value[0]} … {value[-1]} ({len(value)} values)"
        return ", ".join(shown(item) for item in value)
    return "–" if value is None else str(value)
