"""What the study of memories runs: contenders, cells, and units of both with a seed."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import Any

from dmil.controllers import CONTROLLERS, check_controller
from dmil.controllers.variants import parse_variant
from dmil.studies.memories.cells import GRID_CELLS, Cell, city_cells
from dmil.studies.memories.settings import MemoriesStudySettings

PRESET = "memories"
REFERENCE = "max-pressure"
DEEP = tuple(name for name, entry in CONTROLLERS.items() if entry.family == "deep")
_AT_LAST = ("nec", "vdn", "factored", "lookahead")
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
    """One controller in one cell with one seed: its training and its run.

    Attributes
    ----------
    preset, scenario: str
    load: float
    seed: int
    controller: str
        With its options.
    """

    preset: str
    scenario: str
    load: float
    seed: int
    controller: str

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


def contenders(settings: MemoriesStudySettings) -> list[str]:
    """Return the labels of all controllers of the study, ablations last (ours).

    Raises
    ------
    InputError
        There is no such controller or option.
    """
    labels = [parse_variant(text).label for text in settings.controllers or CONTENDERS]
    labels += ablations(settings)
    for label in labels:
        check_controller(parse_variant(label).name)
    labels = list(dict.fromkeys(labels))
    if settings.deep or settings.controllers:
        return labels
    return [label for label in labels if parse_variant(label).name not in DEEP]


def ablations(settings: MemoriesStudySettings) -> list[str]:
    """Return the labels of those that the report shows in a table of their own (ours)."""
    if settings.ablations == (NO_ABLATION,):
        return []
    chosen = settings.ablations or (() if settings.controllers else ABLATIONS)
    return [parse_variant(text).label for text in chosen]


def units(settings: MemoriesStudySettings) -> list[MemoriesUnit]:
    """Return all units of the study; those that share vehicles follow each other (ours)."""
    seeds = range(settings.first_seed, settings.first_seed + settings.seeds)
    labels = contenders(settings)
    return [
        MemoriesUnit(PRESET, cell.scenario, cell.load, seed, label)
        for cell, seed, label in product(cells(settings), seeds, labels)
        if fits(label, cell)
    ]


def fits(label: str, cell: Cell) -> bool:
    """Tell whether a controller can run in a cell (ours)."""
    entry = CONTROLLERS.get(parse_variant(label).name)
    return not (entry and entry.oracle) or cell.scenario.partition("/")[0] == "grid:1x1"


def options_of(settings: MemoriesStudySettings, label: str) -> dict[str, Any]:
    """Return a controller's options: those that it is named with go over the tuned (ours).

    Tuned ones are those of the very label, else those of the name without options.
    """
    variant = parse_variant(label)
    tuned = settings.tuned.get(variant.label, settings.tuned.get(variant.name, {}))
    return tuned | dict(variant.options)


def learns(label: str) -> bool:
    """Tell whether a controller has a memory to train (ours)."""
    name = parse_variant(label).name
    return name in CONTROLLERS and CONTROLLERS[name].learns


def is_trained(settings: MemoriesStudySettings, label: str) -> bool:
    """Tell whether a controller is trained before its test (ours)."""
    return learns(label) and parse_variant(label).name not in settings.untrained
