"""What a scenario is: network, demand, signal timing, queue dynamics, horizon."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from dmil.demand import Demand
from dmil.errors import InputError
from dmil.network import RoadNetwork
from dmil.network.json_file import first_problem
from dmil.scenarios.sumo_files import SumoFiles

LONGEST_RUN_S = 10**8
"""Longest run, three years: steps are counted in 32 bits."""
HIGHEST_LOAD = 1e6
"""Highest factor on a demand: what is above would fill any memory with vehicles."""


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


class SignalTiming(Settings):
    """When signals may change, in whole seconds: the simulator's steps."""

    decision_interval_s: int = Field(
        default=10, ge=1, description="Seconds between two decisions of a controller (paper: 10)."
    )
    clearance_s: int = Field(
        default=0,
        ge=0,
        description="Seconds of yellow and all-red after a change of phase; movements that are "
        "green in both phases go on. Less than the decision interval (paper: none).",
    )
    all_red_s: int = Field(
        default=0,
        ge=0,
        description="How many of the clearance's seconds, its last, are all-red; the others are "
        "yellow. Only SUMO tells them apart.",
    )
    min_green_s: int = Field(
        default=0, ge=0, description="Least seconds of green before a phase may end (paper: none)."
    )
    max_green_s: int = Field(
        default=0,
        ge=0,
        description="Seconds of green after which the next phase follows if the controller chooses "
        "none; 0: no limit (paper: none).",
    )
    startup_lost_s: int = Field(
        default=0,
        ge=0,
        description="Seconds at the beginning of green in which a queue does not move yet "
        "(paper: none).",
    )

    @model_validator(mode="after")
    def _consistent(self) -> SignalTiming:
        if self.clearance_s >= self.decision_interval_s:
            raise ValueError(
                f"clearance_s ({self.clearance_s}) must be less than decision_interval_s "
                f"({self.decision_interval_s}), or no phase would ever be green"
            )
        if self.all_red_s > self.clearance_s:
            raise ValueError(
                f"all_red_s ({self.all_red_s}) is a part of clearance_s ({self.clearance_s}) and "
                "cannot be longer"
            )
        if 0 < self.max_green_s < self.min_green_s:
            raise ValueError(
                f"max_green_s ({self.max_green_s}) must not be less than min_green_s "
                f"({self.min_green_s})"
            )
        return self


class QueueDynamics(Settings):
    """How queues discharge and fill."""

    saturation_flow_veh_per_s: float = Field(
        default=1.0,
        gt=0,
        allow_inf_nan=False,
        description="Vehicles per second and lane that a queue discharges at green (the paper's "
        "v*, which it does not state).",
    )
    storage: bool = Field(
        default=False,
        description="Whether links hold a finite number of vehicles, so that queues spill back "
        "(paper: no).",
    )
    vehicle_space_m: float = Field(
        default=7.5,
        gt=0,
        allow_inf_nan=False,
        description="Metres of one lane that a queued vehicle takes up, its gap included; used "
        "with storage only.",
    )
    gap_wait_s: int = Field(
        default=20,
        ge=0,
        description="Longest wait in seconds, at the head of a lane, of a vehicle that gives way "
        "to others with green and a queue; used where a network says who gives way (paper: no).",
    )
    start_wave_veh_per_s: float = Field(
        default=0.0,
        ge=0,
        allow_inf_nan=False,
        description="Vehicles per second and lane that begin to move in a queue at green; they are "
        "not in the queue any more that controllers see. 0: until it has left, every vehicle is "
        "(paper).",
    )


@dataclass(frozen=True)
class Scenario:
    """Everything that a simulator needs but the seed and the controller (ours).

    Parameters
    ----------
    name
        Name as given to `dmil.scenarios.scenario`.
    network, demand, timing, dynamics
        Its parts.
    horizon_s
        Length of a run in seconds.
    sumo
        SUMO's files of the scenario, if it comes from such.
    link_time_s
        (links,) seconds that an undisturbed vehicle needs for each link, where they were measured;
        else length and speed tell.
    link_free_s
        (links,) seconds of these that are free flow, beyond which time counts as lost, where they
        were measured; else length and speed tell.

    Raises
    ------
    InputError
        If the horizon is not a positive whole number, or no decision fits into it.
    """

    name: str
    network: RoadNetwork
    demand: Demand
    timing: SignalTiming
    dynamics: QueueDynamics
    horizon_s: int
    sumo: SumoFiles | None = None
    link_time_s: tuple[float, ...] | None = None
    link_free_s: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        whole = isinstance(self.horizon_s, int) and not isinstance(self.horizon_s, bool)
        if not whole or self.horizon_s < self.timing.decision_interval_s:
            raise InputError(
                f"the horizon is {self.horizon_s!r} s",
                where=f"scenario {self.name}",
                expected="a whole number of seconds, at least one decision interval "
                f"({self.timing.decision_interval_s} s)",
            )
