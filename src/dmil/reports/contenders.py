"""Names, colours and dashes of controllers with options, as studies label them."""

from __future__ import annotations

from collections.abc import Sequence

from dmil.controllers.variants import parse_variant
from dmil.reports.labels import colour, dash, short_label

_SHORT = {
    "approaching=true": " + approaching",
    "embedding=complex": ", complex classes",
}


def controller_name(label: str) -> str:
    """Return a controller as a reader should see it: "longest queue + approaching" (ours)."""
    name, *options = label.split(",")
    parts = [_SHORT.get(each, ", " + each.replace("epsilon=0.", "ε .")) for each in options]
    return "".join([short_label(name), *parts])


def colour_of(label: str) -> str:
    """Return the colour of a controller with its options."""
    variant = parse_variant(label)
    return colour(variant.name, [*variant.options, *map(str, variant.options.values())])


def palette(labels: Sequence[str]) -> dict[str, str]:
    """Return the colour of each shown name (ours)."""
    return {controller_name(label): colour_of(label) for label in labels}


def dashes(labels: Sequence[str]) -> dict[str, list[int]]:
    """Return the dash of each shown name: those with options are dotted (ours)."""
    found = {}
    for label in labels:
        name, _, options = label.partition(",")
        found[controller_name(label)] = dash(name) if options in ("", "epsilon=0.05") else [2, 2]
    return found
