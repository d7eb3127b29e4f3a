"""The fixed-time plan nearest to what a controller did: the mean cycle that it drove."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import mean

from dmil.network import Intersection, RoadNetwork
from dmil.training.signal_events import NONE, SignalEvent

RARE = 0.1
"""A phase shown less than this part as often as the most frequent one is no part of a cycle."""
SHORT_GREEN_S = 5
"""Green of a phase that is in a plan only so that no movement waits forever."""
LONGEST_GREEN_S = 90
"""Where there is such a phase, the others are not longer."""


@dataclass(frozen=True, slots=True)
class MeanCycle:
    """A fixed-time plan of one intersection.

    Attributes
    ----------
    phases: tuple of int
        Local numbers, in order.
    green_s: tuple of int
        Seconds of green of each.
    left_out: tuple of int
        Phases that are not in it.
    added: tuple of int
        Those of its phases that were hardly shown or never, for movements else not served.
    never_served: tuple of int
        Movements that no phase of the intersection serves.
    """

    phases: tuple[int, ...]
    green_s: tuple[int, ...]
    left_out: tuple[int, ...]
    added: tuple[int, ...]
    never_served: tuple[int, ...]


def mean_cycles(
    events: Sequence[SignalEvent],
    network: RoadNetwork,
    *,
    begin_s: int,
    end_s: int,
    short_green_s: int = SHORT_GREEN_S,
) -> list[MeanCycle]:
    """Return the mean cycle of every intersection in a part of a run (ours).

    Each phase gets the mean of its greens, in whole seconds. The order is that of the changes that
    were driven most often, from the most frequent phase on. Phases shown hardly ever are left out.
    Movements that this leaves without green get it from added phases with a short one.

    Parameters
    ----------
    events
        Of the whole run, in the order of time.
    network
        The roads.
    begin_s, end_s
        Greens that begin in this part count; where none does, the one that lasts.
    short_green_s
        Green of an added phase.
    """
    greens: list[list[tuple[int, int, int]]] = [[] for _ in network.intersections]
    until_s = [end_s] * len(greens)
    for event in reversed(events):
        i = event.intersection
        green_s = until_s[i] - event.green_from_s
        until_s[i] = event.time_s
        if event.phase == NONE or event.green_from_s >= end_s or green_s <= 0:
            continue
        if event.green_from_s >= begin_s or (not greens[i] and event.time_s < begin_s):
            greens[i].append((event.phase, green_s, event.from_phase))
    pairs = zip(network.intersections, greens, strict=True)
    return [_mean_cycle(item, found[::-1], short_green_s) for item, found in pairs]


def _mean_cycle(
    item: Intersection, greens: list[tuple[int, int, int]], short_green_s: int
) -> MeanCycle:
    shown = Counter(phase for phase, _, _ in greens)
    most = max(shown.values(), default=0)
    cycle = _in_order({phase for phase, times in shown.items() if times >= RARE * most}, greens)
    green_s = {
        phase: max(1, round(mean(each for other, each, _ in greens if other == phase)))
        for phase in cycle
    }
    served = frozenset(item.unsignalled).union(*(item.phases[phase] for phase in cycle))
    waiting = frozenset(range(len(item.movements))) - served
    added = []
    while waiting:
        best = max(range(len(item.phases)), key=lambda phase: len(item.phases[phase] & waiting))
        if not item.phases[best] & waiting:
            break
        waiting -= item.phases[best]
        added.append(best)
        green_s[best] = short_green_s
    if added:
        green_s = {phase: min(each, LONGEST_GREEN_S) for phase, each in green_s.items()}
    phases = (*cycle, *added)
    return MeanCycle(
        phases=phases,
        green_s=tuple(green_s[phase] for phase in phases),
        left_out=tuple(phase for phase in range(len(item.phases)) if phase not in phases),
        added=tuple(added),
        never_served=tuple(sorted(waiting)),
    )


def _in_order(phases: set[int], greens: list[tuple[int, int, int]]) -> list[int]:
    """Follow the most frequent changes from the most frequent phase on."""
    shown = Counter(phase for phase, _, _ in greens)
    changes = Counter((before, phase) for phase, _, before in greens)
    order: list[int] = []
    left = set(phases)
    while left:
        # Ties go to the lower number.
        order.append(max(left, key=lambda p: (changes[order[-1], p] if order else 0, shown[p], -p)))
        left.remove(order[-1])
    return order
