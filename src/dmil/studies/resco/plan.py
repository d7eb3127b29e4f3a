"""The runs of the study on the RESCO benchmark."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

from dmil.controllers import CONTROLLERS
from dmil.studies.resco.settings import RescoStudySettings

PRESET = "resco"
BASELINES = ("program", "actuated", "longest-queue-first", "max-pressure", "random")
LEARNERS: tuple[tuple[str, str, bool], ...] = (
    ("sarsa", "exact", False),
    *(
        ("dual-memory", embedding, communication)
        for embedding, communication in product(("simple", "complex", "cells"), (False, True))
    ),
)
"""Controller, embedding, communication."""


@dataclass(frozen=True, slots=True)
class ContenderUnit:
    """One controller on one network in one seed: its training, and its runs in all simulators.

    ``embedding`` is None for those that do not learn.
    """

    preset: str
    scenario: str
    seed: int
    controller: str
    embedding: str | None = None
    communication: bool = False

    @property
    def learns(self) -> bool:
        """Whether it is trained first."""
        return CONTROLLERS[self.controller].learns

    def simulators(self, settings: RescoStudySettings) -> tuple[str, ...]:
        """Return the names of the simulators that it is judged in."""
        sumo_only = CONTROLLERS[self.controller].sumo_only
        return settings.simulators[:1] if sumo_only else settings.simulators


def units(settings: RescoStudySettings) -> list[ContenderUnit]:
    """Return all units of a study, network by network (ours)."""
    contenders: list[tuple[str, str | None, bool]] = [(name, None, False) for name in BASELINES]
    contenders += LEARNERS
    seeds = range(settings.first_seed, settings.first_seed + settings.seeds)
    return [
        ContenderUnit(PRESET, f"resco/{name}", seed, *contender)
        for name, seed, contender in product(settings.scenarios, seeds, contenders)
    ]
