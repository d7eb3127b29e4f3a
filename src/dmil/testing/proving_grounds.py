"""Where parts are checked: small scenarios that differ in what a part might take for granted."""

from __future__ import annotations

from collections.abc import Mapping

from dmil.demand import PoissonDemand
from dmil.network import Intersection, Link, Movement, Program, RoadNetwork, Stage, Turn
from dmil.scenarios import QueueDynamics, Scenario, SignalTiming, scenario

HORIZON_S = 300
UNEVEN_RATE_VEH_PER_MIN = 8.0

Movements = tuple[Movement, ...]

_LANES: dict[int, tuple[tuple[int, ...], ...]] = {
    1: ((0, 1),),
    2: ((0,), (1,)),
    3: ((0,), (0, 1), (1,)),
}
"""Lanes of one, two or three movements on a road of two."""
_TURNS: Mapping[int, Turn] = {1: "right", 2: "straight", 3: "left"}
_STEPS_M = ((200.0, 0.0), (0.0, 100.0), (-200.0, 0.0), (0.0, -100.0))
_AROUND = {
    "A": {0: "B", 1: "A north", 2: "A west"},
    "B": {0: "C", 1: "B north", 2: "A", 3: "B south"},
    "C": {1: "C north", 2: "B", 3: "C south"},
}
"""Neighbours of every intersection by side, E, N, W, S."""


def proving_grounds() -> tuple[Scenario, ...]:
    """Return the scenarios on which parts are checked.

    The paper's single intersection; a grid that is not square; and an uneven row of intersections
    with three and four ways, six and eight movements, three, two and a single phase, roads of
    different lengths, decisions every 5 s, and signals that refuse to change too soon.
    """
    uneven = uneven_network()
    rates = {node: UNEVEN_RATE_VEH_PER_MIN for node in uneven.fringe}
    timing = SignalTiming(decision_interval_s=5, clearance_s=2, min_green_s=10)
    return (
        scenario("grid:1x1", horizon_s=HORIZON_S),
        scenario("grid:2x3", horizon_s=HORIZON_S),
        Scenario(uneven.name, uneven, PoissonDemand(rates), timing, QueueDynamics(), HORIZON_S),
    )


def uneven_network() -> RoadNetwork:
    """Build a row of a three-way, a four-way and a three-way junction, no two alike."""
    position_m = {"A": (0.0, 0.0), "B": (200.0, 0.0), "C": (400.0, 0.0)}
    links: dict[str, Link] = {}
    for node, around in _AROUND.items():
        for side, other in around.items():
            x_m, y_m = position_m[node]
            position_m.setdefault(other, (x_m + _STEPS_M[side][0], y_m + _STEPS_M[side][1]))
            for start, end in ((node, other), (other, node)):
                length_m = abs(_STEPS_M[side][0] + _STEPS_M[side][1])
                link = Link(f"{start}>{end}", start, end, length_m, 12.5, 2)
                links.setdefault(link.id, link)
    return RoadNetwork(
        name="uneven",
        links=tuple(links.values()),
        intersections=(_one_phase_per_side("A"), _two_phases_without_left("B"), _single_phase("C")),
        fringe=tuple(node for node in position_m if node not in _AROUND),
        position_m=position_m,
    )


def _movements(node: str, turns: tuple[Turn, ...] = ("right", "straight", "left")) -> Movements:
    around = _AROUND[node]
    sides = sorted(around)
    ways = {
        side: [
            (turn, around[(side + step) % 4])
            for step, turn in _TURNS.items()
            if turn in turns and (side + step) % 4 in around
        ]
        for side in sides
    }
    return tuple(
        Movement(
            f"{around[side]}>{node}",
            f"{node}>{goal}",
            turn,
            sides.index(side),
            _LANES[len(ways[side])][place],
        )
        for side in sides
        for place, (turn, goal) in enumerate(ways[side])
    )


def _one_phase_per_side(node: str) -> Intersection:
    movements = _movements(node)
    phases = tuple(
        frozenset(j for j, movement in enumerate(movements) if movement.approach == side)
        for side in range(len(_AROUND[node]))
    )
    return Intersection(node, movements, phases, frozenset())


def _two_phases_without_left(node: str) -> Intersection:
    movements = _movements(node, ("right", "straight"))
    right = frozenset(j for j, movement in enumerate(movements) if movement.turn == "right")
    phases = tuple(
        frozenset(j for j, movement in enumerate(movements) if movement.approach % 2 == axis)
        - right
        for axis in range(2)
    )
    return Intersection(
        node, movements, phases, right, program=Program(tuple(map(Stage, (20.0, 15.0), phases)))
    )


def _single_phase(node: str) -> Intersection:
    movements = _movements(node)
    return Intersection(node, movements, (frozenset(range(len(movements))),), frozenset())
