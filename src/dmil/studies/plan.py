"""What a study runs: blocks of runs that share their demand, and the agents in each."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

from dmil.studies.settings import PRESETS, PaperStudySettings

BASELINES = ("random", "fixed-cycle", "longest-queue-first", "max-pressure")


@dataclass(frozen=True, slots=True)
class Architecture:
    """One controller of the study (paper, Table I).

    Attributes
    ----------
    controller: str
        Its name.
    embedding, reward, epsilon
        What it learns with; None for controllers that do not learn.
    communication: bool
        Whether its agents meet the central unit.
    """

    controller: str
    embedding: str | None = None
    communication: bool = False
    reward: str | None = None
    epsilon: float | None = None


@dataclass(frozen=True, slots=True)
class Block:
    """Runs of all architectures on the same vehicles: one preset, one grid, one seed.

    Attributes
    ----------
    preset, scenario: str
    seed: int
    """

    preset: str
    scenario: str
    seed: int


def blocks(settings: PaperStudySettings) -> list[Block]:
    """Return the blocks of a study in the order of its results (ours)."""
    seeds = range(settings.first_seed, settings.first_seed + settings.seeds)
    scenarios = [f"grid:{name}" for name in settings.grids]
    return [Block(*each) for each in product(settings.presets, scenarios, seeds)]


def architectures(settings: PaperStudySettings) -> list[Architecture]:
    """Return the architectures that every block runs (paper, Table I; specification, §7).

    The 24 of the paper, exact SARSA as its "No Memory", SARSA once more with the ε of the
    memory-based agents, the 24 with other readings of the complex classes, and the four baselines.
    Exact SARSA does not communicate: states that hardly ever recur leave nothing to average.
    """
    own, memory = settings.sarsa.epsilon, settings.dual_memory.epsilon
    epsilons = dict.fromkeys((own, memory) if settings.equal_epsilon else (own,))
    complex_classes, *others = settings.complex_readings
    found = []
    for reward in settings.rewards:
        for epsilon in epsilons:
            found.append(Architecture("sarsa", "exact", False, reward, epsilon))
            embeddings = ("simple", complex_classes, *(others if epsilon == own else ()))
            found += [
                Architecture("sarsa", embedding, communication, reward, epsilon)
                for embedding, communication in product(embeddings, (False, True))
            ]
        found += [
            Architecture("dual-memory", embedding, communication, reward, memory)
            for embedding, communication in product(
                ("simple", complex_classes, *others), (False, True)
            )
        ]
    return found + [Architecture(name) for name in BASELINES]


def training_s(settings: PaperStudySettings, preset: str) -> int:
    """Return the length of the training phase in s (specification, §7)."""
    return settings.horizon_s * PRESETS[preset].training_factor
