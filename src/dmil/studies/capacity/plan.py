"""What the study of capacity runs: controllers, networks with their highest load, and trials."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path

from dmil.controllers import CONTROLLERS, check_controller
from dmil.controllers.variants import Variant, parse_variant
from dmil.errors import InputError
from dmil.experiments.cells import CITY, city_cells, city_folder
from dmil.scenarios import Scenario, SignalTiming, scenario
from dmil.studies.capacity.settings import CapacityStudySettings

CAPACITY, DISTURBANCES = "capacity", "disturbances"
"""Presets: which part of the study a run belongs to."""
REFERENCE = "max-pressure"
CONTENDERS = (
    "fixed-cycle",
    "program",
    "gap-out",
    REFERENCE,
    "max-pressure,approaching=true",
    "longest-queue-first,approaching=true",
    "factored",
    "lookahead",
    "combined",
)
GRIDS = ("grid:1x1*8", "grid:3x3*6", "grid:5x5*6")
HIGHEST = 4.0
"""Highest load of networks that are given without one."""
_HIGHEST_OF = {"cityflow:jinan_3x4": 3.0, "cityflow:hangzhou_4x4": 4.5}
CITY_TIMING = SignalTiming(decision_interval_s=15, clearance_s=5, clearance_kind=None)
"""A decision every 15 s, its first 5 s clearance, of the file's kind."""


@dataclass(frozen=True, slots=True)
class Place:
    """A network with the highest load that is tried on it.

    Attributes
    ----------
    scenario: str
        Name of the scenario; a city's is that of its folder inside the folder of data.
    highest: float
        Factor on its demand.
    """

    scenario: str
    highest: float = HIGHEST

    @classmethod
    def parse(cls, name: str) -> Place:
        """Read a network's name, such as ``grid:5x5`` or ``grid:5x5*6`` (ours).

        Raises
        ------
        InputError
            The load is no number above 0.
        """
        scenario, star, load = name.partition("*")
        try:
            highest = float(load) if star else _HIGHEST_OF.get(scenario, HIGHEST)
            if not 0 < highest < float("inf"):
                raise ValueError
        except ValueError:
            raise InputError(
                f"found '{name}'",
                where="networks",
                expected="SCENARIO or SCENARIO*LOAD with a load above 0, such as grid:5x5*6",
            ) from None
        return cls(scenario, highest)

    @property
    def name(self) -> str:
        """Its name, as `parse` reads it."""
        return f"{self.scenario}*{self.highest:g}"

    def build(self, horizon_s: int, data: Path | None) -> tuple[Scenario, int | None]:
        """Make the scenario at load 1; also return how long its record lasts in s (ours).

        Raises
        ------
        InputError
            There is no such scenario, its files are not valid, or a city has no folder of data.
        """
        if self.scenario.startswith("grid:"):
            return scenario(self.scenario, horizon_s=horizon_s), None
        name, timing = self.scenario, None
        if name.startswith(CITY):
            name, timing = f"{CITY}{city_folder(data) / name.removeprefix(CITY)}", CITY_TIMING
        made = scenario(name, timing=timing)
        return replace(made, horizon_s=horizon_s), made.horizon_s


@dataclass(frozen=True, slots=True)
class CapacityUnit:
    """One controller on one network with one seed: all loads of it, or all disturbances.

    ``preset`` says which of both.
    """

    preset: str
    scenario: str
    seed: int
    controller: Variant


def places(settings: CapacityStudySettings) -> list[Place]:
    """Return where the study runs (ours).

    Raises
    ------
    InputError
        A name is wrong, two are of one network, or there are no files where they should be.
    """
    names = settings.networks
    if not names:
        names = GRIDS + (() if settings.data is None else city_cells(settings.data))
    found = [Place.parse(name) for name in names]
    if len({each.scenario for each in found}) < len(found):
        raise InputError(
            f"found {', '.join(names)}", where="networks", expected="every network once"
        )
    return found


def contenders(settings: CapacityStudySettings) -> list[Variant]:
    """Return all controllers of the study.

    Raises
    ------
    InputError
        There is no such controller or option.
    """
    found = [parse_variant(text) for text in settings.controllers or CONTENDERS]
    for each in found:
        check_controller(each.name)
    return found


def fits(variant: Variant, made: Scenario, simulator: str) -> bool:
    """Tell whether a controller can run on a network: plans need one, some need SUMO."""
    entry = CONTROLLERS.get(variant.name)
    if entry is None:
        return True
    planned = all(item.program for item in made.network.intersections)
    alone = len(made.network.intersections) == 1
    return (
        (planned or not entry.shows_plan)
        and (simulator == "sumo" or not entry.sumo_only)
        and (alone or not entry.oracle)
    )


def units(settings: CapacityStudySettings) -> list[CapacityUnit]:
    """Return all trials of the study; those that share vehicles follow each other."""
    seeds = range(settings.first_seed, settings.first_seed + settings.seeds)
    presets = (CAPACITY, DISTURBANCES) if settings.disturb else (CAPACITY,)
    variants, found = contenders(settings), []
    for place in places(settings):
        made, _ = place.build(settings.horizon_s, settings.data)
        chosen = [each for each in variants if fits(each, made, settings.simulator)]
        found += [
            CapacityUnit(preset, place.scenario, seed, variant)
            for seed, preset, variant in product(seeds, presets, chosen)
        ]
    return found
