"""What is not the paper's, with the values that this run used."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from dmil.interpretations import INTERPRETATIONS, MEANING, Interpretation
from dmil.studies.settings import PRESETS, PaperStudySettings

#: What the report lists: all that the paper does not state.
_ORDER = ("F", "A", "corrected", "ours")

#: What a study covers, as against how it runs.
_EXTENT = {
    "seeds",
    "first_seed",
    "grids",
    "presets",
    "rewards",
    "equal_epsilon",
    "complex_readings",
    "variant_seeds",
    "variant_factor",
}


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
    differs = changed(configuration)
    listed = [each for each in INTERPRETATIONS if each.mark in _ORDER]
    return [
        Assumption(
            MEANING[each.mark], each.topic, each.what, each.paper, _in_this_run(each, differs)
        )
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


def changed(configuration: Mapping[str, Any]) -> dict[str, str]:
    """Return dotted names and values of a study that are not those of the paper's study (ours).

    Which seeds, grids, presets, rewards and extra runs a study has is left out: its runs are
    comparable with the paper's all the same.

    Parameters
    ----------
    configuration
        ``configuration`` of a manifest; names that the paper's study does not have are left out.
    """
    presets = {name: preset.model_dump() for name, preset in PRESETS.items()}
    usual = dict(_leaves(PaperStudySettings().model_dump(mode="json") | {"presets": presets}))
    return {
        name: _text(value)
        for name, value in _leaves(configuration)
        if name in usual and usual[name] != value and name not in _EXTENT
    } | {
        name: _text(value)
        for name, value in _leaves(configuration.get("demand", {}), "demand")
        if value is not None
    }


def _in_this_run(each: Interpretation, differs: Mapping[str, str]) -> str:
    """Say what holds, and where this run has another value."""
    setting = f".{each.setting}"
    found = [
        f"{name} {value}"
        for name, value in differs.items()
        if each.setting and (f".{name}".endswith(setting) or f".{name}".startswith(f"{setting}."))
    ]
    return f"{each.here}. In this run: {', '.join(found)}" if found else each.here


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
