"""What is not the paper's, with the values that this run used."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from dmil.interpretations import INTERPRETATIONS, MEANING, Interpretation
from dmil.reports.html import leaves, shown
from dmil.studies.paper.settings import PRESETS, PaperStudySettings

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
    """One choice that is not the paper's: it is fitted, assumed, corrected or ours.

    It says of which part of the system, what was chosen, what the paper says of it, and what holds
    in this study.
    """

    kind: str
    topic: str
    meaning: str
    paper: str
    value: str


def assumptions(configuration: Mapping[str, Any]) -> list[Assumption]:
    """List all that was fitted, assumed, corrected or added, fitted first (ours).

    It is the table that docs/paper.md and the marks of the settings come from, with the values of
    this study where they are not those of the table: ``configuration`` of a manifest, with defaults
    for settings that it lacks.
    """
    differs = changed(configuration)
    listed = [each for each in INTERPRETATIONS if each.mark in _ORDER]
    return [
        Assumption(
            MEANING[each.mark], each.topic, each.what, each.paper, _in_this_run(each, differs)
        )
        for each in sorted(listed, key=lambda each: _ORDER.index(each.mark))
    ]


def changed(configuration: Mapping[str, Any]) -> dict[str, str]:
    """Return dotted names and values of a study that are not those of the paper's study (ours).

    Which seeds, grids, presets, rewards and extra runs a study has is left out: its runs are
    comparable with the paper's all the same. So are names that the paper's study does not have.
    """
    presets = {name: preset.model_dump() for name, preset in PRESETS.items()}
    usual = dict(leaves(PaperStudySettings().model_dump(mode="json") | {"presets": presets}))
    return {
        name: shown(value)
        for name, value in leaves(configuration)
        if name in usual and usual[name] != value and name not in _EXTENT
    } | {
        name: shown(value)
        for name, value in leaves(configuration.get("demand", {}), "demand")
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
