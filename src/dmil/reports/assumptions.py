"""What is not the paper's, with the values that this run used."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from dmil.interpretations import INTERPRETATIONS, MEANING, Interpretation

#: What the report lists: all that the paper does not state.
_ORDER = ("F", "A", "corrected", "ours")


@dataclass(frozen=True, slots=True)
class Assumption:
    """One choice that is not the paper's.

    Parameters
    ----------
    kind
        "fitted", "assumed", "corrected" or "ours".
    topic, meaning, paper
        Of which part of the system; what was chosen; what the paper says of it.
    value
        What holds in this study.
    """

    kind: str
    topic: str
    meaning: str
    paper: str
    value: str


def assumptions(configuration: Mapping[str, Any]) -> list[Assumption]:
    """List all that was fitted, assumed, corrected or added, fitted first (ours).

    It is the table that docs/paper.md and the marks of the settings come from, with the values of
    this study where they are not those of the table.

    Parameters
    ----------
    configuration
        ``configuration`` of a manifest; settings that it lacks have their defaults.
    """
    used = list(_leaves(configuration))
    listed = [each for each in INTERPRETATIONS if each.mark in _ORDER]
    return [
        Assumption(MEANING[each.mark], each.topic, each.what, each.paper, _in_this_run(each, used))
        for each in sorted(listed, key=lambda each: _ORDER.index(each.mark))
    ]


def configuration_rows(configuration: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return every value of a configuration with its dotted name (ours)."""
    return [(name, _text(value)) for name, value in _leaves(configuration)]


def find_value(configuration: Mapping[str, Any], name: str, default: Any) -> Any:
    """Return the first value of that name anywhere in a configuration (ours)."""
    for key, value in _leaves(configuration):
        if key.rsplit(".", 1)[-1] == name:
            return value
    return default


def _in_this_run(each: Interpretation, used: list[tuple[str, Any]]) -> str:
    """Say what holds, and the value of its setting in this run."""
    found = [(name, value) for name, value in used if _is(name, each.setting)]
    values = list(dict.fromkeys(_text(value) for _, value in found if value is not None))
    if not each.setting or not values:
        return each.here
    if len(values) > 1:
        values = [f"{_place(name)} {_text(value)}" for name, value in found]
    return f"{each.here}. In this run: {', '.join(values)}"


def _is(name: str, setting: str) -> bool:
    return (bool(setting) and f".{name}".endswith(f".{setting}")) or f".{setting}." in f".{name}"


def _place(name: str) -> str:
    """Return the part of a dotted name that tells equal settings apart: a preset, an agent."""
    parts = name.split(".")
    return parts[-2] if len(parts) > 1 else parts[-1]


def _leaves(value: Any, name: str = "") -> Iterator[tuple[str, Any]]:
    """Yield dotted names and values; lists of plain values are one value."""
    if isinstance(value, Mapping):
        for key, inner in value.items():
            yield from _leaves(inner, f"{name}.{key}" if name else str(key))
    elif isinstance(value, list) and any(isinstance(item, Mapping) for item in value):
        for number, inner in enumerate(value):
            yield from _leaves(inner, f"{name}.{number}")
    else:
        yield name, value


def _text(value: Any) -> str:
    if isinstance(value, list):
        if len(value) > 12 and all(isinstance(item, int) for item in value):
            return f"{value[0]} … {value[-1]} ({len(value)} values)"
        return ", ".join(_text(item) for item in value)
    return "–" if value is None else str(value)
