"""Rates by fringe node or by side of a grid."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from dmil.demand.destinations import route_graph
from dmil.demand.vehicles import FloatArray
from dmil.errors import DemandError, unknown_name
from dmil.network import RoadNetwork

PAPER_RATE_VEH_PER_MIN: Mapping[str, float] = {"E": 5.0, "N": 5.0, "W": 10.0, "S": 7.0}
"""Vehicles per minute and fringe node, by side of the network (paper, §VI)."""


def check_rates(rate_veh_per_min: Mapping[str, float]) -> None:
    """Check that rates, in vehicles per minute by fringe node or side, are usable on some network.

    Raises
    ------
    DemandError
        If there is none, or one is negative or not finite.
    """
    if not rate_veh_per_min:
        raise DemandError(
            "there are no rates",
            where="rate_veh_per_min",
            expected="vehicles per minute by fringe node or side",
            mend="write for example {'E': 5, 'W': 10}",
        )
    for place, rate in rate_veh_per_min.items():
        if not (math.isfinite(rate) and rate >= 0):
            raise DemandError(
                f"the rate is {rate} vehicles per minute",
                where=f"rate_veh_per_min['{place}']",
                expected="a number of 0 or more",
            )


def rates_at_fringe(network: RoadNetwork, rate_veh_per_min: Mapping[str, float]) -> FloatArray:
    """Return every fringe node's rate in vehicles per minute: (fringe nodes,) float64.

    Rates are given by fringe node or side letter of a grid; who is not named sends nobody.

    Raises
    ------
    DemandError
        If the network has fewer than two fringe nodes, or vehicles would start where they can
        reach no other fringe node.
    UnknownNameError
        If a key is neither a fringe node nor a side.
    """
    fringe = network.fringe
    if len(fringe) < 2:
        raise DemandError(
            f"the network has {len(fringe)} fringe nodes",
            where=network.name,
            expected="at least two, to come from and to go to",
        )
    sides = [node[0] if node[:1] in "ENWS" and node[1:].isdecimal() else "" for node in fringe]
    unknown = rate_veh_per_min.keys() - set(fringe) - set(sides)
    if unknown:
        raise unknown_name(
            "fringe node or side",
            min(unknown),
            {*fringe, *sides} - {""},
            where=f"rate_veh_per_min on {network.name}",
        )
    rates = np.array(
        [
            rate_veh_per_min.get(node, rate_veh_per_min.get(side, 0.0))
            for node, side in zip(fringe, sides, strict=True)
        ],
        dtype=np.float64,
    )
    stuck = (rates > 0) & (np.diff(route_graph(network).pair_offset) == 0)
    if stuck.any():
        node = fringe[int(np.argmax(stuck))]
        raise DemandError(
            f"vehicles starting at '{node}' can reach no other fringe node",
            where=f"rate_veh_per_min on {network.name}",
            mend=f"set the rate of '{node}' to 0, or add the missing movements to the network",
        )
    return rates
