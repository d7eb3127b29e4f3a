"""Signal timing: numbers for all intersections, or each one's plan, and how fair that is."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from dmil.arrays import BoolArray
from dmil.errors import InputError
from dmil.network import Intersection, RoadNetwork, Walk, plan_times
from dmil.network.json_file import first_problem


class Settings(BaseModel):
    """Frozen numbers of a scenario; a wrong one raises our error and not pydantic's."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    def __init__(self, **values: Any) -> None:
        try:
            super().__init__(**values)
        except ValidationError as cause:
            place, problem = first_problem(cause)
            fields = ", ".join(type(self).model_fields)
            name = type(self).__name__
            raise InputError(
                problem,
                where=f"{name}.{place}" if place else name,
                mend=f"{name} has the fields {fields}",
            ) from None


IntArray = npt.NDArray[np.int32]
ClearanceKind = Literal["kept", "all-stop"]


class SignalTiming(Settings):
    """When signals may change, in whole seconds: the simulator's steps.

    Clearance and greens hold for all intersections; None leaves each to what its own plan says,
    phase by phase, see `dmil.network.plan_times`.
    """

    decision_interval_s: int = Field(
        default=10, ge=1, description="Seconds between decisions of a controller (paper: 10)."
    )
    clearance_s: int | None = Field(
        default=0,
        ge=0,
        description="Seconds of yellow and all-red at a phase change. Shorter than the decision "
        "interval. By default, for networks from files, as in each plan (paper: none).",
    )
    all_red_s: int | None = Field(
        default=0,
        ge=0,
        description="All-red seconds at the end of the clearance time; the rest is yellow. Only "
        "SUMO distinguishes them. By default, for networks from files, as in each plan.",
    )
    clearance_kind: ClearanceKind | None = Field(
        default="kept",
        description="Clearance of movements with green before and after a phase change: kept (they "
        "keep it) or all-stop (they stop like all others). By default, for networks from files, "
        "as in each plan; in CityFlow files without an example all-stop (paper: none).",
    )
    min_green_s: int | None = Field(
        default=0,
        ge=0,
        description="Minimum green in s. By default, for networks from files, as in each plan, or "
        "5 s where it has none (paper: none).",
    )
    max_green_s: int | None = Field(
        default=0,
        ge=0,
        description="Maximum green in s: then the next phase follows unless the controller "
        "chooses one; 0: no limit. By default, for networks from files, as in each plan "
        "(paper: none).",
    )
    startup_lost_s: int = Field(
        default=0,
        ge=0,
        description="Start-up lost time: seconds at the start of green in which a queue does not "
        "move (paper: none).",
    )

    @model_validator(mode="after")
    def _consistent(self) -> SignalTiming:
        if self.clearance_s is not None:
            if self.clearance_s >= self.decision_interval_s:
                raise ValueError(
                    f"clearance_s ({self.clearance_s}) must be less than decision_interval_s "
                    f"({self.decision_interval_s}), or no phase would ever be green"
                )
            if self.all_red_s is not None and self.all_red_s > self.clearance_s:
                raise ValueError(
                    f"all_red_s ({self.all_red_s}) is a part of clearance_s ({self.clearance_s}) "
                    "and cannot be longer"
                )
        if self.min_green_s is not None and 0 < (self.max_green_s or 0) < self.min_green_s:
            raise ValueError(
                f"max_green_s ({self.max_green_s}) must not be less than min_green_s "
                f"({self.min_green_s})"
            )
        return self


PLAN: dict[str, None] = dict.fromkeys(
    ("clearance_s", "all_red_s", "clearance_kind", "min_green_s", "max_green_s")
)
"""Settings of `SignalTiming` by which every intersection has the times of its own plan."""


class SignalTimes(NamedTuple):
    """Signal timing of every intersection and phase, in whole seconds (ours).

    Attributes
    ----------
    clearance_s, all_red_s: (intersections, phases, phases) int32
        Of the change from a phase (row) to another (column), the all-red part included.
    min_green_s, max_green_s: (intersections, phases) int32
        Of a phase; a longest green of 0 is no limit.
    all_stop: (intersections,) bool
        Whether clearance stops those too who have green before and after it.
    """

    clearance_s: IntArray
    all_red_s: IntArray
    min_green_s: IntArray
    max_green_s: IntArray
    all_stop: BoolArray


# A learner asks at the beginning of every episode, always for the same network.
@lru_cache(maxsize=16)
def signal_times(timing: SignalTiming, network: RoadNetwork) -> SignalTimes:
    """Return the signal timing of every intersection and phase (ours).

    Where only the clearance or only its all-red is given, the other is the plan's: all-red as long
    as the clearance has room for it, clearance as long as the plan's yellow and that all-red. No
    least green is shorter than the pedestrians who go with the phase need to walk and to clear.

    Parameters
    ----------
    timing
        What holds for all intersections.
    network
        The roads and signals.

    Returns
    -------
    SignalTimes
        Read-only.
    """
    items, kind = network.intersections, timing.clearance_kind
    phases = max(len(item.phases) for item in items)
    found = SignalTimes(
        np.full((len(items), phases, phases), timing.clearance_s or 0, np.int32),
        np.full((len(items), phases, phases), timing.all_red_s or 0, np.int32),
        np.full((len(items), phases), timing.min_green_s or 0, np.int32),
        np.full((len(items), phases), timing.max_green_s or 0, np.int32),
        np.array([item.all_stop if kind is None else kind == "all-stop" for item in items]),
    )
    if any(getattr(timing, name) is None for name in PLAN):
        for i, item in enumerate(items):
            _take_plan(timing, item, i, found)
    for i, item in enumerate(items):
        for walk in item.walks:
            for phase in walk.phases:
                needed_s = walk.least_s + dont_walk_s(found, item, i, phase, walk)
                found.min_green_s[i, phase] = max(found.min_green_s[i, phase], needed_s)
                if found.max_green_s[i, phase]:
                    found.max_green_s[i, phase] = max(found.max_green_s[i, phase], needed_s)
    for array in found:
        array.flags.writeable = False
    return found


def dont_walk_s(times: SignalTimes, item: Intersection, i: int, phase: int, walk: Walk) -> int:
    """Return how long before a phase ends its pedestrians must stop setting out, in s (ours).

    What they need to clear a crossing beyond the clearance of vehicles.
    """
    changes = [q for q in range(len(item.phases)) if q != phase]
    clearance_s = min((int(times.clearance_s[i, phase, q]) for q in changes), default=0)
    return max(0, walk.clear_s - clearance_s)


def _take_plan(timing: SignalTiming, item: Intersection, i: int, found: SignalTimes) -> None:
    """Fill in, for one intersection, what its own plan says where nothing else is given."""
    plan, own = plan_times(item), slice(len(item.phases))
    clearance_s, all_red_s = found.clearance_s[i, own, own], found.all_red_s[i, own, own]
    if timing.all_red_s is None:
        all_red_s[:] = plan.all_red_s
    if timing.clearance_s is None:
        clearance_s[:] = plan.yellow_s + all_red_s
    np.minimum(all_red_s, clearance_s, out=all_red_s)
    if timing.min_green_s is None:
        found.min_green_s[i, own] = plan.min_green_s
    if timing.max_green_s is None:
        found.max_green_s[i, own] = plan.max_green_s
    # Of the two that one gives way that the user has not given.
    least, longest = found.min_green_s[i], found.max_green_s[i]
    if timing.max_green_s is None:
        longest[:] = np.where(longest > 0, np.maximum(least, longest), 0)
    elif timing.max_green_s > 0:
        np.minimum(least, longest, out=least)


class UniformTiming(NamedTuple):
    """Signal timing by which all phases of an intersection have the same times (ours).

    Attributes
    ----------
    decision_interval_s, clearance_s, min_green_s, max_green_s, startup_lost_s: int
        As in `SignalTiming`.
    all_stop: bool
        As in `SignalTimes`.
    """

    decision_interval_s: int
    clearance_s: int
    min_green_s: int
    max_green_s: int
    startup_lost_s: int
    all_stop: bool


def uniform_timing(timing: SignalTiming, network: RoadNetwork, i: int) -> UniformTiming:
    """Return for one intersection times that none of its phases falls short of (ours).

    These are its longest clearance, the longest of its least greens, and the shortest of its
    longest ones.

    Parameters
    ----------
    timing, network
        See `signal_times`.
    i
        Index of the intersection.
    """
    times, own = signal_times(timing, network), slice(len(network.intersections[i].phases))
    longest = times.max_green_s[i, own]
    limits = longest[longest > 0]
    least_s = int(times.min_green_s[i, own].max())
    return UniformTiming(
        decision_interval_s=timing.decision_interval_s,
        clearance_s=int(times.clearance_s[i, own, own].max()),
        min_green_s=least_s,
        max_green_s=max(int(limits.min()), least_s) if limits.size else 0,
        startup_lost_s=timing.startup_lost_s,
        all_stop=bool(times.all_stop[i]),
    )


def lost_s(timing: SignalTiming, network: RoadNetwork) -> npt.NDArray[np.float64]:
    """Return the mean lost time of a change of phase: (intersections,) float64, in s (ours).

    That is clearance and start-up.

    Parameters
    ----------
    timing, network
        See `signal_times`.
    """
    count = len(network.intersections)
    if timing.clearance_s is not None:
        return np.full(count, float(timing.clearance_s + timing.startup_lost_s))
    clearance_s = signal_times(timing, network).clearance_s
    found = np.full(count, float(timing.startup_lost_s))
    for i, item in enumerate(network.intersections):
        phases = len(item.phases)
        if phases > 1:
            # From a phase to itself nothing is cleared: 0 s.
            found[i] += clearance_s[i, :phases, :phases].sum() / (phases * (phases - 1))
    return found


@dataclass(frozen=True, slots=True)
class Advantage:
    """What controllers are spared at one intersection (ours).

    Half of what a controller seems to gain may be clearance that it does not keep: one second less
    per change is one second more of green. So what a user gives for all intersections is compared
    with what each one's own plan says.

    Attributes
    ----------
    intersection: int
        Its index in the network.
    what: str
        ``"clearance"``, ``"all-red"`` or ``"minimum green"``.
    plan_s, given_s: int
        Seconds in its plan, and those that controllers keep; of all changes or phases the ones
        that differ most.
    """

    intersection: int
    what: str
    plan_s: int
    given_s: int

    def __str__(self) -> str:
        return f"{self.what} {self.given_s} s, {self.plan_s} s in its plan"


def safest_times(timing: SignalTiming, network: RoadNetwork) -> SignalTimes:
    """Return times that fall short neither of what is given nor of each plan's own (ours)."""
    given, plan = (signal_times(each, network) for each in (timing, timing.model_copy(update=PLAN)))
    all_red_s = np.maximum(given.all_red_s, plan.all_red_s)
    yellow_s = np.maximum(given.clearance_s - given.all_red_s, plan.clearance_s - plan.all_red_s)
    return SignalTimes(
        clearance_s=yellow_s + all_red_s,
        all_red_s=all_red_s,
        min_green_s=np.maximum(given.min_green_s, plan.min_green_s),
        max_green_s=given.max_green_s,
        all_stop=given.all_stop | plan.all_stop,
    )


def advantages(timing: SignalTiming, network: RoadNetwork) -> list[Advantage]:
    """Find where controllers get less lost time than the network's own plans (ours).

    A green lasts for whole decision intervals less the clearance before it, so that it may be long
    enough without a minimum. Intersections without a plan are left out.
    """
    given, plan = (signal_times(each, network) for each in (timing, timing.model_copy(update=PLAN)))
    interval_s = timing.decision_interval_s
    found = []
    for i, item in enumerate(network.intersections):
        if item.program is None or len(item.phases) < 2:
            continue
        own = slice(len(item.phases))
        clearance_s = given.clearance_s[i, own, own]
        # Of every change into a phase: the shortest green that ends with a decision.
        intervals = -(-np.maximum(given.min_green_s[i, own] + clearance_s, 1) // interval_s)
        np.fill_diagonal(intervals, np.iinfo(np.int32).max // interval_s)
        least_s = (intervals * interval_s - clearance_s).min(axis=0)
        for what, theirs, ours in (
            ("clearance", plan.clearance_s[i, own, own], clearance_s),
            ("all-red", plan.all_red_s[i, own, own], given.all_red_s[i, own, own]),
            ("minimum green", plan.min_green_s[i, own], least_s),
        ):
            place = np.unravel_index((theirs - ours).argmax(), theirs.shape)
            if theirs[place] > ours[place]:
                found.append(Advantage(i, what, int(theirs[place]), int(ours[place])))
    return found
