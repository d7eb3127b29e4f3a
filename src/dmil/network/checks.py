"""Whether a network is consistent: one clear error for the first thing that is not."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable
from functools import partial

from dmil.errors import NetworkError
from dmil.network.model import TURNS, Intersection, Link, Movement, RoadNetwork

LONGEST_S = 10**8
"""Longest time on a link, three years: steps are counted in 32 bits."""


def check_network(network: RoadNetwork, *, where: str | None = None) -> None:
    """Check that links, movements and phases fit together (ours).

    Parameters
    ----------
    network
        The network; nothing about it is assumed.
    where
        File that it comes from; the network's name if not given.

    Raises
    ------
    NetworkError
        Naming the first link, movement or phase that is wrong, and how to mend it.
    """
    where = where or network.name
    if not network.intersections:
        raise NetworkError("there is no intersection", where=where, expected="at least one")
    _unique((link.id for link in network.links), "link", where)
    nodes = [node.id for node in network.intersections]
    nodes += [junction.id for junction in network.junctions]
    nodes += network.fringe
    _unique(nodes, "node", where)
    known = set(nodes)
    for link in network.links:
        _check_link(link, known, f"{where}: link {link.id}")
    for node in nodes:
        if not all(map(math.isfinite, network.position_m.get(node, (math.nan,)))):
            raise NetworkError(
                "its position is missing or not finite",
                where=f"{where}: node {node}",
                expected="x and y in metres for every node",
            )
    links = {link.id: link for link in network.links}
    for node_ in network.intersections:
        place = f"{where}: intersection {node_.id}"
        _check_movements(node_.id, node_.movements, links, place)
        _check_phases(node_, place)
        _check_plan(node_, place)
        _check_priority(node_, place)
    for junction in network.junctions:
        place = f"{where}: junction {junction.id}"
        _check_movements(junction.id, junction.movements, links, place)


def _unique(names: Iterable[str], kind: str, where: str) -> None:
    for name, count in Counter(names).items():
        if count > 1:
            raise NetworkError(
                f"{count} {kind}s are named '{name}'",
                where=where,
                expected=f"a unique name for every {kind}",
                mend=f"rename all but one {kind}",
            )


def _check_link(link: Link, known: set[str], where: str) -> None:
    wrong = partial(NetworkError, where=where)
    for end, node in (("starts", link.start), ("ends", link.end)):
        if node not in known:
            raise wrong(
                f"it {end} at '{node}', which is neither an intersection nor a fringe node",
                mend="add that node, or correct the link",
            )
    if not (math.isfinite(link.length_m) and link.length_m >= 0):
        raise wrong(f"its length is {link.length_m} m", expected="a number of 0 m or more")
    if not (math.isfinite(link.speed_m_per_s) and link.speed_m_per_s > 0):
        raise wrong(f"its speed is {link.speed_m_per_s} m/s", expected="a number above 0 m/s")
    if not link.length_m / link.speed_m_per_s <= LONGEST_S:
        raise wrong(
            f"to drive along it takes {link.length_m / link.speed_m_per_s:.3g} s "
            f"({link.length_m:g} m at {link.speed_m_per_s:g} m/s)",
            expected=f"at most {LONGEST_S:,} s",
        )
    if not (isinstance(link.lanes, int) and link.lanes >= 1):
        raise wrong(f"it has {link.lanes} lanes", expected="a whole number, at least 1")
    if not link.closed < frozenset(range(link.lanes)):
        raise wrong(
            f"of its {link.lanes} lanes {sorted(link.closed)} are closed",
            expected=f"lanes from 0 to {link.lanes - 1}, at least one of them open",
        )


def _check_movements(
    node: str, movements: tuple[Movement, ...], links: dict[str, Link], where: str
) -> None:
    wrong = partial(NetworkError, where=where)
    if not movements:
        raise wrong(
            "it has no movements",
            expected="at least one way from a link to a link",
            mend="make it a fringe node if vehicles only begin or end there",
        )
    for index, movement in enumerate(movements):
        _check_movement(movement, node, links, f"{where}, movement {index}")
    _unique(
        (f"{movement.from_link} to {movement.to_link}" for movement in movements), "movement", where
    )
    approach: dict[str, int] = {}
    for movement in movements:
        if approach.setdefault(movement.from_link, movement.approach) != movement.approach:
            raise wrong(
                f"movements from link {movement.from_link} name the approaches "
                f"{approach[movement.from_link]} and {movement.approach}",
                expected="one approach for every link",
            )


def _check_movement(movement: Movement, node: str, links: dict[str, Link], where: str) -> None:
    wrong = partial(NetworkError, where=where)
    for name in (movement.from_link, movement.to_link):
        if name not in links:
            raise wrong(f"there is no link '{name}'", mend="add the link, or correct the name")
    before, after = links[movement.from_link], links[movement.to_link]
    if before.end != node:
        raise wrong(
            f"it comes from link {before.id}, which ends at '{before.end}'",
            expected="a link that ends at this intersection",
        )
    if after.start != node:
        raise wrong(
            f"it goes to link {after.id}, which starts at '{after.start}'",
            expected="a link that starts at this intersection",
        )
    if movement.turn not in TURNS:
        raise wrong(f"its turn is {movement.turn!r}", expected=f"one of {', '.join(TURNS)}")
    if movement.approach < 0:
        raise wrong(f"its approach is {movement.approach}", expected="0 or more")
    known = range(before.lanes)
    if not movement.lanes or len(set(movement.lanes)) < len(movement.lanes):
        raise wrong(
            f"its lanes are {list(movement.lanes)}",
            expected=f"at least one lane of link {movement.from_link}, each once",
            mend="name the lanes that serve it, or remove it",
        )
    if not set(movement.lanes) <= set(known):
        raise wrong(
            f"its lanes are {list(movement.lanes)}",
            expected=f"lanes from 0 to {len(known) - 1} of link {movement.from_link}",
        )


def _check_phases(node: Intersection, where: str) -> None:
    wrong = partial(NetworkError, where=where)
    if not node.phases:
        raise wrong(
            "it has no phases",
            mend="add one; a junction without signals has a single phase of all its movements",
        )
    movements = frozenset(range(len(node.movements)))
    if node.unsignalled - movements:
        raise wrong(
            f"movement {min(node.unsignalled - movements)} is unsignalled but does not exist",
            expected=f"0 to {len(movements) - 1}",
        )
    for index, phase in enumerate(node.phases):
        place = f"{where}, phase {index}"
        if not phase:
            raise NetworkError(
                "it serves no movement",
                where=place,
                mend="remove it; clearance between phases is a scenario's timing",
            )
        if phase - movements:
            raise NetworkError(
                f"it serves movement {min(phase - movements)}, which does not exist",
                where=place,
                expected=f"0 to {len(movements) - 1}",
            )
        if phase & node.unsignalled:
            raise NetworkError(
                f"it serves movement {min(phase & node.unsignalled)}, which is unsignalled",
                where=place,
                mend="unsignalled movements are always open: name them in no phase",
            )
        if phase in node.phases[:index]:
            raise NetworkError(
                f"it serves the same movements as phase {node.phases.index(phase)}",
                where=place,
                mend="remove one of them",
            )
    never = movements - node.unsignalled - frozenset().union(*node.phases)
    if never:
        movement = node.movements[min(never)]
        raise wrong(
            f"movement {min(never)} ({movement.from_link} to {movement.to_link}) is served by no "
            "phase, so its vehicles would wait forever",
            mend="add it to a phase, make it unsignalled, or remove it",
        )


def _check_plan(node: Intersection, where: str) -> None:
    wrong = partial(NetworkError, where=where)
    movements = range(len(node.movements))
    for index, stage in enumerate(node.program.stages if node.program else ()):
        if not stage.green <= set(movements):
            raise wrong(
                f"its stage {index} serves movement {max(stage.green - set(movements))}",
                expected=f"0 to {len(movements) - 1}",
            )
        if not (math.isfinite(stage.duration_s) and stage.duration_s > 0):
            raise wrong(
                f"its stage {index} lasts {stage.duration_s} s", expected="a number above 0 s"
            )
    if node.program and not node.program.stages:
        raise wrong("its program has no stages", mend="remove the program")
    if len(node.phase_names) not in (0, len(node.phases)):
        raise wrong(f"it has {len(node.phase_names)} names for {len(node.phases)} phases")
    if not (math.isfinite(node.clearance_s) and node.clearance_s >= 0):
        raise wrong(f"its clearance is {node.clearance_s} s", expected="0 s or more")


def _check_priority(node: Intersection, where: str) -> None:
    wrong = partial(NetworkError, where=where)
    count = len(node.movements)
    if len(node.gives_way) not in (0, count):
        raise wrong(
            f"it says for {len(node.gives_way)} movements that they yield to",
            expected=f"nothing, or an entry for each of the {count} movements",
        )
    named = {foe for foes in node.gives_way for foe in foes}
    named |= {foe for pair in node.conflicts for foe in pair}
    if not named <= set(range(count)):
        raise wrong(
            f"priority or conflict with movement {max(named)}", expected=f"0 to {count - 1}"
        )
    waiting = {j: set(foes) for j, foes in enumerate(node.gives_way) if foes}
    while free := [j for j, foes in waiting.items() if not foes & waiting.keys()]:
        for j in free:
            del waiting[j]
    if waiting:
        raise wrong(
            f"movements {', '.join(map(str, sorted(waiting)))} yield to each other in a circle",
            mend="break the circle: all of them would wait forever",
        )
