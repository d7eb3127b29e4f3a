"""From the phases that are asked for to the light phases that CityFlow is told."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from dmil.arrays import IntArray
from dmil.network import RoadNetwork
from dmil.scenarios import SignalTiming
from dmil.simulation.cityflow.files import Lights
from dmil.simulation.timing import NEVER_S, PROGRAM, grant, programs_of, rules_of, signals_of

Switch = tuple[int, str, int]
"""Second of the interval, intersection, light phase."""


class LightHeads:
    """The signals of a run: what they show, since when, and how often requests were overruled.

    Parameters
    ----------
    network, timing
        Roads and signal timing; start-up lost time is CityFlow's own matter.
    lights
        Which light phase shows what.
    begins
        Whether all signals have shown their first phase before the run, so that another one begins
        with a clearance.
    """

    def __init__(
        self, network: RoadNetwork, timing: SignalTiming, lights: Lights, *, begins: bool
    ) -> None:
        self._ids = [item.id for item in network.intersections]
        self._signals, self._rules = signals_of(network), rules_of(timing, network)
        self._programs, self._lights = programs_of(network), lights
        count, _, width = self._signals.served.shape
        self._go_from_s = np.full((count, width), NEVER_S, np.int32)
        self._switch_s = np.full(count, NEVER_S, np.int32)
        self._later: list[Switch] = []
        self.phase = np.full(count, 0 if begins else -1, np.int32)
        self.green_from_s = np.zeros(count, np.int32)
        self.overruled = 0

    def first(self) -> list[Switch]:
        """Return what the signals show before the first decision."""
        shown = zip(self._ids, self._lights.phases, self.phase.tolist(), strict=True)
        return [(0, name, phases[p]) for name, phases, p in shown if phases and p >= 0]

    def request(self, wanted: IntArray, time_s: int) -> list[Switch]:
        """Ask for phases, `PROGRAM` among them; return what follows in this interval (ours)."""
        before = self.phase.copy()
        self.overruled += grant(
            self._signals,
            wanted,
            self.phase,
            self.green_from_s,
            self._go_from_s,
            self._switch_s,
            time_s,
            self._rules,
        )
        interval_s = self._rules.decision_interval_s
        switches = self._later
        for i in np.flatnonzero((before != self.phase) & (self.phase >= 0)).tolist():
            switches += self._change(i, int(before[i]), int(self.phase[i]))
        for i in np.flatnonzero(wanted == PROGRAM).tolist():
            # Its stages take over at once from what was still to come.
            switches = [each for each in switches if each[1] != self._ids[i]]
            switches += self._program(i, time_s, interval_s)
        switches.sort(key=lambda each: each[0])
        self._later = [(s - interval_s, *rest) for s, *rest in switches if s >= interval_s]  # type: ignore[misc]
        return [each for each in switches if each[0] < interval_s]

    def _change(self, i: int, before: int, after: int) -> Iterator[Switch]:
        phases = self._lights.phases[i]
        if not phases:
            return
        clear_s = int(self._rules.clearance_s[i, before, after]) if before >= 0 else 0
        if clear_s:
            yield 0, self._ids[i], self._lights.clearances[i][before, after]
        yield clear_s, self._ids[i], phases[after]

    def _program(self, i: int, time_s: int, interval_s: int) -> Iterator[Switch]:
        first, last = self._programs.offset[i : i + 2].tolist()
        stages, ends = self._lights.stages[i], self._programs.end_s[first:last]
        shown = -1
        for second in range(interval_s if stages else 0):
            place_s = (time_s + second + int(self._programs.begin_s[i])) % int(ends[-1])
            stage = int(np.searchsorted(ends, place_s, side="right"))
            if stage != shown:
                shown = stage
                yield second, self._ids[i], stages[stage]
