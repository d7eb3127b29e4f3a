"""What a measurement of speed says, and how figures are measured in turns."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from statistics import median
from time import perf_counter

import numpy as np

from dmil.arrays import IntArray
from dmil.demand import Vehicles
from dmil.simulation import Observation, Simulator
from dmil.training.observers import Observer, Phases


@dataclass(frozen=True, slots=True)
class SpeedFigure:
    """One measured number, alone or beside another.

    Parameters
    ----------
    name
        What was measured.
    value
        Median over the repetitions, in ``unit``.
    unit
        Unit of the value, such as "ns" or "1/s".
    against
        Name of the figure that this one is compared with.
    ratio_median, ratio_min, ratio_max
        This one's value over the other's, over pairs measured one after the other.
    """

    name: str
    value: float
    unit: str
    against: str | None = None
    ratio_median: float | None = None
    ratio_min: float | None = None
    ratio_max: float | None = None


def beside(
    name: str, values: Sequence[float], unit: str, other: str, others: Sequence[float]
) -> SpeedFigure:
    """Compare with another figure of the same rounds, so that what slows the machine cancels."""
    ratios = [mine / theirs for mine, theirs in zip(values, others, strict=True)]
    return SpeedFigure(name, median(values), unit, other, median(ratios), min(ratios), max(ratios))


def pair(
    name: str, values: Sequence[float], unit: str, other: str, others: Sequence[float]
) -> list[SpeedFigure]:
    """Return a figure beside another one, and that other one."""
    compared = beside(name, values, unit, other, others)
    return [compared, SpeedFigure(other, median(others), unit)]


def in_turns(measured: Mapping[str, Callable[[], float]], rounds: int) -> dict[str, list[float]]:
    """Measure everything once in each round; return the values of each, by name."""
    values: dict[str, list[float]] = {name: [] for name in measured}
    for _ in range(rounds):
        for name, measure in measured.items():
            values[name].append(measure())
    return values


def run_s(simulator: Simulator, vehicles: Vehicles, plan: Sequence[IntArray]) -> float:
    """Return how long a simulator takes to show a plan's phases, one decision after the other."""
    simulator.reset(vehicles)
    begin = perf_counter()
    for phases in plan:
        simulator.advance(phases)
    return perf_counter() - begin


class Decisions(Observer):
    """Notes what was seen and asked for at every decision."""

    def __init__(self) -> None:
        self.queue_veh: list[IntArray] = []
        self.phases: list[IntArray] = []

    def decided(self, seen: Observation, phases: Phases) -> None:
        """Note a decision."""
        self.queue_veh.append(seen.queue_veh)
        self.phases.append(np.asarray(phases, np.int32))
