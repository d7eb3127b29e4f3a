"""Pages from templates: what all of them know, one look, and the configuration of a study."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from typing import Any

import jinja2
from markupsafe import Markup

from dmil.errors import unknown_name
from dmil.reports.export import Figure, embedded, script_bundle
from dmil.reports.labels import controller_label, interval, number, signed
from dmil.reports.theme import DARK
from dmil.results import Results
from dmil.version import __version__


@cache
def environment(package: str | None = None) -> jinja2.Environment:
    """Return the templates that all pages use, and those of a package, beside its modules."""
    loaders = [jinja2.PackageLoader("dmil.reports")]
    if package:
        loaders.append(jinja2.PackageLoader(package, "."))
    made = jinja2.Environment(
        loader=jinja2.ChoiceLoader(loaders),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.filters |= {"number": number, "signed": signed, "controller": controller_label}
    made.filters["options_below"] = _options_below
    made.globals["interval"] = interval
    return made


def _options_below(label: str) -> Markup:
    """Return a contender's label with every option on a line of its own."""
    return Markup(",<br>").join(label.split(","))


def shared_values(results: Results, figures: Sequence[Figure]) -> dict[str, Any]:
    """Return what every page says about its study, and what its figures need."""
    return {
        "manifest": results.manifest,
        "version": __version__,
        "counts": results.query(
            "select count(*) runs, count(*) filter (status = 'ok') ok,"
            " any_value(status) filter (status <> 'ok') failure,"
            " min(horizon_s) shortest_s, max(horizon_s) longest_s from runs"
        ).row(0, named=True),
        "figures": figures,
        "specs": [(figure.name, embedded(figure.spec)) for figure in figures],
        "bundle": script_bundle(),
        "dark_colours": DARK,
    }


def check_preset(chosen: str | None, only: str) -> None:
    """Check the preset that is chosen of a study that has only one.

    Raises
    ------
    UnknownNameError
        It is another.
    """
    if chosen not in (None, only):
        raise unknown_name("preset in this study", str(chosen), [only])


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
