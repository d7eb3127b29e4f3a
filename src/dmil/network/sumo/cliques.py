"""Phases from the conflicts between movements alone: sets in which nobody crosses anybody."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby, islice

from dmil.network.model import Movement

MOST_PHASES = 16
_MOST_SETS = 4096
"""Several junctions under one controller multiply their sets; the first ones are enough."""


def conflict_free_phases(
    movements: Sequence[Movement],
    conflicts: frozenset[tuple[int, int]],
    wanted: frozenset[int],
    *,
    need: frozenset[int] | None = None,
) -> tuple[frozenset[int], ...]:
    """Choose sets of movements that may go together and need no yielding (ours).

    A set is as large as it can be. It opens a lane if it serves all movements of that lane: on a
    shared lane one vehicle that may not go stops all behind it. Right turns ride along: sets that
    open most other lanes come first, and a set is left out if another one opens the same ones and
    more, unless a movement needs it. Equal sets are taken together or not at all, so that a
    symmetric intersection gets symmetric phases.

    Parameters
    ----------
    movements
        All movements of the intersection.
    conflicts
        Pairs of them that cross.
    wanted
        Those that the phases are made of.
    need
        Those that must be in a phase; if given, only the phases that they need are returned.

    Returns
    -------
    tuple of frozenset
        At most 16 phases, or as many as it takes to serve every movement.
    """
    friends = {
        i: {j for j in wanted if j != i and (i, j) not in conflicts and (j, i) not in conflicts}
        for i in wanted
    }
    uses: dict[tuple[str, int], set[int]] = {}
    for i in sorted(wanted):
        for lane in movements[i].lanes:
            uses.setdefault((movements[i].from_link, lane), set()).add(i)
    main = {
        lane for lane, users in uses.items() if any(movements[i].turn != "right" for i in users)
    }

    def open_lanes(served: frozenset[int]) -> set[tuple[str, int]]:
        return {lane for lane in main if uses[lane] <= served}

    def worth(served: frozenset[int]) -> tuple[int, int]:
        return len(open_lanes(served)), sum(len(movements[i].lanes) for i in served)

    found = set(islice(_maximal(set(), set(wanted), set(), friends), _MOST_SETS))
    found |= {_grown(i, movements, friends) for i in wanted}
    sets = sorted(found, key=lambda served: (*(-number for number in worth(served)), *served))
    chosen = _cover(sets, wanted if need is None else need)
    if need is None:
        best = [s for s in sets if not any(open_lanes(s) < open_lanes(other) for other in sets)]
        for _, equal in groupby(best, key=worth):
            new = [served for served in equal if served not in chosen]
            if len(chosen) + len(new) > MOST_PHASES:
                break
            chosen += new
    return tuple(sorted(chosen, key=sets.index))


def _cover(sets: list[frozenset[int]], need: frozenset[int]) -> list[frozenset[int]]:
    chosen: list[frozenset[int]] = []
    while need:
        best = max(sets, key=lambda served: len(served & need))  # of equal ones the first
        chosen.append(best)
        need -= best
    return chosen


def _grown(
    seed: int, movements: Sequence[Movement], friends: dict[int, set[int]]
) -> frozenset[int]:
    """Return one largest set around a movement, taking those with most lanes first."""
    served, left = {seed}, set(friends[seed])
    while left:
        best = min(left, key=lambda i: (-len(movements[i].lanes), i))
        served.add(best)
        left &= friends[best]
    return frozenset(served)


def _maximal(
    inside: set[int], left: set[int], done: set[int], friends: dict[int, set[int]]
) -> Iterator[frozenset[int]]:
    """Enumerate the maximal cliques (Bron and Kerbosch, 1973, with a pivot)."""
    if not left and not done:
        yield frozenset(inside)
        return
    pivot = max(sorted(left | done), key=lambda i: len(friends[i] & left))
    for i in sorted(left - friends[pivot]):
        yield from _maximal(inside | {i}, left & friends[i], done & friends[i], friends)
        left = left - {i}
        done = done | {i}
