"""What was published on the RESCO benchmark, as data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

SOURCE = (
    "Ault and Sharon, Reinforcement Learning Benchmarks for Traffic Signal Control, NeurIPS "
    "Datasets and Benchmarks 2021; arterial4x4 and FMA2C: from the lists of episodes that its "
    "authors publish with their code (Pi-Star-Lab/RESCO, utils/avg_timeLoss.py)"
)
METRIC = "delay_s"
"""Metric that the numbers are of: RESCO's average delay."""

LAST_EPISODES = 10
"""Episodes at the end of the training that the second number of a learner averages."""

COUNTERPARTS: dict[str, str] = {
    "fixed": "program",
    "greedy": "longest-queue-first,approaching=true",
    "max-pressure": "max-pressure",
}
"""Published method to the controller here that comes nearest; greedy counts moving vehicles too."""


@dataclass(frozen=True, slots=True)
class Published:
    """A published average delay (Ault and Sharon, 2021); methods as the publication calls them.

    Attributes
    ----------
    best_s: float
        Learners: of the best training episode by the mean over trainings; others: mean of runs.
    last_s: float or None
        Learners: mean of the last 10 training episodes; of 100, for IPPO and FMA2C of 1,400.
    """

    scenario: str
    method: str
    best_s: float
    last_s: float | None = None


_SCENARIOS = (
    "resco/cologne1",
    "resco/cologne3",
    "resco/cologne8",
    "resco/ingolstadt1",
    "resco/ingolstadt7",
    "resco/ingolstadt21",
    "resco/grid4x4",
    "resco/arterial4x4",
)
_BEST: dict[str, tuple[float | None, ...]] = {
    "fixed": (56.6, 46.4, 63.8, 39.4, 91.3, 133.1, None, None),
    "greedy": (27.8, 90.7, 21.9, 28.3, 80.6, 76.3, 34.3, 820.8),
    "max-pressure": (65.9, 162.3, 47.7, 23.6, 46.8, 136.7, 52.6, 952.7),
    "IDQN": (26.1, 24.0, 22.1, 21.5, 31.2, 59.6, 33.0, 1168.3),
    "IPPO": (43.2, 24.0, 21.6, 20.9, 31.7, 93.1, 44.0, 686.6),
    "MPLight": (28.7, 83.7, 60.4, None, 48.2, 78.2, 46.9, 837.8),
    "FMA2C": (30.8, 26.9, 33.9, 27.0, 51.4, 90.3, 99.8, 654.1),
}
_LAST: dict[str, tuple[float | None, ...]] = {
    "IDQN": (28.9, 95.5, 22.3, 22.2, 35.7, 86.2, 34.1, 1316.2),
    "IPPO": (211.0, 123.0, 22.5, 22.7, 32.5, 397.0, 45.9, 1457.6),
    "MPLight": (53.0, 714.0, 252.0, None, 83.0, 377.0, 47.9, 989.6),
    "FMA2C": (32.3, 106.3, 37.5, 31.8, 56.3, 115.9, 106.5, 773.3),
}

METHODS = tuple(_BEST)
"""Published methods; those without a counterpart here are learners."""

PUBLISHED: tuple[Published, ...] = tuple(
    Published(scenario, method, best, _LAST[method][number] if method in _LAST else None)
    for method, values in _BEST.items()
    for number, (scenario, best) in enumerate(zip(_SCENARIOS, values, strict=True))
    if best is not None
)
"""All published numbers; a method is missing where the publication has none for a scenario."""


def published_by(scenario: str) -> dict[str, Published]:
    """Return what was published for a scenario, by method (ours)."""
    return {value.method: value for value in PUBLISHED if value.scenario == scenario}


def published_learners(scenarios: Sequence[str]) -> list[tuple[str, list[Published | None]]]:
    """Return the published learners with their numbers for every network (ours)."""
    rows = [(name, [published_by(each).get(name) for each in scenarios]) for name in METHODS]
    return [row for row in rows if any(value and value.last_s is not None for value in row[1])]


def counterpart_of(controller: str) -> str | None:
    """Return the published method that does what a controller does, if there is one (ours)."""
    return next((name for name, own in COUNTERPARTS.items() if own == controller), None)
