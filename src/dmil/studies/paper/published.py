"""What the paper printed, as data: its Table II and which of our cells each column stands for.

Source: Chodhary, Octavian and Han, "Efficient Replay Memory Architectures in Multi-Agent
Reinforcement Learning for Traffic Congestion Control" (arXiv 2407.16034), §VI, Table II:
average waiting time W divided by V_c(300), mean ± the paper's spread over 30 seeds.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from dmil.studies.paper.plan import Architecture

SOURCE = "arXiv 2407.16034, Table II"

NO_MEMORY = "No Memory"
SIMPLE = "Simple"
COMPLEX = "Complex"
COMPLEX_COMMUNICATION = "Complex + communication"

#: Columns of Table II, in the paper's order.
PAPER_COLUMNS: tuple[str, ...] = (NO_MEMORY, SIMPLE, COMPLEX, COMPLEX_COMMUNICATION)

#: Readings of the complex classes: as the text says, and with the tolerance after scaling only.
COMPLEX_READINGS: tuple[str, ...] = ("complex", "complex-scaled")

#: Rewards of Table II, in the paper's order.
PAPER_REWARDS: tuple[str, ...] = ("default", "entropy", "diffusion")

#: ε of the paper's tests: agents without and with memory.
EPSILON_NON_MEMORY = 0.6
EPSILON_MEMORY = 0.4


def is_of(architecture: Architecture, row: Mapping[str, Any]) -> bool:
    """Tell whether a cell is of an architecture, whatever its reward (ours)."""
    return (asdict(architecture) | {"reward": row["reward"]}).items() <= row.items()


@dataclass(frozen=True, slots=True)
class Reading:
    """How a study read the paper: which of its agents the columns of Table II stand for.

    Parameters
    ----------
    epsilon_non_memory, epsilon_memory
        ε of the agents without and with memory.
    no_memory_embedding
        Preset to the classes of its "No Memory": exact SARSA as written; under ``matched`` SARSA
        on the simple classes, the reading that reproduces the printed magnitudes.
    complex_embedding
        Which reading of the complex classes its "Complex" has.
    """

    epsilon_non_memory: float = EPSILON_NON_MEMORY
    epsilon_memory: float = EPSILON_MEMORY
    no_memory_embedding: Mapping[str, str] = field(
        default_factory=lambda: {"matched": "simple"}, hash=False
    )
    complex_embedding: str = "complex"

    @property
    def exact_sarsa(self) -> Architecture:
        """SARSA on exact states, as the paper has it."""
        return Architecture("sarsa", "exact", epsilon=self.epsilon_non_memory)

    def architecture(self, column: str, preset: str) -> Architecture:
        """Return the architecture that a column of Table II stands for under a preset (ours)."""
        if column == NO_MEMORY:
            embedding = self.no_memory_embedding.get(preset, "exact")
            return Architecture("sarsa", embedding, epsilon=self.epsilon_non_memory)
        embedding = "simple" if column == SIMPLE else self.complex_embedding
        communication = column == COMPLEX_COMMUNICATION
        return Architecture("dual-memory", embedding, communication, None, self.epsilon_memory)

    def column(self, row: Mapping[str, Any]) -> str | None:
        """Return which column of Table II a cell stands for under its preset."""
        for column in PAPER_COLUMNS:
            if is_of(self.architecture(column, row["preset"]), row):
                return column
        return None


def reading_of(configuration: Mapping[str, Any]) -> Reading:
    """Return the reading that a study's configuration describes (ours).

    It is as in the manifest; what it leaves out is as in the paper.
    """
    sarsa, memory = (configuration.get(name) or {} for name in ("sarsa", "dual_memory"))
    presets = configuration.get("presets")
    chosen = {
        name: preset["no_memory_embedding"]
        for name, preset in (presets.items() if isinstance(presets, Mapping) else ())
        if isinstance(preset, Mapping) and "no_memory_embedding" in preset
    }
    return Reading(
        sarsa.get("epsilon", EPSILON_NON_MEMORY),
        memory.get("epsilon", EPSILON_MEMORY),
        {"matched": "simple"} | chosen,
        (configuration.get("complex_readings") or ["complex"])[0],
    )


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


def implied_changes(first: str, second: str) -> list[float]:
    """Return the changes of W/V_c between rewards in Table II, first/second − 1 (ours)."""
    found = {(value.scenario, value.column, value.reward): value.mean for value in TABLE_II}
    return [
        mean / found[scenario, column, second] - 1
        for (scenario, column, reward), mean in found.items()
        if reward == first
    ]


def intersections_of(scenario: str) -> int | None:
    """Return the number of intersections of "grid:RxC"; None for other scenarios (ours)."""
    found = re.fullmatch(r"grid:(\d+)x(\d+)", scenario)
    return int(found[1]) * int(found[2]) if found else None


def scenario_label(scenario: str) -> str:
    """Return "5×5" for "grid:5x5", other names as they are (ours)."""
    return (
        scenario.removeprefix("grid:").replace("x", "×") if intersections_of(scenario) else scenario
    )
