"""Other days like a recorded one."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from dmil.demand.vehicles import ScalableDemand, Vehicles
from dmil.errors import DemandError
from dmil.network import RoadNetwork

SHIFT_S = 60


@dataclass(frozen=True, eq=False)
class ResampledDemand:
    """Days as a recorded one might have been, another for every seed (ours).

    As many vehicles as recorded are drawn from the record with replacement, and each departs up to
    some time sooner or later, uniformly: routes and rates over the hour stay, who comes when does
    not. One recorded day alone says nothing of how sure a difference between controllers is.

    Parameters
    ----------
    base
        The recorded demand.
    shift_s
        Most seconds that a departure moves; it stays within the run.

    Raises
    ------
    DemandError
        If the shift is negative.
    """

    base: ScalableDemand
    shift_s: int = SHIFT_S

    def __post_init__(self) -> None:
        if self.shift_s < 0:
            raise DemandError(
                f"departures move by {self.shift_s} s",
                where="shift_s",
                expected="a whole number of 0 or more",
            )

    def vehicles(self, network: RoadNetwork, horizon_s: int, rng: np.random.Generator) -> Vehicles:
        """Draw the vehicles of a day; see `Demand`."""
        recorded = self.base.vehicles(network, horizon_s, rng)
        count = len(recorded)
        if not count:
            return recorded
        day = recorded.take(rng.integers(0, count, count), dropped=recorded.dropped)
        moved_s = day.depart_s + rng.integers(-self.shift_s, self.shift_s + 1, count)
        depart_s = np.clip(moved_s, 0, horizon_s - 1).astype(np.int32)
        order = np.argsort(depart_s, kind="stable")
        return replace(
            day.take(order, dropped=recorded.dropped),
            depart_s=np.ascontiguousarray(depart_s[order]),
        )

    def scaled(self, load: float) -> ResampledDemand:
        """Return the demand over the scaled record."""
        return replace(self, base=self.base.scaled(load))
