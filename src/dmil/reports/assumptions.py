"""What the paper leaves open and how this run filled it: assumed [A], fitted [F], stated [P]."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel

from dmil.controllers.settings import DualMemorySettings, SarsaSettings

#: Readings that are built in or set per study rather than per controller: mark, meaning, and the
#: name under which a configuration may hold the value.
_READINGS: tuple[tuple[str, str, str], ...] = (
    ("A", "arrival rates λ = 5, 5, 10, 7 are per minute", "rate_veh_per_min"),
    ("A", "a turning vehicle on a shortest path takes a coin drawn in advance", "route_choice"),
    ("A", "v* = 1 vehicle per step and orientation", "saturation_flow_veh_per_s"),
    ("A", "links between intersections take 5 steps, entry links 0", "link_time_s"),
    ("A", "no time is lost when signals change", "clearance_s"),
    ("A", "the table's W is divided by V_c at the horizon", "headline"),
    ("A", "tests last 300 steps", "horizon_s"),
    ("A", "an unseen state takes a uniformly random action", "unseen"),
    ("A", "the simple classes match by the largest difference of a lane, at most 1", "radius"),
    ("F", "the complex classes scale states to 5 levels", "levels"),
    ("F", "ε is multiplied by .95 per decision under decaying and matched", "epsilon_decay"),
    ("F", "training is ten times as long as a test under matched", "training_factor"),
    (
        "F",
        '"No Memory" is SARSA on the simple classes under matched, exact SARSA else',
        "no_memory",
    ),
    ("A", "dual memory imports the best κ of the trained rows through Algorithm 2", "import_rule"),
)


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
        The value this study used, or the default that holds if the manifest does not say.
    """

    mark: str
    meaning: str
    value: str


def assumptions(configuration: Mapping[str, Any]) -> list[Assumption]:
    """List what was assumed or fitted, with the values of a configuration (ours).

    Parameters
    ----------
    configuration
        ``configuration`` of a manifest; any nesting.
    """
    used = dict(_leaves(configuration))
    found = [
        Assumption(mark, meaning, _lookup(used, name, "")) for mark, meaning, name in _READINGS
    ]
    seen: set[str] = set()
    for settings in (SarsaSettings, DualMemorySettings):
        for name, field in _marked(settings):
            if name in seen:
                continue
            seen.add(name)
            text = field.description or name
            mark = "F" if "[F" in text else "A"
            meaning = text.split(" [")[0].removesuffix(".")
            found.append(Assumption(mark, meaning, _lookup(used, name, str(field.default))))
    return [*(a for a in found if a.mark == "F"), *(a for a in found if a.mark == "A")]


def configuration_rows(configuration: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return every value of a configuration with its dotted name (ours)."""
    return [(name, _text(value)) for name, value in _leaves(configuration)]


def find_value(configuration: Mapping[str, Any], name: str, default: Any) -> Any:
    """Return the first value of that name anywhere in a configuration (ours)."""
    for key, value in _leaves(configuration):
        if key.rsplit(".", 1)[-1] == name:
            return value
    return default


def _marked(settings: type[BaseModel]) -> Iterator[tuple[str, Any]]:
    for name, field in settings.model_fields.items():
        if name != "epsilon_decay" and field.description and "[A" in field.description:
            yield name, field


def _lookup(used: Mapping[str, Any], name: str, default: str) -> str:
    values = {_text(v) for key, v in used.items() if key.rsplit(".", 1)[-1] == name}
    return ", ".join(sorted(values)) or default


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
