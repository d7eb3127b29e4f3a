"""Vehicles as arrays, and what every demand can do."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from dmil.network.model import RoadNetwork

Int32Array = npt.NDArray[np.int32]


@dataclass(frozen=True, slots=True, eq=False)
class Vehicles:
    """All vehicles of a run, drawn before it begins (ours).

    Parameters
    ----------
    depart_s
        (vehicles,) int32, second in which the vehicle appears, non-decreasing.
    route_offset
        (vehicles + 1,) int32, vehicle v's route is ``route_links[offset[v]:offset[v + 1]]``.
    route_links
        (sum of route lengths,) int32, indices into the network's links, entry link first and exit
        link last.
    dropped
        Vehicles left out because they depart at or beyond the horizon.
    """

    depart_s: Int32Array
    route_offset: Int32Array
    route_links: Int32Array
    dropped: int = 0

    def __len__(self) -> int:
        """Return the number of vehicles."""
        return len(self.depart_s)

    def route(self, vehicle: int) -> Int32Array:
        """Return one vehicle's link indices, entry link first: (links of the route,) int32."""
        return self.route_links[self.route_offset[vehicle] : self.route_offset[vehicle + 1]]


@runtime_checkable
class Demand(Protocol):
    """Whatever can say which vehicles will come."""

    def vehicles(self, network: RoadNetwork, horizon_s: int, rng: np.random.Generator) -> Vehicles:
        """Return the vehicles that depart in seconds 0 to ``horizon_s - 1``.

        Parameters
        ----------
        network
            The roads they drive on.
        horizon_s
            End of the demand in seconds.
        rng
            Stream of random numbers; nothing else may decide a draw.
        """
        ...
