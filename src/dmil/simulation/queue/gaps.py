"""Where vehicles wait without a signal, and for which gaps in the traffic that goes first."""

from __future__ import annotations

from collections import Counter

from dmil.network import Junction, RoadNetwork

FROM_MAJOR_S = (4.1, 2.2)
FROM_MINOR_S = {
    "right": (6.2, 3.3),
    "straight": (6.5, 4.0),
    "left": (7.1, 3.5),
    "uturn": (7.1, 3.5),
}
MERGE_S = (4.98, 2.61)
IN_TURN_S = (2.9, 3.9)


def in_turn(junction: Junction, j: int, k: int) -> bool:
    """Tell whether two movements give way to each other, as at an all-way stop (ours).

    Parameters
    ----------
    junction
        Where they are.
    j, k
        Their indices there.
    """
    return bool(junction.gives_way) and j in junction.gives_way[k] and k in junction.gives_way[j]


def gap_of(junction: Junction, j: int) -> tuple[float, float]:
    """Return critical gap and follow-up time of a movement that gives way, in s.

    Those of two-way stop control (HCM, 6th edition, chapter 20, two-lane major
    street): a left turn off the major road 4.1 and 2.2 s; off the minor one right 6.2 and 3.3 s,
    straight 6.5 and 4.0 s, left 7.1 and 3.5 s. Who only merges with others that come in
    a bend, as at roundabouts, has those of a roundabout's entry (a
    capacity of 1380 exp(−0.00102 v), by Siegloch's formula 4.98 and 2.61 s). Movements that give
    way to each other take turns, first come, first served: one may go 2.9 s after the other, and
    3.9 s after the one before it (all-way stops: saturation headways of 5.8 s where both roads
    have a queue, of 3.9 s where one has).

    Differs from the HCM: nothing is adapted to heavy vehicles, grade and number of lanes, and the
    ranks below the second are no factors on the capacity; vehicles see each other.

    Parameters
    ----------
    junction
        Where it is.
    j
        Its index there.
    """
    movement = junction.movements[j]
    if all(in_turn(junction, j, k) for k in junction.gives_way[j]):
        return IN_TURN_S
    foes = [junction.movements[k] for k in junction.gives_way[j]]
    merges = all(foe.to_link == movement.to_link for foe in foes)
    if merges and all(foe.turn != "straight" for foe in foes):
        return MERGE_S
    major = any(
        each.from_link == movement.from_link and not foes
        for each, foes in zip(junction.movements, junction.gives_way, strict=True)
    )
    return FROM_MAJOR_S if major else FROM_MINOR_S[movement.turn]


def junctions_that_hold(network: RoadNetwork, *, storage: bool) -> tuple[Junction, ...]:
    """Return the junctions without signals at which vehicles may have to wait (ours).

    They give way there; or fewer lanes lead on than lead there; or, where links can be full,
    movements share a lane, so that who wants into a full link holds up others.

    Parameters
    ----------
    network
        The roads.
    storage
        Whether links hold a finite number of vehicles.
    """
    links, index = network.links, network.link_index
    fed: Counter[str] = Counter()
    for junction in network.junctions:
        for movement in junction.movements:
            fed[movement.to_link] += len(movement.lanes)
    for item in network.intersections:
        for movement in item.movements:  # signals let one road after the other go
            fed[movement.to_link] = max(fed[movement.to_link], len(movement.lanes))
    held = []
    for junction in network.junctions:
        ways = [each for each in junction.movements if each.turn != "uturn"]
        leaving: dict[str, set[int]] = {}
        for each in ways:
            leaving.setdefault(each.from_link, set()).update(each.lanes)
        narrow = any(
            len(lanes) < (fed[name] or links[index[name]].open_lanes)
            for name, lanes in leaving.items()
        ) or any(len(each.lanes) > links[index[each.to_link]].lanes for each in ways)
        shared = sum(len(each.lanes) for each in ways) > sum(map(len, leaving.values()))
        if ways and (any(junction.gives_way) or narrow or (storage and shared)):
            held.append(junction)
    return tuple(held)
