"""Which phases of a CityFlow light are actions, which are clearance, and who gives way in them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from dmil.network.cityflow_geometry import Segments, cross
from dmil.network.model import Movement, Turn
from dmil.network.program import Program, Stage, longest_clearance_s

YELLOW_S = 6.0
"""Longest yellow; so long is none for which a movement first gets green (MUTCD 4F.17: 3 to 6 s)."""
CLEARANCE_S = 12.0
"""Longest clearance without any green: a yellow and an all-red of at most 6 s (ibidem)."""
_RANK: dict[Turn, int] = {"straight": 3, "left": 2, "right": 1, "uturn": 0}
"""CityFlow's ``RoadLinkType``: where two ways cross, the lower one yields."""

Served = tuple[frozenset[int], float]
"""Movements that may go in a phase of the file, and its seconds."""


@dataclass(frozen=True, slots=True)
class Phases:
    """The phases of a light, sorted (ours).

    Parameters
    ----------
    actions
        Movements of each, in the file's order, those that always may go left out.
    unsignalled
        Movements that always may go.
    program
        All phases as a fixed-time plan, None if it has no green.
    clearance_s
        Longest time from one action to the next; 0 where there is one action.
    """

    actions: tuple[frozenset[int], ...]
    unsignalled: frozenset[int]
    program: Program | None
    clearance_s: float


def sort_phases(served: Sequence[Served]) -> Phases:
    """Tell actions from clearance (ours: the file does not say which is which).

    Clearance is a phase in which nobody goes but those who always may, for at most `CLEARANCE_S`;
    and one of at most `YELLOW_S` between two longer ones in which only those go who have green
    before or after it: some of them still clear, or begin earlier. All others are actions, a long
    phase for those alone who always may go among them: they have their signal then. At least one
    phase has to serve somebody.
    """
    shown = {phase for phase, _ in served if phase}
    # With a single phase "in every phase" says nothing: it is an action, not a right of way.
    always = frozenset.intersection(*(phase for phase, _ in served)) if len(shown) > 1 else None
    unsignalled = always or frozenset()
    if any(phase == unsignalled and time_s > CLEARANCE_S for phase, time_s in served if phase):
        unsignalled = frozenset()
    clearance = [
        (not phase - (always or frozenset()) and time_s <= CLEARANCE_S)
        or _is_transition(index, served)
        for index, (phase, time_s) in enumerate(served)
    ]
    stages = [
        Stage(time_s, phase - unsignalled, clearance=clears)
        for (phase, time_s), clears in zip(served, clearance, strict=True)
    ]
    actions = tuple(
        dict.fromkeys(each.green for each in stages if each.green and not each.clearance)
    )
    timed = tuple(each for each in stages if each.duration_s > 0)
    return Phases(
        actions,
        unsignalled,
        Program(timed) if any(each.green and not each.clearance for each in timed) else None,
        longest_clearance_s([(each.duration_s, each.clearance) for each in timed])
        if len(actions) > 1
        else 0.0,
    )


def _is_transition(index: int, served: Sequence[Served]) -> bool:
    """Whether a short phase only ends the green before it, or begins the one after it."""
    phase, time_s = served[index]
    # A phase of no time is never shown by the plan: it is an action for others to choose.
    if not 0 < time_s <= YELLOW_S:
        return False
    around = [served[(index + step) % len(served)] for step in range(1, len(served))]
    greens = [each for each, long_s in around if long_s > YELLOW_S]
    if not greens:
        return False
    after, before = greens[0], greens[-1]
    return phase <= before | after and phase not in (before, after)


def give_way(
    movements: Sequence[Movement], ways: Sequence[Segments], served: Sequence[Served]
) -> tuple[tuple[int, ...], ...]:
    """Find the movements that each movement yields to, as at CityFlow's crossing lane links.

    Where the ways of two movements cross that have green in one phase, the turn yields: left to
    straight on, right to left, and a U-turn to all (``Cross::canPass`` in ``roadnet.cpp``). Two of
    one kind go in the order in which they come. A right turn does not yield to those who leave by
    the same road (ours): in CityFlow it does so only for the lane that it takes there.

    The pieces of ways are those of `dmil.network.cityflow_geometry.way_segments`. The result has an
    entry for every movement, and is empty where nobody yields.
    """
    together = {(i, j) for phase, _ in served for i in phase for j in phase}
    yields = tuple(
        tuple(
            j
            for j, other in enumerate(movements)
            if (i, j) in together
            and _RANK[movement.turn] < _RANK[other.turn]
            and movement.from_link != other.from_link
            and not (movement.turn == "right" and movement.to_link == other.to_link)
            and cross(ways[i], ways[j])
        )
        for i, movement in enumerate(movements)
    )
    return yields if any(yields) else ()
