"""Where links lie, and by which names an engineer knows the sides of an intersection."""

from __future__ import annotations

from collections.abc import Mapping

from dmil.network import Intersection, Junction, RoadNetwork
from dmil.network.naming import approach_names
from dmil.network.sumo.ways import heading

Point = tuple[float, float]
Line = tuple[Point, ...]


def lines_of(network: RoadNetwork, known: Mapping[str, Line] | None = None) -> dict[str, Line]:
    """Return the points along every link, in metres, straight where nothing is known (ours).

    Parameters
    ----------
    network
        The roads.
    known
        Link id to points, where the file has them.
    """
    known = known or {}
    return {
        link.id: known.get(link.id)
        or (network.position_m[link.start], network.position_m[link.end])
        for link in network.links
    }


def road_ends(network: RoadNetwork) -> frozenset[str]:
    """Return the nodes where roads end: vehicles cannot cross them, at most turn round (ours).

    Parameters
    ----------
    network
        The roads.
    """
    nodes: tuple[Intersection | Junction, ...] = (*network.intersections, *network.junctions)
    turning = (
        node.id for node in nodes if all(movement.turn == "uturn" for movement in node.movements)
    )
    return frozenset((*network.fringe, *turning))


def origins_rad(item: Intersection, lines: Mapping[str, Line]) -> dict[int, float]:
    """Return from where the traffic of every approach comes, counter-clockwise from East (ours).

    Parameters
    ----------
    item
        The intersection.
    lines
        Link id to the points along it.
    """
    link_of = {movement.approach: movement.from_link for movement in item.movements}
    return {side: heading(tuple(lines[link_of[side]][::-1])) for side in sorted(link_of)}


def side_names(item: Intersection, lines: Mapping[str, Line]) -> dict[int, str]:
    """Name the approaches of an intersection after the compass, else by numbers (ours).

    Parameters
    ----------
    item
        The intersection.
    lines
        Link id to the points along it.
    """
    origins = origins_rad(item, lines)
    return dict(zip(origins, approach_names(tuple(origins.values())), strict=True))
