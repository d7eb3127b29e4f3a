"""The runs of the study on the RESCO benchmark."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

from dmil.controllers import CONTROLLERS
from dmil.controllers.variants import Variant
from dmil.scenarios.names import PREFIX
from dmil.studies.resco.settings import RescoStudySettings

PRESET = "resco"
APPROACHING = {"approaching": True}
UNTRAINED = (
    Variant("program"),
    Variant("actuated"),
    Variant("gap-out"),
    Variant("sotl"),
    Variant("longest-queue-first"),
    Variant("longest-queue-first", APPROACHING),
    Variant("max-pressure"),
    Variant("max-pressure", APPROACHING),
    Variant("factored"),
    Variant("lookahead"),
    Variant("combined"),
    Variant("random"),
)
"""Rules, and memories of lanes, which learn online and are not trained."""
LEARNERS: tuple[tuple[str, str, bool], ...] = (
    ("sarsa", "exact", False),
    *(
        ("dual-memory", embedding, communication)
        for embedding, communication in product(("simple", "complex", "cells"), (False, True))
    ),
)
"""Controller, embedding, communication."""
DEEP = "dqn"


@dataclass(frozen=True, slots=True)
class ContenderUnit:
    """One controller on one network in one seed: its training, and its runs in all simulators.

    ``embedding`` is None for those that are no tables.
    """

    preset: str
    scenario: str
    seed: int
    controller: Variant
    embedding: str | None = None
    communication: bool = False

    @property
    def deep(self) -> bool:
        """Whether it is the deep rival, which trains in SUMO."""
        return self.controller.name == DEEP

    @property
    def trains(self) -> bool:
        """Whether it is trained first."""
        return self.deep or self.embedding is not None

    @property
    def network(self) -> str:
        """Name of the network as settings have it."""
        return self.scenario.removeprefix(PREFIX)

    def simulators(self, settings: RescoStudySettings) -> tuple[str, ...]:
        """Return the names of the simulators that it is judged in."""
        if CONTROLLERS[self.controller.name].sumo_only:
            return settings.in_sumo
        return settings.simulators

    def test_seeds(self, settings: RescoStudySettings) -> Sequence[int]:
        """Return the seeds that it is judged in.

        The few trainings of a deep rival take turns, so that all seeds have a run of one of them.
        """
        if not self.deep:
            return (self.seed,)
        return settings.seeds_of(self.network)[
            self.seed - settings.first_seed :: settings.deep_seeds
        ]


def units(settings: RescoStudySettings) -> list[ContenderUnit]:
    """Return all units of a study, network by network (ours)."""
    found = []
    for network in settings.scenarios:
        place = PRESET, f"{PREFIX}{network}"
        for seed in settings.seeds_of(network):
            found += [ContenderUnit(*place, seed, each) for each in UNTRAINED]
            if seed < settings.first_seed + settings.seeds:
                found += [
                    ContenderUnit(*place, seed, Variant(name), embedding, communication)
                    for name, embedding, communication in LEARNERS
                ]
        if settings.deep and network in settings.deep_scenarios:
            trained = settings.seeds_of(network)[: settings.deep_seeds]
            found += [ContenderUnit(*place, seed, Variant(DEEP)) for seed in trained]
    return found
