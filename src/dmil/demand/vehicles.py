"""Vehicles as arrays, and what every demand can do."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from dmil.errors import DemandError
from dmil.network import RoadNetwork

IntArray = npt.NDArray[np.int32]
LongArray = npt.NDArray[np.int64]
FloatArray = npt.NDArray[np.float64]


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
        (sum of route lengths,) int32, indices into the network's links, the entry link first. The
        last is an exit link, or in recorded demand a link at whose end the vehicle parks.
    dropped
        Vehicles left out because they depart at or beyond the horizon.
    kind
        (vehicles,) int32, which row of the demand's table says more about the vehicle to SUMO;
        None where nothing more is known.
    """

    depart_s: IntArray
    route_offset: IntArray
    route_links: IntArray
    dropped: int = 0
    kind: IntArray | None = None

    def __len__(self) -> int:
        """Return the number of vehicles."""
        return len(self.depart_s)

    def route(self, vehicle: int) -> IntArray:
        """Return one vehicle's link indices, the entry link first: (links of the route,) int32."""
        return self.route_links[self.route_offset[vehicle] : self.route_offset[vehicle + 1]]

    def take(self, chosen: LongArray, *, dropped: int = 0) -> Vehicles:
        """Return some of the vehicles, in the given order; the same one may come twice.

        Parameters
        ----------
        chosen
            (chosen,) indices of vehicles.
        dropped
            How many vehicles the result should say were left out.
        """
        offset, place = gather(self.route_offset, chosen)
        kind = None if self.kind is None else self.kind[chosen]
        return Vehicles(self.depart_s[chosen], offset, self.route_links[place], dropped, kind)


def gather(offset: npt.NDArray[np.integer], chosen: LongArray) -> tuple[IntArray, LongArray]:
    """Find the entries of chosen rows of a ragged array without a loop (ours).

    ``offset`` is (rows + 1,): where every row begins and ends. Returns the offsets of the chosen
    rows put one after the other, (chosen + 1,) int32, and where their entries stand in the array.
    """
    start = offset[chosen]
    length = offset[chosen + 1] - start
    result = np.append(0, np.cumsum(length))
    place = np.arange(result[-1]) + np.repeat(start - result[:-1], length)
    return result.astype(np.int32), place


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
            End of the demand in seconds, a positive whole number.
        rng
            Stream of random numbers; nothing else may decide a draw.
        """
        ...


@runtime_checkable
class ScalableDemand(Demand, Protocol):
    """A demand of which there can be more or less."""

    def scaled(self, load: float) -> ScalableDemand:
        """Return the demand with ``load`` times as many vehicles in the mean."""
        ...


def check_horizon(horizon_s: int) -> None:
    """Raise a DemandError unless the horizon is a positive whole number of seconds."""
    if isinstance(horizon_s, bool) or not isinstance(horizon_s, int | np.integer) or horizon_s < 1:
        raise DemandError(
            f"the horizon is {horizon_s!r} s", where="horizon_s", expected="a whole number above 0"
        )


def check_load(load: float) -> None:
    """Raise a DemandError unless the load is a finite number of 0 or more."""
    if not (np.isfinite(load) and load >= 0):
        raise DemandError(
            f"the load is {load}",
            where="load",
            expected="a number of 0 or more; 1 leaves the demand as it is",
        )
