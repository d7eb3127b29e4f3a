"""What the paper leaves open and how this run filled it: assumed [A] or fitted [F]."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel

from dmil.controllers.settings import DualMemorySettings, SarsaSettings
from dmil.studies.settings import PaperStudySettings, Preset

#: Readings that are built in, not settings of a study.
_BUILT_IN: tuple[tuple[str, str, str], ...] = (
    ("F", "the complex classes scale a state to levels 0 to B", "B = 5"),
    ("A", "what the paper's W is divided by", "V_c at the horizon"),
    ("A", "action in a state without an entry", "uniformly random"),
    ("A", "distance within which simple classes match", "1 vehicle in any orientation"),
    ("A", "what dual memory takes from the trained table", "the best κ of its rows"),
)

#: Readings that are values of a scenario: dotted name, and what holds where it is not given.
_OF_A_SCENARIO: tuple[tuple[str, str, str], ...] = (
    (
        "demand.rate_veh_per_min",
        "arrival rates λ per minute and fringe node",
        "E 5, N 5, W 10, S 7",
    ),
    (
        "dynamics.saturation_flow_veh_per_s",
        "v*, vehicles that a served orientation discharges per step",
        "1",
    ),
    ("grid.link_time_s", "time on a link between intersections, in s", "5"),
    ("grid.entry_link_time_s", "time on an entry link, in s", "0"),
    ("timing.clearance_s", "time lost when signals change, in s", "0"),
)

_MARK = re.compile(r"\s*\[[^\]]*\b([AF])\b[^\]]*\]")


@dataclass(frozen=True, slots=True)
class Assumption:
    """One choice that is not the paper's.

    Parameters
    ----------
    mark
        "A" assumed, "F" fitted to the paper's table.
    meaning
        What was chosen.
    value
        The value this study used.
    """

    mark: str
    meaning: str
    value: str


def assumptions(configuration: Mapping[str, Any]) -> list[Assumption]:
    """List what was assumed or fitted, fitted first (ours).

    The marks stand in the descriptions of the settings; the values are those of this study.

    Parameters
    ----------
    configuration
        ``configuration`` of a manifest; settings that it lacks have their defaults.
    """
    used = list(_leaves(configuration))
    found = [
        Assumption(mark, meaning, _preset_values(used, name) or default)
        for name, mark, meaning, default in _marked(Preset)
    ]
    seen = set(Preset.model_fields)
    for settings in (PaperStudySettings, SarsaSettings, DualMemorySettings):
        for name, mark, meaning, default in _marked(settings):
            if name not in seen:
                seen.add(name)
                found.append(Assumption(mark, meaning, _values(used, name) or default))
    found += [
        Assumption("A", meaning, _given(configuration, path) or usual)
        for path, meaning, usual in _OF_A_SCENARIO
    ]
    found += [Assumption(*reading) for reading in _BUILT_IN]
    return sorted(found, key=lambda item: item.mark != "F")


def configuration_rows(configuration: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return every value of a configuration with its dotted name (ours)."""
    return [(name, _text(value)) for name, value in _leaves(configuration)]


def find_value(configuration: Mapping[str, Any], name: str, default: Any) -> Any:
    """Return the first value of that name anywhere in a configuration (ours)."""
    for key, value in _leaves(configuration):
        if key.rsplit(".", 1)[-1] == name:
            return value
    return default


def _marked(settings: type[BaseModel]) -> Iterator[tuple[str, str, str, str]]:
    """Yield name, mark, meaning and default of the fields that are not the paper's."""
    for name, field in settings.model_fields.items():
        description = field.description or ""
        found = _MARK.search(description)
        if found:
            meaning = _MARK.sub("", description).rstrip(".")
            yield name, found[1], meaning, _text(field.default)


def _values(used: list[tuple[str, Any]], name: str) -> str:
    values = {_text(value) for key, value in used if key.rsplit(".", 1)[-1] == name}
    return ", ".join(sorted(values))


def _given(configuration: Mapping[str, Any], path: str) -> str:
    """Return the value at a dotted path, empty if there is none."""
    value: Any = configuration
    for name in path.split("."):
        value = value.get(name) if isinstance(value, Mapping) else None
    if isinstance(value, Mapping):
        return ", ".join(f"{name} {each:g}" for name, each in value.items())
    return "" if value is None else f"{value:g}"


def _preset_values(used: list[tuple[str, Any]], name: str) -> str:
    found = []
    for key, value in used:
        parts = key.split(".")
        if parts[-1] == name and len(parts) > 2 and parts[-3] == "presets":
            found.append(f"{parts[-2]} {_text(value)}")
    return ", ".join(found)


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
