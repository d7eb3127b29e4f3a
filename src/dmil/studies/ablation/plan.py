"""What the ablation runs: every controller as it is, and with one part of it switched."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import Any

from dmil.controllers import CONTROLLERS, check_controller
from dmil.controllers.lanes.combined import AGE_VEH_PER_S
from dmil.controllers.variants import Variant
from dmil.errors import InputError, unknown_name
from dmil.experiments.cells import Cell
from dmil.studies.ablation.settings import AblationStudySettings

PRESET = "ablation"


@dataclass(frozen=True, slots=True)
class Part:
    """A part of a controller that an option switches.

    Attributes
    ----------
    option: str
        The option.
    off, on
        Its value without and with the part.
    label: str
        What a reader calls the part.
    """

    option: str
    off: Any
    on: Any
    label: str


PARTS = {
    "yields": Part("yields", off=False, on=True, label="turns that yield"),
    "age": Part("age", off=0.0, on=AGE_VEH_PER_S, label="long waits"),
    "waves": Part("waves", off="everywhere", on="choice", label="waves at choices only"),
    "outside": Part("outside", off=False, on=True, label="vehicles outside"),
    "censored": Part("censored", off=False, on=True, label="censored learning"),
    "guard": Part("guard", off=False, on=True, label="guard for shared lanes"),
    "approaching": Part("approaching", off=False, on=True, label="approaching vehicles"),
    "expected": Part("expected", off=0.0, on=0.3, label="announced vehicles"),
    "learning": Part("learning", off=False, on=True, label="learning"),
    "look-ahead": Part("weight", off=0.0, on=1.0, label="look-ahead"),
}
"""Parts by name. One that a controller has by default is left out, another is added."""


@dataclass(frozen=True, slots=True)
class Switched:
    """A controller with one part switched.

    Attributes
    ----------
    controller, part: str
        Names.
    added: bool
        Whether the part is added; otherwise it is left out.
    variant: Variant
        What runs.
    """

    controller: str
    part: str
    added: bool
    variant: Variant

    @property
    def change(self) -> str:
        """Return "without learning" and so on."""
        return f"{'with' if self.added else 'without'} {PARTS[self.part].label}"


@dataclass(frozen=True, slots=True)
class AblationUnit:
    """All variants of all controllers in one case and seed: they meet the same vehicles."""

    preset: str
    scenario: str
    load: float
    seed: int

    @property
    def cell(self) -> Cell:
        """Where it is."""
        return Cell(self.scenario, self.load)


def cells(settings: AblationStudySettings) -> list[Cell]:
    """Return where the study runs; an `InputError` if a name is wrong."""
    return [Cell.parse(name) for name in settings.cells]


def switched(settings: AblationStudySettings) -> list[Switched]:
    """Return every controller with every part of its switched.

    Raises
    ------
    InputError
        There is no such controller or part, or a controller has none of the parts.
    """
    for part in settings.parts:
        if part not in PARTS:
            raise unknown_name("part", part, PARTS, where="parts")
    found: list[Switched] = []
    for name in settings.controllers:
        check_controller(name, where="controllers")
        kind = CONTROLLERS[name].settings if name in CONTROLLERS else None
        usual = kind().model_dump() if kind else {}
        own = [
            Switched(
                name,
                part,
                added := usual[each.option] == each.off,
                Variant(name, {each.option: each.on if added else each.off}),
            )
            for part, each in PARTS.items()
            if each.option in usual and part in (settings.parts or PARTS)
        ]
        if not own:
            raise InputError(
                "none of its parts can be switched",
                where=f"controller '{name}'",
                expected="a controller with one of the options "
                + ", ".join(PARTS[part].option for part in settings.parts or PARTS),
            )
        found += own
    return found


def variants(settings: AblationStudySettings) -> list[Variant]:
    """Return all that runs in a trial: every controller as it is, then its variants."""
    changed = switched(settings)
    return [
        variant
        for name in settings.controllers
        for variant in (Variant(name), *(x.variant for x in changed if x.controller == name))
    ]


def units(settings: AblationStudySettings) -> list[AblationUnit]:
    """Return all units of the study, case by case."""
    seeds = range(settings.first_seed, settings.first_seed + settings.seeds)
    return [
        AblationUnit(PRESET, cell.scenario, cell.load, seed)
        for cell, seed in product(cells(settings), seeds)
    ]
