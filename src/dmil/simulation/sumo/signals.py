"""From the phases that are shown to the state strings that SUMO is told."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dmil.network.sumo.records import SumoSignals
from dmil.scenarios import SignalTiming
from dmil.simulation.timing import ACTUATED, NEVER_S, PROGRAM, Signals, grant, rules_of

IntArray = npt.NDArray[np.int32]

GREEN = "Gg"
Switch = tuple[int, str, str]
"""Second of the interval, id of the signals, state string."""


class Orders(NamedTuple):
    """What SUMO's signals are to do in one decision interval.

    Attributes
    ----------
    programs: list of (id, bool)
        Signals that follow a program from now on; whether an actuated one.
    switches: list of (int, str, str)
        Second, signals and state, in the order of the seconds.
    """

    programs: list[tuple[str, bool]]
    switches: list[Switch]


class SignalHeads:
    """The signals of a run: what they show, since when, and how often requests were overruled.

    Parameters
    ----------
    signals
        Who may go in which phase.
    states
        SUMO's names and states of the phases, one per intersection.
    timing
        Signal timing; start-up lost time is SUMO's own matter.
    """

    def __init__(
        self, signals: Signals, states: Sequence[SumoSignals], timing: SignalTiming
    ) -> None:
        count, _, orientations = signals.served.shape
        self._signals, self._states, self._timing = signals, states, timing
        self._rules = rules_of(timing)
        self._go_from_s = np.full((count, orientations), NEVER_S, np.int32)
        self._switch_s = np.full(count, NEVER_S, np.int32)
        self._program = np.zeros(count, np.int32)
        self.phase = np.full(count, -1, np.int32)
        self.green_from_s = np.zeros(count, np.int32)
        self.overruled = 0

    def request(self, wanted: IntArray, time_s: int) -> Orders:
        """Ask for phases; return what follows from it under the rules of signal timing (ours).

        Parameters
        ----------
        wanted: (intersections,) int32
            Phases, `PROGRAM` or `ACTUATED`.
        time_s
            Now.
        """
        before = self.phase.copy()
        self.overruled += grant(
            self._signals,
            np.maximum(wanted, PROGRAM),
            self.phase,
            self.green_from_s,
            self._go_from_s,
            self._switch_s,
            time_s,
            self._rules,
        )
        program = np.minimum(wanted, 0)
        orders = Orders([], [])
        for i in np.flatnonzero((program < 0) & (program != self._program)).tolist():
            orders.programs.append((self._states[i].id, bool(program[i] == ACTUATED)))
        for i in np.flatnonzero(
            (program == 0) & ((before != self.phase) | (self._program < 0))
        ).tolist():
            name, states = self._states[i].id, self._states[i].states
            after = states[self.phase[i]]
            if before[i] < 0:
                orders.switches.append((0, name, after))
            else:
                orders.switches.extend(self._change(name, states[before[i]], after))
        self._program = program
        orders.switches.sort(key=lambda switch: switch[0])
        return orders

    def _change(self, name: str, before: str, after: str) -> list[Switch]:
        """Return yellow, all-red and the new phase, as far as there is time for each."""
        yellow_s = self._timing.clearance_s - self._timing.all_red_s
        switches = []
        if yellow_s > 0:
            switches.append((0, name, cleared(before, after, "y")))
        if self._timing.all_red_s > 0:
            switches.append((yellow_s, name, cleared(before, after, "r")))
        return [*switches, (self._timing.clearance_s, name, after)]


@lru_cache(maxsize=4096)
def cleared(before: str, after: str, losing: str) -> str:
    """Return what signals show between two phases (ours).

    What is green in both stays green, with right of way only if it has it in both. A letter other
    than green or red, such as a turn after a stop, stays where both phases have it.

    Parameters
    ----------
    before, after
        SUMO's states of the two phases.
    losing
        What those see that lose their green: yellow, then red.
    """
    return "".join(_between(old, new, losing) for old, new in zip(before, after, strict=True))


def _between(old: str, new: str, losing: str) -> str:
    if old == new:
        return old
    if old in GREEN:
        if new in GREEN:
            return "g"
        return losing if new == "r" else new
    return old if new in GREEN else "r"
