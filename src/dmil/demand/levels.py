"""The vehicles of one draw at any load: those of a lower load are among those of a higher one."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from dmil.arrays import BoolArray
from dmil.demand.arrivals import CompoundPoissonDemand, PoissonDemand
from dmil.demand.vehicles import (
    Demand,
    FloatArray,
    ScalableDemand,
    Vehicles,
    check_load,
)
from dmil.errors import DemandError
from dmil.network import RoadNetwork


@dataclass(frozen=True, eq=False)
class DemandLevels:
    """Vehicles of the highest load, each with the load from which on it drives (ours).

    A Poisson process of which every vehicle stays with the same probability is a Poisson process
    with that part of the rate, so every load has exactly the arrivals of the demand at that load;
    two loads differ by the vehicles that come on top, and by no chance.

    Attributes
    ----------
    vehicles: Vehicles
        Those of the highest load.
    from_load: (vehicles,) float64
        Load above which each drives, uniform from 0 to the highest.
    highest: float
    """

    vehicles: Vehicles
    from_load: FloatArray
    highest: float

    @classmethod
    def draw(
        cls,
        demand: Demand,
        network: RoadNetwork,
        horizon_s: int,
        highest: float,
        rng: np.random.Generator,
        *,
        recorded_s: int | None = None,
    ) -> DemandLevels:
        """Draw the vehicles of all loads up to the highest, at a rate that stays over time.

        Recorded vehicles and rates that vary keep their ways and their number; they depart at
        times drawn uniformly, because a queue grows and shrinks with a peak whoever controls.

        Parameters
        ----------
        demand
            What load 1 is.
        network
            The roads.
        horizon_s
            Length of a run in s.
        highest
            Highest load.
        rng
            Stream of random numbers.
        recorded_s
            Time that recorded demand lasts in s; by default the horizon.

        Raises
        ------
        DemandError
            If the demand cannot be scaled, or the load is no number above 0.
        """
        check_load(highest)
        if not isinstance(demand, ScalableDemand) or highest == 0:
            raise DemandError(
                f"a {type(demand).__name__} at load {highest:g}",
                where="load",
                expected="a demand with a method scaled(load), and a load above 0",
            )
        if isinstance(demand, PoissonDemand | CompoundPoissonDemand):
            vehicles = demand.scaled(highest).vehicles(network, horizon_s, rng)
        else:
            recorded_s = recorded_s or horizon_s
            more = highest * horizon_s / recorded_s
            vehicles = demand.scaled(more).vehicles(network, recorded_s, rng)
            vehicles = _spread(vehicles, horizon_s, rng)
        return cls(vehicles, highest * rng.random(len(vehicles)), highest)

    def at(self, load: float) -> Vehicles:
        """Return the vehicles of a load, at most the highest."""
        return self._chosen(self.from_load < self._known(load))

    def with_surge(self, load: float, factor: float, from_s: int, until_s: int) -> Vehicles:
        """Return the vehicles of a load, with ``factor`` times as many for a while."""
        more = self.from_load < self._known(load * factor)
        depart_s = self.vehicles.depart_s
        within = (depart_s >= from_s) & (depart_s < until_s)
        return self._chosen((self.from_load < load) | (more & within))

    def _chosen(self, chosen: BoolArray) -> Vehicles:
        return self.vehicles.take(np.flatnonzero(chosen))

    def _known(self, load: float) -> float:
        if not 0 <= load <= self.highest:
            raise DemandError(
                f"the load is {load:g}", where="load", expected=f"0 to {self.highest:g}"
            )
        return load


def _spread(vehicles: Vehicles, horizon_s: int, rng: np.random.Generator) -> Vehicles:
    """Return vehicles that depart at times drawn uniformly from the run."""
    depart_s = rng.integers(0, horizon_s, len(vehicles)).astype(np.int32)
    order = np.argsort(depart_s, kind="stable")
    return replace(vehicles.take(order), depart_s=np.ascontiguousarray(depart_s[order]))
