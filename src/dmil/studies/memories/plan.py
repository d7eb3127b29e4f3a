"""What the study of memories runs: contenders, networks with their demand, and units of both."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import Any

from dmil.controllers import CONTROLLERS, check_controller
from dmil.controllers.variants import Variant, parse_variant
from dmil.experiments.cells import Cell, city_cells
from dmil.studies.memories.settings import MemoriesStudySettings

GRID_CELLS = (
    "grid:1x1",
    "grid:1x1*3",
    "grid:1x1*7",
    "grid:3x3",
    "grid:3x3*4",
    "grid:5x5",
    "grid:5x5*3",
    "grid:5x5*3.6",
    "grid:5x5/unequal",
    "grid:5x5/time-varying",
)
"""Light load to near saturation (1×1 ×7 and 5×5 ×3.6 are on its edge)."""


PRESET = "memories"
REFERENCE = "max-pressure"
DEEP = tuple(name for name, entry in CONTROLLERS.items() if entry.family == "deep")
_AT_LAST = ("nec", "vdn", "factored", "lookahead", "combined")
_VARIANTS = {
    "longest-queue-first": ("longest-queue-first", "longest-queue-first,approaching=true"),
    REFERENCE: (REFERENCE, "max-pressure,approaching=true"),
    "sarsa": ("sarsa,epsilon=0.05", "sarsa,embedding=complex,epsilon=0.05"),
    "dual-memory": ("dual-memory,epsilon=0.05",),
}
CONTENDERS = tuple(
    variant
    for name in (*(each for each in CONTROLLERS if each not in _AT_LAST), *_AT_LAST)
    if not CONTROLLERS[name].shows_plan
    for variant in _VARIANTS.get(name, (name,))
)
"""Who runs by default: all but plans, which grids have not. The paper's agents explore as little as
the other rivals do: with its ε of .6 and .4 they would choose at random half of the time."""
ABLATIONS = (
    "factored,approaching=false",
    "factored,rates=false",
    "factored,learning=false",
    "factored,expected=0",
    "factored,wave=0",
    "factored,expected=0,wave=0",
)
"""Factored memory without one ingredient each, and without any announcement."""
NO_ABLATION = "none"


@dataclass(frozen=True, slots=True)
class MemoriesUnit:
    """One controller in one cell with one seed: its training and its run."""

    preset: str
    scenario: str
    load: float
    seed: int
    controller: Variant

    @property
    def cell(self) -> Cell:
        """Where it is."""
        return Cell(self.scenario, self.load)


def cells(settings: MemoriesStudySettings) -> list[Cell]:
    """Return where the study runs (ours).

    Raises
    ------
    InputError
        A name is wrong, or there are no files where they should be.
    """
    names = settings.cells
    if not names:
        names = GRID_CELLS + (() if settings.data is None else city_cells(settings.data))
    return [Cell.parse(name) for name in names]


def contenders(settings: MemoriesStudySettings) -> list[Variant]:
    """Return all controllers of the study, ablations last.

    Raises
    ------
    InputError
        There is no such controller or option.
    """
    named = [parse_variant(text) for text in settings.controllers or CONTENDERS]
    variants = {each.label: each for each in (*named, *ablations(settings))}
    for each in variants.values():
        check_controller(each.name)
    deep = settings.deep or settings.controllers
    return [each for each in variants.values() if deep or each.name not in DEEP]


def ablations(settings: MemoriesStudySettings) -> list[Variant]:
    """Return those that the report shows in a table of their own."""
    if settings.ablations == (NO_ABLATION,):
        return []
    chosen = settings.ablations or (() if settings.controllers else ABLATIONS)
    return [parse_variant(text) for text in chosen]


def units(settings: MemoriesStudySettings) -> list[MemoriesUnit]:
    """Return all units of the study; those that share vehicles follow each other."""
    seeds = range(settings.first_seed, settings.first_seed + settings.seeds)
    return [
        MemoriesUnit(PRESET, cell.scenario, cell.load, seed, variant)
        for cell, seed, variant in product(cells(settings), seeds, contenders(settings))
        if fits(variant, cell)
    ]


def fits(variant: Variant, cell: Cell) -> bool:
    """Tell whether a controller can run in a cell."""
    entry = CONTROLLERS.get(variant.name)
    return not (entry and entry.oracle) or cell.scenario.partition("/")[0] == "grid:1x1"


def options_of(settings: MemoriesStudySettings, variant: Variant) -> dict[str, Any]:
    """Return a controller's options: those that it is named with go over the tuned.

    Tuned ones are those of the very label, else those of the name without options.
    """
    tuned = settings.tuned.get(variant.label, settings.tuned.get(variant.name, {}))
    return tuned | dict(variant.options)


def learns(variant: Variant) -> bool:
    """Tell whether a controller has a memory to train."""
    return variant.name in CONTROLLERS and CONTROLLERS[variant.name].learns


def is_trained(settings: MemoriesStudySettings, variant: Variant) -> bool:
    """Tell whether a controller is trained before its test."""
    return learns(variant) and variant.name not in settings.untrained
