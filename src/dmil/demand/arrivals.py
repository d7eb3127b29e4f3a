"""Arrival processes at the fringe: Poisson, compound Poisson, rates that vary with time."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal, Protocol

import numpy as np

from dmil.demand.destinations import (
    PAPER_RATE_VEH_PER_MIN,
    TIES,
    Ties,
    check_rates,
    draw_destinations,
    rates_at_fringe,
)
from dmil.demand.vehicles import FloatArray, LongArray, Vehicles, check_horizon, check_load
from dmil.errors import DemandError
from dmil.network import RoadNetwork

DEFAULT_BATCH_VEH = 2.0


class ArrivalProcess(Protocol):
    """A demand that is a rate at every fringe node, so that the rate can vary with time."""

    def arrivals(
        self, network: RoadNetwork, multiplier: FloatArray, rng: np.random.Generator
    ) -> LongArray:
        """Draw when and where vehicles arrive.

        Parameters
        ----------
        network
            The roads.
        multiplier
            (seconds,) factor on the rates in every second.
        rng
            Stream of random numbers.

        Returns
        -------
        (vehicles,) int64
            ``second * fringe nodes + fringe node``, non-decreasing.
        """
        ...

    @property
    def ties(self) -> Ties:
        """What decides between equally short ways, see `dmil.demand.destinations.Ties`."""
        ...

    def with_ties(self, ties: Ties) -> ArrivalProcess:
        """Return the process with other ties."""
        ...

    def scaled(self, load: float) -> ArrivalProcess:
        """Return the process with its rates multiplied."""
        ...

    def vehicles(self, network: RoadNetwork, horizon_s: int, rng: np.random.Generator) -> Vehicles:
        """Draw arrivals, then destinations, then coins: always in this order; see `Demand`."""
        check_horizon(horizon_s)
        arrivals = self.arrivals(network, np.ones(horizon_s), rng)
        second, origin = np.divmod(arrivals, len(network.fringe))
        return draw_destinations(network, second, origin, rng, self.ties)


@dataclass(frozen=True)
class PoissonDemand(ArrivalProcess):
    """Vehicles that arrive one by one (paper, §VI: homogeneous Poisson processes).

    In every second a Poisson number of vehicles with mean rate/60 arrives at every fringe node.
    Each goes to one of the other fringe nodes that it can reach, uniformly at random.

    Parameters
    ----------
    rate_veh_per_min
        Vehicles per minute by fringe node, or by side of a grid (``"E"`` for every node
        ``"E0"``, ``"E1"``...; a node's own entry comes before its side's). A fringe node without an
        entry sends nobody.
    ties
        What decides between equally short ways: ``"straight"`` (straight on while that is one of
        them, which leaves one way per pair of nodes on a grid) or ``"coin"`` (at every place a
        fair coin of the vehicle's own, drawn in advance).

    Raises
    ------
    DemandError
        If there is no rate, one is negative or not finite, or there are no such ties.

    Notes
    -----
    The default is the paper's. The paper does not state the unit of its rates; per minute
    reproduces its magnitudes. Nor does it say which of several shortest paths a vehicle takes.
    """

    rate_veh_per_min: Mapping[str, float] = field(
        default_factory=lambda: dict(PAPER_RATE_VEH_PER_MIN)
    )
    ties: Ties = "straight"

    def __post_init__(self) -> None:
        check_rates(self.rate_veh_per_min)
        _check_ties(self.ties)

    def arrivals(
        self, network: RoadNetwork, multiplier: FloatArray, rng: np.random.Generator
    ) -> LongArray:
        """Draw when and where vehicles arrive; see `ArrivalProcess`."""
        per_s = rates_at_fringe(network, self.rate_veh_per_min) / 60.0
        counts = rng.poisson(np.multiply.outer(multiplier, per_s)).ravel()
        return np.repeat(np.arange(len(counts)), counts)

    def with_ties(self, ties: Ties) -> PoissonDemand:
        """Return the demand with other ties."""
        return replace(self, ties=ties)

    def scaled(self, load: float) -> PoissonDemand:
        """Return the demand with all rates multiplied by ``load``."""
        return replace(self, rate_veh_per_min=_times(self.rate_veh_per_min, load))


@dataclass(frozen=True)
class CompoundPoissonDemand(ArrivalProcess):
    """Batches of vehicles that arrive together (paper, §III: compound Poisson processes).

    In every second a Poisson number of batches arrives at every fringe node; a batch's vehicles
    appear in the same second and choose their destinations each for itself.

    Parameters
    ----------
    rate_veh_per_min
        Vehicles, not batches, per minute; see `PoissonDemand`.
    batch_veh
        Mean size of geometrically distributed batches (1 or more), or the probability of every
        batch size such as ``{1: 0.5, 4: 0.5}``.
    ties
        What decides between equally short ways, see `PoissonDemand`.

    Raises
    ------
    DemandError
        If a rate, the distribution of batch sizes or the ties are not valid.

    Notes
    -----
    The paper names compound Poisson processes but gives no distribution of batches.
    """

    rate_veh_per_min: Mapping[str, float] = field(
        default_factory=lambda: dict(PAPER_RATE_VEH_PER_MIN)
    )
    batch_veh: float | Mapping[int, float] = DEFAULT_BATCH_VEH
    ties: Ties = "straight"

    def __post_init__(self) -> None:
        check_rates(self.rate_veh_per_min)
        _check_ties(self.ties)
        if isinstance(self.batch_veh, Mapping):
            _check_batch_sizes(self.batch_veh)
        elif not (math.isfinite(self.batch_veh) and self.batch_veh >= 1):
            raise DemandError(
                f"the mean batch is {self.batch_veh} vehicles",
                where="batch_veh",
                expected="a number of 1 or more",
            )

    @property
    def mean_batch_veh(self) -> float:
        """Mean number of vehicles in a batch."""
        if isinstance(self.batch_veh, Mapping):
            return sum(size * probability for size, probability in self.batch_veh.items())
        return float(self.batch_veh)

    def arrivals(
        self, network: RoadNetwork, multiplier: FloatArray, rng: np.random.Generator
    ) -> LongArray:
        """Draw when and where vehicles arrive; see `ArrivalProcess`."""
        batches = PoissonDemand(_times(self.rate_veh_per_min, 1.0 / self.mean_batch_veh))
        slots = batches.arrivals(network, multiplier, rng)
        if isinstance(self.batch_veh, Mapping):
            sizes = rng.choice(
                np.array(list(self.batch_veh)), len(slots), p=list(self.batch_veh.values())
            )
        else:
            sizes = rng.geometric(1.0 / self.batch_veh, len(slots))
        return np.repeat(slots, sizes)

    def with_ties(self, ties: Ties) -> CompoundPoissonDemand:
        """Return the demand with other ties."""
        return replace(self, ties=ties)

    def scaled(self, load: float) -> CompoundPoissonDemand:
        """Return the demand with all rates multiplied by ``load``; batches stay as they are."""
        return replace(self, rate_veh_per_min=_times(self.rate_veh_per_min, load))


@dataclass(frozen=True)
class ProfileDemand(ArrivalProcess):
    """Another demand whose rates rise and fall with time (ours).

    Parameters
    ----------
    base
        The demand whose rates are multiplied; a profile may be one itself.
    time_s
        Increasing times in seconds, the first is 0.
    multiplier
        Factor on the rates at each of these times, 0 or more.
    between
        ``"step"`` keeps a factor until the next time, ``"linear"`` joins them by straight lines.
        After the last time its factor stays.

    Raises
    ------
    DemandError
        If times and factors do not fit together, or the base has no rates (recorded vehicles).
    """

    base: ArrivalProcess
    time_s: Sequence[float]
    multiplier: Sequence[float]
    between: Literal["step", "linear"] = "step"

    def __post_init__(self) -> None:
        if not hasattr(self.base, "arrivals"):
            raise DemandError(
                f"a {type(self.base).__name__} has no rates that could vary",
                where="base",
                expected="a demand of random arrivals",
            )
        if len(self.time_s) != len(self.multiplier) or not len(self.time_s):
            raise DemandError(
                f"there are {len(self.time_s)} times and {len(self.multiplier)} multipliers",
                where="time_s, multiplier",
                expected="as many of one as of the other, at least one",
            )
        times = np.asarray(self.time_s, dtype=np.float64)
        if times[0] != 0 or not np.isfinite(times).all() or (np.diff(times) <= 0).any():
            raise DemandError(
                f"the times are {list(self.time_s)}",
                where="time_s",
                expected="increasing seconds, the first 0",
            )
        factors = np.asarray(self.multiplier, dtype=np.float64)
        if not np.isfinite(factors).all() or (factors < 0).any():
            raise DemandError(
                f"the multipliers are {list(self.multiplier)}",
                where="multiplier",
                expected="numbers of 0 or more",
            )
        if self.between not in ("step", "linear"):
            raise DemandError(
                f"it is {self.between!r}", where="between", expected="'step' or 'linear'"
            )

    def at(self, second: LongArray) -> FloatArray:
        """Return the factor in every given second."""
        times = np.asarray(self.time_s, dtype=np.float64)
        factors = np.asarray(self.multiplier, dtype=np.float64)
        if self.between == "linear":
            return np.interp(second, times, factors)
        return factors[np.searchsorted(times, second, side="right") - 1]

    def arrivals(
        self, network: RoadNetwork, multiplier: FloatArray, rng: np.random.Generator
    ) -> LongArray:
        """Draw when and where vehicles arrive; see `ArrivalProcess`."""
        return self.base.arrivals(network, multiplier * self.at(np.arange(len(multiplier))), rng)

    @property
    def ties(self) -> Ties:
        """What decides between equally short ways: as in the base."""
        return self.base.ties

    def with_ties(self, ties: Ties) -> ProfileDemand:
        """Return the profile over the base with other ties."""
        return replace(self, base=self.base.with_ties(ties))

    def scaled(self, load: float) -> ProfileDemand:
        """Return the profile over the scaled base."""
        return replace(self, base=self.base.scaled(load))


def _times(rate_veh_per_min: Mapping[str, float], load: float) -> dict[str, float]:
    check_load(load)
    return {place: rate * load for place, rate in rate_veh_per_min.items()}


def _check_ties(ties: str) -> None:
    if ties not in TIES:
        raise DemandError(f"they are {ties!r}", where="ties", expected="'straight' or 'coin'")


def _check_batch_sizes(probability: Mapping[int, float]) -> None:
    total = math.fsum(probability.values())
    whole = all(isinstance(size, int) and size >= 1 for size in probability)
    valid = all(math.isfinite(p) and p >= 0 for p in probability.values())
    if not (whole and valid and math.isclose(total, 1.0, abs_tol=1e-9)):
        raise DemandError(
            f"the batch sizes and their probabilities are {dict(probability)}",
            where="batch_veh",
            expected="whole sizes of 1 or more and probabilities that sum to 1",
        )
