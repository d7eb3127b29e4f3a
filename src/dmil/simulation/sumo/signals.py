"""From the phases that are shown to the state strings that SUMO is told."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dmil.network import Intersection, RoadNetwork
from dmil.network.sumo.records import SumoSignals
from dmil.scenarios import SignalTimes
from dmil.scenarios.timing import dont_walk_s
from dmil.simulation.timing import ACTUATED, NEVER_S, PROGRAM, Rules, Signals, grant

IntArray = npt.NDArray[np.int32]

GREEN = "Gg"
Switch = tuple[int, str, str]
"""Second of the interval, id of the signals, state string."""


WalkEnds = tuple[tuple[tuple[int, str], ...], ...]
"""For every phase: seconds after its green begins, and the state from then on."""


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
    times
        Signal timing; start-up lost time is SUMO's own matter.
    interval_s
        Time between two requests.
    walks
        When the pedestrians of every phase stop setting out, one per intersection, see `walk_ends`.
    """

    def __init__(
        self,
        signals: Signals,
        states: Sequence[SumoSignals],
        times: SignalTimes,
        interval_s: int,
        walks: Sequence[WalkEnds],
    ) -> None:
        count, _, width = signals.served.shape
        self._signals, self._states, self._times = signals, states, times
        self._rules = Rules(
            decision_interval_s=interval_s,
            startup_lost_s=0,
            clearance_s=times.clearance_s,
            min_green_s=times.min_green_s,
            max_green_s=times.max_green_s,
            all_stop=times.all_stop,
        )
        # None where those who have green before and after a change keep it.
        self._staying = [
            going_on(each, np.flatnonzero(always).tolist()) if stops else None
            for each, always, stops in zip(states, signals.unsignalled, times.all_stop, strict=True)
        ]
        self._later: list[Switch] = []
        self._walks = walks
        self._go_from_s = np.full((count, width), NEVER_S, np.int32)
        self._switch_s = np.full(count, NEVER_S, np.int32)
        self._program = np.zeros(count, np.int32)
        self.phase = np.full(count, -1, np.int32)
        self.green_from_s = np.zeros(count, np.int32)
        self.overruled = 0

    def request(self, wanted: IntArray, time_s: int) -> Orders:
        """Ask for phases; return what follows from it under the rules of signal timing (ours).

        ``wanted`` is (intersections,) int32: phases, `PROGRAM` or `ACTUATED`.
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
        # A clearance may be longer than the time between two requests; the rules refuse changes
        # until it is over, but a program of SUMO's takes over at once.
        taken = {name for name, _ in orders.programs}
        switches = [each for each in self._later if each[1] not in taken]
        for i in np.flatnonzero(
            (program == 0) & ((before != self.phase) | (self._program < 0))
        ).tolist():
            name, states = self._states[i].id, self._states[i].states
            after, start_s = states[self.phase[i]], 0
            if before[i] >= 0:
                change = (i, before[i], self.phase[i])
                all_red_s = int(self._times.all_red_s[change])
                yellow_s = int(self._times.clearance_s[change]) - all_red_s
                old = stopped(states[before[i]], self._states[i].crossings)
                for lasts_s, losing in ((yellow_s, "y"), (all_red_s, "r")):
                    if lasts_s > 0:
                        switches.append(
                            (start_s, name, cleared(old, after, losing, self._staying[i]))
                        )
                        start_s += lasts_s
            switches.append((start_s, name, after))
            switches += [(start_s + s, name, state) for s, state in self._walks[i][self.phase[i]]]
        self._program = program
        switches.sort(key=lambda switch: switch[0])
        interval_s = self._rules.decision_interval_s
        orders.switches.extend(each for each in switches if each[0] < interval_s)
        self._later = [
            (second - interval_s, name, state)
            for second, name, state in switches
            if second >= interval_s
        ]
        return orders


def stopped(state: str, crossings: Collection[int]) -> str:
    """Return a state with red for some crossings of pedestrians, indices into it (ours)."""
    return "".join("r" if k in crossings else letter for k, letter in enumerate(state))


def walk_ends(
    network: RoadNetwork, states: Sequence[SumoSignals], times: SignalTimes
) -> list[WalkEnds]:
    """Return when the pedestrians of every phase stop setting out (ours).

    When a green will end is not known while it runs, so pedestrians set out at its beginning only:
    as long as leaves them time to clear the crossing if it ends as soon as it may.
    """
    found = []
    for i, (item, heads) in enumerate(zip(network.intersections, states, strict=True)):
        ends: list[tuple[tuple[int, str], ...]] = []
        for phase, state in enumerate(heads.states):
            least_s, switches = int(times.min_green_s[i, phase]), []
            for end_s, letters in setting_out(heads, least_s, times, item, i, phase):
                state = stopped(state, letters)
                switches.append((end_s, state))
            ends.append(tuple(switches) if len(item.phases) > 1 else ())
        found.append(tuple(ends))
    return found


def setting_out(
    heads: SumoSignals, green_s: int, times: SignalTimes, item: Intersection, i: int, phase: int
) -> list[tuple[int, list[int]]]:
    """Return when pedestrians stop setting out, so that they have cleared, and their letters."""
    ends: dict[int, list[int]] = {}
    for letter, walk in zip(heads.crossings, item.walks, strict=True):
        if phase in walk.phases:
            end_s = green_s - dont_walk_s(times, item, i, phase, walk)
            ends.setdefault(end_s, []).append(letter)
    return sorted(ends.items())


def going_on(heads: SumoSignals, unsignalled: Iterable[int]) -> frozenset[int]:
    """Return the letters that no clearance stops: those of movements that always may go (ours)."""
    return frozenset(letter for movement in unsignalled for letter in heads.links[movement])


@lru_cache(maxsize=4096)
def cleared(before: str, after: str, losing: str, staying: frozenset[int] | None = None) -> str:
    """Return what signals show between the states of two phases (ours).

    What is green in both stays green, with right of way only if it has it in both. A letter other
    than green or red, such as a turn after a stop, stays where both phases have it. Those that lose
    their green see ``losing``: yellow, then red. If everybody stops, only the letters ``staying``
    stay green.
    """
    return "".join(
        losing
        if old in GREEN and staying is not None and k not in staying
        else _between(old, new, losing)
        for k, (old, new) in enumerate(zip(before, after, strict=True))
    )


def _between(old: str, new: str, losing: str) -> str:
    if old == new:
        return old
    if old in GREEN:
        if new in GREEN:
            return "g"
        return losing if new == "r" else new
    return old if new in GREEN else "r"
