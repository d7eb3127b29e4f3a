"""How long the factored memory's decision takes for a city of 10,000 intersections, all at once.

The city is a square grid of the paper's intersections, fully built as any network is. What is seen
of it is drawn at random around the paper's load, anew for each of several decisions in turn; the
signals show what was asked for, so that every decision learns from the one before.
"""

from __future__ import annotations

from statistics import median
from time import perf_counter

import numpy as np

from dmil.arrays import FloatArray, IntArray
from dmil.benchmarks.figures import SpeedFigure
from dmil.controllers import RunContext
from dmil.controllers.lanes.factored import FactoredController
from dmil.network import grid
from dmil.scenarios import SignalTiming
from dmil.seeding import stream
from dmil.simulation import Observation

SIDE = 100
DECISIONS = 60
SIGHTS = 6
MEAN_QUEUE_VEH, MEAN_APPROACHING_VEH = 1.0, 0.5


def city_figures(*, side: int = SIDE, decisions: int = DECISIONS) -> list[SpeedFigure]:
    """Measure the factored memory's decision, learning included; figures are medians."""
    figures = []
    for signals, timing in (("", SignalTiming()), (" with clearance", SignalTiming(clearance_s=3))):
        name = f"factored memory's decision for {side * side} intersections{signals}"
        figures.append(SpeedFigure(name, _decision_ms(side, timing, decisions), "ms"))
    return figures


def _decision_ms(side: int, timing: SignalTiming, decisions: int) -> float:
    controller = FactoredController()
    controller.reset(RunContext(grid(side, side), timing, stream(0, "benchmark", "city")))
    sights = [_sight(side, k) for k in range(SIGHTS)]
    shown = np.full(side * side, -1, np.int32)
    times_ms = []
    # The first decision has nothing to learn from, and may have to be compiled.
    for k in range(1 + decisions):
        queue_veh, approaching_veh, waiting_veh = sights[k % SIGHTS]
        seen = Observation(queue_veh, approaching_veh, shown, shown, 10 * k, waiting_veh)
        begin = perf_counter()
        shown = controller.decide(seen, None)
        times_ms.append((perf_counter() - begin) * 1e3)
    return median(times_ms[1:])


def _sight(side: int, number: int) -> tuple[IntArray, IntArray, FloatArray]:
    rng = stream(number, "benchmark", "city")
    shape = side * side, 12
    queue_veh = rng.poisson(MEAN_QUEUE_VEH, shape).astype(np.int32)
    approaching_veh = rng.poisson(MEAN_APPROACHING_VEH, shape).astype(np.int32)
    return queue_veh, approaching_veh, queue_veh + rng.random(shape)
