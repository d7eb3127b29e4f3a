"""What a study runs: blocks of runs that share their demand, and the agents in each."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import product

from dmil.controllers.variants import read_options
from dmil.studies.paper.settings import PaperStudySettings

BASELINES = ("random", "fixed-cycle", "longest-queue-first", "max-pressure")


@dataclass(frozen=True, slots=True)
class Architecture:
    """One controller of the study (paper, Table I).

    Embedding, reward and ε are None for controllers that do not learn; ``variant`` is one more
    option, such as ``trigger=staging``, None for the paper's own.
    """

    controller: str
    embedding: str | None = None
    communication: bool = False
    reward: str | None = None
    epsilon: float | None = None
    variant: str | None = None


@dataclass(frozen=True, slots=True)
class Block:
    """Runs of all architectures on the same vehicles: one preset, one grid, one seed."""

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
    memory-based agents, those of Table II on other readings of the complex classes, and the four
    baselines. Exact SARSA does not communicate: states that hardly ever recur leave nothing to
    average.
    """
    own, memory = settings.sarsa.epsilon, settings.dual_memory.epsilon
    epsilons = dict.fromkeys((own, memory) if settings.equal_epsilon else (own,))
    complex_classes, *others = settings.complex_readings
    found = []
    for reward in settings.rewards:
        for epsilon in epsilons:
            found.append(Architecture("sarsa", "exact", False, reward, epsilon))
            found += [
                Architecture("sarsa", embedding, communication, reward, epsilon)
                for embedding, communication in product(("simple", complex_classes), (False, True))
            ]
        found += [
            Architecture("dual-memory", embedding, communication, reward, memory)
            for embedding, communication in product(
                ("simple", complex_classes, *others), (False, True)
            )
        ]
    return found + [Architecture(name) for name in BASELINES]


VARIANTS: tuple[str, ...] = (
    "communication=false",
    "communication=true",
    "trigger=entries",
    "trigger=values",
    "trigger=staging",
    "sent=short",
    "sent=both",
    "communication_delay_s=50",
    "communication_delay_s=100",
    "message_loss=0.1",
    "message_loss=0.5",
    "announced=true",
)
"""The paper's agent on the complex classes without and with communication, and what the paper
mentions beside its own rule or leaves to future work: when agents meet the central unit, what they
send, answers that are late or lost, predictions from neighbours. Each is one option of the agent
that communicates."""


def variants(settings: PaperStudySettings, block: Block) -> list[Architecture]:
    """Return what a block runs beyond the paper's architectures: a small study in the large (ours).

    Only blocks of the study's last preset on its largest grid have some, for the first of the
    seeds, with one reward: entropy, or the study's first. Their runs are longer than the others:
    in the paper's short ones short-term memory hardly ever fills on these classes, so that
    long-term memories stay as they were trained and there is little to exchange.
    """
    sizes = {name: math.prod(map(int, name.split("x"))) for name in settings.grids}
    largest = max(sizes, key=sizes.__getitem__)
    here = block.preset == settings.presets[-1] and block.scenario == f"grid:{largest}"
    early = block.seed - settings.first_seed < settings.variant_seeds
    if not (here and early and sizes[largest] > 1):
        return []
    reward = "entropy" if "entropy" in settings.rewards else settings.rewards[0]
    own = Architecture(
        "dual-memory", settings.complex_readings[0], True, reward, settings.dual_memory.epsilon
    )
    rule = settings.dual_memory.model_dump()
    return [
        replace(own, variant=variant, communication=variant != "communication=false")
        for variant in VARIANTS
        # What the study does anyway is no variant of it.
        if variant.startswith("communication=")
        or any(rule[name] != value for name, value in read_options([variant], where="").items())
    ]


def training_s(settings: PaperStudySettings, preset: str) -> int:
    """Return the length of the training phase in s (specification, §7)."""
    return settings.horizon_s * settings.preset(preset).training_factor
