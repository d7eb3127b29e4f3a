"""What the paper printed, as data: its Table II and which of our cells each column stands for.

Source: Chodhary, Octavian and Han, "Efficient Replay Memory Architectures in Multi-Agent
Reinforcement Learning for Traffic Congestion Control" (arXiv 2407.16034), §VI, Table II:
average waiting time W divided by V_c(300), mean ± the paper's spread over 30 seeds.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

SOURCE = "arXiv 2407.16034, Table II"

NO_MEMORY = "No Memory"
SIMPLE = "Simple"
COMPLEX = "Complex"
COMPLEX_COMMUNICATION = "Complex + communication"

#: Columns of Table II, in the paper's order.
PAPER_COLUMNS: tuple[str, ...] = (NO_MEMORY, SIMPLE, COMPLEX, COMPLEX_COMMUNICATION)

#: Rewards of Table II, in the paper's order.
PAPER_REWARDS: tuple[str, ...] = ("default", "entropy", "diffusion")

#: ε of the paper's tests: agents without and with memory.
EPSILON_NON_MEMORY = 0.6
EPSILON_MEMORY = 0.4


@dataclass(frozen=True, slots=True)
class Architecture:
    """What a learning agent is made of, apart from its reward.

    Parameters
    ----------
    controller
        "sarsa" or "dual-memory".
    embedding
        "exact", "simple", "complex" or "cells".
    communication
        Whether a central unit synchronises the memories.
    epsilon
        Exploration rate at time 0.
    """

    controller: str
    embedding: str
    communication: bool
    epsilon: float


def architecture_of(column: str, preset: str) -> Architecture:
    """Return the architecture that a column of Table II stands for under a preset (ours).

    The paper's "No Memory" is exact SARSA as written; under ``matched`` it is SARSA on the simple
    classes, the reading that reproduces the printed magnitudes.
    """
    if column == NO_MEMORY:
        embedding = "simple" if preset == "matched" else "exact"
        return Architecture("sarsa", embedding, False, EPSILON_NON_MEMORY)
    embedding = "simple" if column == SIMPLE else "complex"
    return Architecture("dual-memory", embedding, column == COMPLEX_COMMUNICATION, EPSILON_MEMORY)


@dataclass(frozen=True, slots=True)
class PaperValue:
    """One entry of Table II: W / V_c(300), mean and the number after its ±."""

    scenario: str
    reward: str
    column: str
    mean: float
    spread: float


def _rows(scenario: str, reward: str, *entries: tuple[float, float]) -> list[PaperValue]:
    return [
        PaperValue(scenario, reward, column, mean, spread)
        for column, (mean, spread) in zip(PAPER_COLUMNS, entries, strict=False)
    ]


#: Table II. The single intersection has no entry with communication.
TABLE_II: tuple[PaperValue, ...] = (
    *_rows("grid:1x1", "default", (0.21, 0.1), (0.24, 0.1), (0.29, 0.1)),
    *_rows("grid:1x1", "entropy", (0.14, 0.1), (0.16, 0.1), (0.17, 0.1)),
    *_rows("grid:1x1", "diffusion", (0.14, 0.1), (0.16, 0.1), (0.17, 0.1)),
    *_rows("grid:3x3", "default", (0.19, 0.1), (0.16, 0.03), (0.24, 0.05), (0.25, 0.05)),
    *_rows("grid:3x3", "entropy", (0.10, 0.02), (0.08, 0.01), (0.08, 0.01), (0.08, 0.01)),
    *_rows("grid:3x3", "diffusion", (0.10, 0.02), (0.08, 0.01), (0.08, 0.01), (0.08, 0.01)),
    *_rows("grid:5x5", "default", (0.17, 0.04), (0.16, 0.03), (0.26, 0.04), (0.24, 0.04)),
    *_rows("grid:5x5", "entropy", (0.08, 0.01), (0.05, 0.004), (0.06, 0.004), (0.06, 0.003)),
    *_rows("grid:5x5", "diffusion", (0.08, 0.01), (0.05, 0.004), (0.06, 0.004), (0.06, 0.003)),
)


def intersections_of(scenario: str) -> int | None:
    """Return the number of intersections of "grid:RxC"; None for other scenarios (ours)."""
    found = re.fullmatch(r"grid:(\d+)x(\d+)", scenario)
    return int(found[1]) * int(found[2]) if found else None


def scenario_label(scenario: str) -> str:
    """Return "5×5" for "grid:5x5", other names as they are (ours)."""
    return (
        scenario.removeprefix("grid:").replace("x", "×") if intersections_of(scenario) else scenario
    )
