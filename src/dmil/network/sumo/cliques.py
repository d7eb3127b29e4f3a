"""Phases from the conflicts between movements alone: sets of movements that do not conflict."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby, islice

from dmil.network.model import Movement

MOST_PHASES = 16
_MOST_SETS = 1024
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
    shared lane one vehicle that may not go stops all behind it. Right turns and u-turns ride
    along: sets that open most lanes of others come first, and a set is left out if another one
    opens the same ones and serves more, unless a movement needs it. Equal sets are taken together
    or not at all, so that a symmetric intersection gets symmetric phases.

    The phases are made of the wanted movements, at most 16, or as many as it takes to serve every
    one. If ``need`` is given, only the phases that those movements need are returned.
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
        lane
        for lane, users in uses.items()
        if any(movements[i].turn in ("straight", "left") for i in users)
    }

    def open_lanes(served: frozenset[int]) -> set[tuple[str, int]]:
        return {lane for lane in main if uses[lane] <= served}

    found = set(islice(_maximal(set(), set(wanted), set(), friends), _MOST_SETS))
    opens = {served: open_lanes(served) for served in found}
    worth = {s: (len(opens[s]), sum(len(movements[i].lanes) for i in s)) for s in found}
    sets = sorted(found, key=lambda served: (*(-number for number in worth[served]), *served))
    chosen = _cover(sets, wanted if need is None else need, friends)
    if need is None:
        best = [
            s
            for s in sets
            if not any(opens[s] <= opens[other] and worth[s] < worth[other] for other in sets)
        ]
        for _, equal in groupby(best, key=worth.__getitem__):
            new = [served for served in equal if served not in chosen]
            if len(chosen) + len(new) > MOST_PHASES:
                break
            chosen += new
    order = {served: index for index, served in enumerate(sets)}
    return tuple(sorted(chosen, key=lambda served: (order.get(served, len(order)), *served)))


def _cover(
    sets: list[frozenset[int]], need: frozenset[int], friends: dict[int, set[int]]
) -> list[frozenset[int]]:
    """Return few sets that have all the needed movements; of equally good ones the first."""
    chosen: list[frozenset[int]] = []
    while need:
        # The sets may be the first of too many: one grown around what is missing may be better.
        best = max((*sets, _grown(need, friends)), key=lambda served: len(served & need))
        chosen.append(best)
        need -= best
    return chosen


def _grown(need: frozenset[int], friends: dict[int, set[int]]) -> frozenset[int]:
    """Return one largest set, taking the needed ones first, those with fewest conflicts first."""
    served: set[int] = set()
    left = set(friends)
    while left:
        best = min(left, key=lambda i: (i not in need, -len(friends[i]), i))
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
