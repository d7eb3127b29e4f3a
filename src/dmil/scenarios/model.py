"""What a scenario is: network, demand, signal timing, queue dynamics, horizon."""

from __future__ import annotations

from dataclasses import dataclass

from pydantic import BaseModel, ConfigDict, Field

from dmil.demand.vehicles import Demand
from dmil.network.model import RoadNetwork


class SignalTiming(BaseModel):
    """When signals may change, in whole seconds (steps of the simulator)."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    decision_interval_s: int = Field(
        default=10, ge=1, description="Seconds between two decisions of a controller (paper: 10)."
    )
    clearance_s: int = Field(
        default=0,
        ge=0,
        description="Seconds of yellow and all-red after a change of phase, in which only "
        "unsignalled movements go (paper: none).",
    )
    min_green_s: int = Field(
        default=0, ge=0, description="Least seconds a phase is green before it may end."
    )
    startup_lost_s: int = Field(
        default=0,
        ge=0,
        description="Seconds at the begin of green in which a newly served queue does not move.",
    )


class QueueDynamics(BaseModel):
    """How queues discharge and fill."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    saturation_flow_veh_per_s: float = Field(
        default=1.0,
        gt=0,
        allow_inf_nan=False,
        description="Vehicles per second and lane that a served queue discharges (paper's v*).",
    )
    storage: bool = Field(
        default=False, description="Whether links have finite room, so that queues spill back."
    )
    vehicle_space_m: float = Field(
        default=7.5,
        gt=0,
        allow_inf_nan=False,
        description="Metres of one lane that a standing vehicle takes, gap included.",
    )


@dataclass(frozen=True)
class Scenario:
    """Everything a simulator needs but the seed and the controller.

    Parameters
    ----------
    name
        Name as given to ``scenario``.
    network, demand, timing, dynamics
        Its parts.
    horizon_s
        Length of a run in seconds.
    """

    name: str
    network: RoadNetwork
    demand: Demand
    timing: SignalTiming
    dynamics: QueueDynamics
    horizon_s: int
