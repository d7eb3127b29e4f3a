"""Poisson arrivals at the fringe (paper, Section IV)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from dmil.demand.routes import route_table
from dmil.demand.vehicles import Vehicles
from dmil.network.model import RoadNetwork

PAPER_RATE_VEH_PER_MIN: Mapping[str, float] = {"E": 5.0, "N": 5.0, "W": 10.0, "S": 7.0}


@dataclass(frozen=True)
class PoissonDemand:
    """Vehicles that arrive at every fringe node as a Poisson process.

    Parameters
    ----------
    rate_veh_per_min
        Fringe id, or side letter of a grid, to vehicles per minute.
    """

    rate_veh_per_min: Mapping[str, float] = field(
        default_factory=lambda: dict(PAPER_RATE_VEH_PER_MIN)
    )

    def vehicles(self, network: RoadNetwork, horizon_s: int, rng: np.random.Generator) -> Vehicles:
        """Draw the vehicles of a run."""
        rates = np.array(
            [
                self.rate_veh_per_min.get(node, self.rate_veh_per_min.get(node[0], 0.0))
                for node in network.fringe
            ]
        )
        table = route_table(network)
        counts = rng.poisson(rates / 60.0, size=(horizon_s, len(rates)))
        slot = np.repeat(np.arange(counts.size), counts.ravel())
        depart_s, origin = np.divmod(slot, len(rates))
        first = table.pair_offset[origin]
        pair = rng.integers(first, table.pair_offset[origin + 1])
        return table.vehicles(depart_s, pair, rng.random(len(pair)))
