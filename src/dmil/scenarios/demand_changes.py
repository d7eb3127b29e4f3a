"""Demand that differs from a scenario's own: arrivals, batches, rates, their course over time."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator

from dmil.demand import (
    CompoundPoissonDemand,
    Demand,
    PoissonDemand,
    ProfileDemand,
    ResampledDemand,
    ScalableDemand,
    Ties,
)
from dmil.demand.arrivals import DEFAULT_BATCH_VEH, ArrivalProcess
from dmil.demand.destinations import check_rates, rates_at_fringe
from dmil.errors import DemandError, InputError
from dmil.network import RoadNetwork
from dmil.scenarios.model import HIGHEST_LOAD, LONGEST_RUN_S

HIGHEST_RATE_VEH_PER_MIN = 6e4
"""A thousand vehicles a second at one node: what is above would fill any memory."""
LARGEST_BATCH_VEH = 10_000
BATCH = ("batch_veh", "batch_probability")
"""Fields that say how large batches are, each in its way."""

_Rate = Annotated[float, Field(ge=0, le=HIGHEST_RATE_VEH_PER_MIN, allow_inf_nan=False)]
_BatchSize = Annotated[int, Field(ge=1, le=LARGEST_BATCH_VEH)]
_Time = Annotated[float, Field(ge=0, le=LONGEST_RUN_S)]
_Factor = Annotated[float, Field(ge=0, le=HIGHEST_LOAD, allow_inf_nan=False)]


class DemandChanges(BaseModel):
    """Random arrivals that differ from the scenario's own."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    arrivals: Literal["poisson", "compound"] | None = Field(
        None,
        description="How vehicles arrive: poisson (one by one) or compound (in batches: the "
        "compound Poisson process that the paper names).",
    )
    batch_veh: float | None = Field(
        None,
        ge=1,
        le=LARGEST_BATCH_VEH,
        allow_inf_nan=False,
        description="Mean batch size of compound arrivals, in vehicles, geometrically "
        f"distributed; by default {DEFAULT_BATCH_VEH:g}.",
    )
    batch_probability: dict[_BatchSize, float] | None = Field(
        None,
        description="Probability of each batch size instead, such as { 1 = 0.5, 4 = 0.5 }.",
    )
    rate_veh_per_min: dict[str, _Rate] | None = Field(
        None,
        description="Vehicles per minute per boundary node or side of a grid, such as "
        "{ E = 5, N = 5, W = 10, S = 7 }; nodes without an entry send none. On a network with "
        "recorded vehicles they replace these.",
    )
    profile: tuple[tuple[_Time, _Factor], ...] | None = Field(
        None,
        description="Factor on the rates over time as [second, factor], starting at 0, such as "
        "[[0, 0.5], [1800, 2], [3600, 0.5]].",
    )
    profile_between: Literal["step", "linear"] | None = Field(
        None,
        description="Between two times of the profile: step (keep the earlier factor, the "
        "default) or linear.",
    )

    @field_validator("batch_probability", "rate_veh_per_min", "profile")
    @classmethod
    def _usable(cls, value: Any, info: Any) -> Any:
        if value is None:
            return value
        checks: dict[str, Callable[[], object]] = {
            "batch_probability": lambda: CompoundPoissonDemand(batch_veh=value),
            "rate_veh_per_min": lambda: check_rates(value),
            "profile": lambda: _with_profile(PoissonDemand(), value, "step"),
        }
        try:
            checks[info.field_name]()
        except DemandError as error:
            raise ValueError(error.expected) from None
        return value

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.batch_veh is not None and self.batch_probability is not None:
            raise ValueError("either batch_veh or batch_probability, not both")
        if self.arrivals == "poisson" and self.batch is not None:
            raise ValueError("arrivals that are compound where batches are given, not poisson")
        return self

    @property
    def batch(self) -> float | Mapping[int, float] | None:
        """Mean size of batches, or probability of every size, None if neither is given."""
        return self.batch_veh if self.batch_probability is None else self.batch_probability

    def over(self, below: DemandChanges) -> DemandChanges:
        """Return these changes, and where nothing is given those below (ours).

        A size of batches below ends with arrivals one by one, or with another size here.
        """
        given = self.model_dump(exclude_none=True)
        earlier = below.model_dump(exclude_none=True)
        if self.arrivals == "poisson" or self.batch is not None:
            earlier = {name: value for name, value in earlier.items() if name not in BATCH}
        return DemandChanges(**earlier | given)

    def applied_to(self, demand: Demand, network: RoadNetwork) -> Demand:
        """Return a scenario's own demand with these changes (ours).

        Raises
        ------
        InputError
            If the vehicles are recorded and no rates are given, batches or a kind of profile are
            given for a demand that has none, or a rate is for no boundary node.
        """
        if self == DemandChanges():
            return demand
        if not isinstance(demand, PoissonDemand | CompoundPoissonDemand | ProfileDemand):
            if self.rate_veh_per_min is None:
                given = ", ".join(self.model_dump(exclude_none=True))
                raise _recorded(demand, network, f"demand: {given}")
            demand = PoissonDemand(self.rate_veh_per_min)
        profile, base = _taken_apart(demand)
        changed = self._process(base)
        try:
            rates_at_fringe(network, changed.rate_veh_per_min)
        except InputError as error:
            where = f"demand.{error.where}"
            raise type(error)(
                error.problem, where=where, expected=error.expected, mend=error.mend
            ) from None
        return self._with_profile(changed, profile)

    def _process(
        self, base: PoissonDemand | CompoundPoissonDemand
    ) -> PoissonDemand | CompoundPoissonDemand:
        rates = base.rate_veh_per_min if self.rate_veh_per_min is None else self.rate_veh_per_min
        compound = isinstance(base, CompoundPoissonDemand)
        wanted = compound if self.arrivals is None else self.arrivals == "compound"
        if not wanted:
            if self.batch is not None:
                raise InputError(
                    "batches are given, but vehicles arrive one by one",
                    where="demand",
                    expected="compound arrivals where batches are given",
                    mend="add --arrivals compound",
                )
            return PoissonDemand(rates, base.ties)
        batch = base.batch_veh if isinstance(base, CompoundPoissonDemand) else DEFAULT_BATCH_VEH
        return CompoundPoissonDemand(rates, batch if self.batch is None else self.batch, base.ties)

    def _with_profile(self, base: ArrivalProcess, own: ProfileDemand | None) -> ArrivalProcess:
        if self.profile is not None:
            return _with_profile(base, self.profile, self.profile_between or "step")
        if own is not None:
            return replace(own, base=base, between=self.profile_between or own.between)
        if self.profile_between is not None:
            raise InputError(
                f"'{self.profile_between}' is given, but the rates do not vary with time",
                where="demand.profile_between",
                mend="add --profile, or leave it out",
            )
        return base


def changes_of(demand: Demand) -> DemandChanges:
    """Return what would make a demand, nothing for recorded vehicles (ours)."""
    if not isinstance(demand, PoissonDemand | CompoundPoissonDemand | ProfileDemand):
        return DemandChanges()
    profile, base = _taken_apart(demand)
    values: dict[str, Any] = {
        "arrivals": "poisson",
        "rate_veh_per_min": dict(base.rate_veh_per_min),
    }
    if isinstance(base, CompoundPoissonDemand):
        several = isinstance(base.batch_veh, Mapping)
        name = "batch_probability" if several else "batch_veh"
        values |= {"arrivals": "compound", name: base.batch_veh}
    if profile is not None:
        pairs = tuple(zip(profile.time_s, profile.multiplier, strict=True))
        values |= {"profile": pairs, "profile_between": profile.between}
    return DemandChanges(**values)


def with_ties(demand: Demand, ties: Ties, network: RoadNetwork) -> Demand:
    """Return a demand with other ties (ours).

    Raises
    ------
    InputError
        If its vehicles have their ways already.
    """
    if not hasattr(demand, "with_ties"):
        raise _recorded(demand, network, "ties")
    changed: Demand = demand.with_ties(ties)
    return changed


def resampled(demand: Demand, shift_s: int) -> ResampledDemand:
    """Return other days like a recorded one, see `ResampledDemand` (ours).

    Raises
    ------
    InputError
        If vehicles arrive at random, so that every seed has another day already.
    """
    if isinstance(demand, PoissonDemand | CompoundPoissonDemand | ProfileDemand):
        raise InputError(
            "vehicles arrive at random, other ones in every seed",
            where="resample",
            expected="recorded vehicles where days are drawn from them",
            mend="leave --resample out",
        )
    if not isinstance(demand, ScalableDemand):
        raise InputError(f"a {type(demand).__name__} cannot be resampled", where="resample")
    return ResampledDemand(demand, shift_s)


def _recorded(demand: Demand, network: RoadNetwork, where: str) -> InputError:
    return InputError(
        f"the vehicles of '{network.name}' are recorded with time and way "
        f"({type(demand).__name__})",
        where=where,
        expected="random arrivals where this is given",
        mend="leave it out, or also give rates of boundary nodes: --rates NODE=5,NODE=10",
    )


def _taken_apart(
    demand: PoissonDemand | CompoundPoissonDemand | ProfileDemand,
) -> tuple[ProfileDemand | None, PoissonDemand | CompoundPoissonDemand]:
    """Return the profile of a demand, if it has one, and what arrives at constant rates."""
    if not isinstance(demand, ProfileDemand):
        return None, demand
    if not isinstance(demand.base, PoissonDemand | CompoundPoissonDemand):
        raise InputError(
            f"its profile is over a {type(demand.base).__name__}",
            where="demand",
            expected="a profile over Poisson or compound Poisson arrivals",
            mend="give the scenario a whole demand instead",
        )
    return demand, demand.base


def _with_profile(
    base: ArrivalProcess, pairs: tuple[tuple[float, float], ...], between: Any
) -> ProfileDemand:
    return ProfileDemand(
        base, [time for time, _ in pairs], [factor for _, factor in pairs], between
    )
