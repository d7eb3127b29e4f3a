"""What the queue simulator shows where a file's control of a signal runs in SUMO only."""

from __future__ import annotations

from dmil.network import Intersection, RoadNetwork, Stage

STAND_IN_S = 30, 3
"""Green and clearance of the plan that stands in for a control that only SUMO can run (ours)."""


def stand_ins(network: RoadNetwork) -> tuple[str, ...]:
    """Say, one sentence each, where the queue simulator has no program to show (ours)."""
    return tuple(
        f"intersection '{item.id}': its own control ({item.own_control}) runs in SUMO only, so in "
        f"the queue simulator it is no reference; {STAND_IN_S[0]} s for each of its phases in turn "
        "stand in for it"
        for item in network.intersections
        if item.program is None and item.own_control
    )


def stand_in(item: Intersection) -> tuple[Stage, ...]:
    """Return stages that stand in for a control that only SUMO can run, else none (ours).

    They are the phases that serve all movements in turn, `STAND_IN_S` of green and clearance each.
    """
    if not item.own_control:
        return ()
    green_s, clearance_s = STAND_IN_S
    return tuple(
        stage
        for phase in covering_phases(item)
        for stage in (
            Stage(green_s, item.phases[phase]),
            Stage(clearance_s, frozenset(), clearance=True),
        )
    )


def covering_phases(intersection: Intersection) -> list[int]:
    """Return the phases that serve a movement which no earlier one of them serves (ours)."""
    covered: frozenset[int] = frozenset()
    chosen = []
    for phase, movements in enumerate(intersection.phases):
        if not movements <= covered:
            chosen.append(phase)
            covered |= movements
    return chosen or [0]
