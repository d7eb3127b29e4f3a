"""State strings of signals, for networks that SUMO does not know yet."""

from __future__ import annotations

from dmil.network.model import Intersection
from dmil.network.program import Stage
from dmil.network.sumo.records import SumoSignals

GREEN_S, YELLOW_S = 20.0, 3.0
"""Stages of the program of an intersection that has none of its own."""


def signals_of(item: Intersection, name: str) -> SumoSignals:
    """Return a state string for every phase, with one letter per lane of a movement (ours)."""
    first, links = 0, []
    for movement in item.movements:
        links.append(tuple(range(first, first + len(movement.lanes))))
        first += len(movement.lanes)
    states = tuple(_state(item, phase) for phase in item.phases)
    return SumoSignals(name, states, tuple(links))


def _state(item: Intersection, green: frozenset[int], losing: frozenset[int] = frozenset()) -> str:
    """Return the state in which some movements have green and some yellow."""
    letters = []
    for j, movement in enumerate(item.movements):
        if j in item.unsignalled or (j in green and _yields(item, j, green)):
            letter = "g"
        elif j in green:
            letter = "G"
        else:
            letter = "y" if j in losing else "r"
        letters += [letter] * len(movement.lanes)
    return "".join(letters)


def _yields(item: Intersection, j: int, green: frozenset[int]) -> bool:
    """Whether a movement gives way to another one that has green in the same phase."""
    if item.gives_way:
        return not green.isdisjoint(item.gives_way[j])
    movement = item.movements[j]
    others = [item.movements[k] for k in green if item.movements[k].approach != movement.approach]
    if movement.turn == "straight":
        return False
    return any(
        other.to_link == movement.to_link or (movement.turn != "right" and other.turn == "straight")
        for other in others
    )


def stages_of(item: Intersection) -> list[tuple[float, str]]:
    """Return durations in s and states of the own program, or of each phase in turn (ours).

    A green that no clearance follows ends with yellow.
    """
    if item.program:
        stages = list(item.program.stages)
    else:
        stages = [Stage(GREEN_S + YELLOW_S, phase) for phase in item.phases]
    result = []
    for k, stage in enumerate(stages):
        before, after = stages[k - 1], stages[(k + 1) % len(stages)]
        losing = before.green - stage.green if stage.clearance else frozenset()
        ends = stage.green - after.green
        abrupt = bool(ends) and not stage.clearance and not after.clearance
        yellow_s = YELLOW_S if abrupt and stage.duration_s > YELLOW_S else 0.0
        result.append((stage.duration_s - yellow_s, _state(item, stage.green, losing)))
        if yellow_s:
            result.append((yellow_s, _state(item, stage.green & after.green, ends)))
    return result
