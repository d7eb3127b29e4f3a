"""Crossings of pedestrians under a controller: with which phases they go, how long they need."""

from __future__ import annotations

import math
from collections.abc import Iterator

from dmil.network.model import Walk
from dmil.network.sumo.net_records import CrossingRecord, Logic, NetFile
from dmil.network.sumo.plan import Links, SignalPlan, is_action

WALKING_M_PER_S = 1.2
LEAST_WALK_S = 5
"""Where a file says nothing: the shortest green of pedestrians."""
_RIGHTS = "gG".find
"""What a letter allows: who turns over a crossing with g gives way to it, with G does not."""


def crossings_of(signal: str, file: NetFile) -> tuple[CrossingRecord, ...]:
    """Return the crossings that a controller's letters stand for, in their order (ours).

    Parameters
    ----------
    signal
        The controller.
    file
        The file.
    """
    mine = (each for each in file.crossings if each.signal == signal)
    return tuple(sorted(mine, key=lambda each: each.letter))


def walk_of(
    crossing: CrossingRecord, logic: Logic, plan: SignalPlan, links: Links, file: NetFile
) -> Walk:
    """Find out when pedestrians go, and how long it takes them to clear a crossing (ours).

    Clearing takes as long as the plan leaves between their green and that of vehicles that cross
    them; where other vehicles go in between, no longer than the walk does at 1.2 m/s, and that is
    also what counts where the plan does not say.

    Parameters
    ----------
    crossing
        The crossing.
    logic
        The controller's program.
    plan, links
        What was made of it, and for every movement its indices into the state strings.
    file
        The file, for who crosses whom.
    """
    foes = file.foes.get((crossing.junction, crossing.row), frozenset())
    letters = {
        way.letter
        for way in file.connections
        if way.signal == logic.id and way.junction == crossing.junction and way.row in foes
    }
    needed_s = math.ceil(crossing.length_m / WALKING_M_PER_S)
    greens, clearing = [], []
    for green_s, to_next_s, to_foe_s in _walks(crossing.letter, letters, logic, links):
        greens.append(green_s)
        if to_foe_s is not None:
            enough_s = max(to_next_s or 0.0, needed_s)
            clearing.append(to_foe_s if to_foe_s == to_next_s else min(to_foe_s, enough_s))
    return Walk(
        phases=frozenset(
            p for p, state in enumerate(plan.states) if state[crossing.letter] in "Gg"
        ),
        least_s=math.ceil(min([LEAST_WALK_S, *greens])),
        clear_s=math.ceil(max(clearing)) if clearing else needed_s,
    )


def _walks(
    letter: int, foes: set[int], logic: Logic, links: Links
) -> Iterator[tuple[float, float | None, float | None]]:
    """Return of every green of pedestrians its length, and the times to vehicles' and foes'."""
    stages = logic.stages
    count = len(stages)
    vehicles = {j for own in links for j in own}
    for k, stage in enumerate(stages):
        if stage.state[letter] not in "Gg" or stages[k - 1].state[letter] in "Gg":
            continue
        length = 0
        while length < count and stages[(k + length) % count].state[letter] in "Gg":
            length += 1
        green_s = sum(stages[(k + step) % count].duration_s for step in range(length))
        last = stages[(k + length - 1) % count].state
        to_next_s = to_foe_s = None
        since_s = 0.0
        for step in range(length, count):
            following = stages[(k + step) % count]
            begin = {j for j, now in enumerate(following.state) if _RIGHTS(now) > _RIGHTS(last[j])}
            if to_next_s is None and is_action(following.state, links) and vehicles & begin:
                to_next_s = since_s
            if foes & begin:
                to_foe_s = since_s
                break
            since_s += following.duration_s
        yield green_s, to_next_s, to_foe_s
